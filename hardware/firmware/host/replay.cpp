// The firmware on a desktop computer: reads a transcript on standard input and prints the answers.
//
// "> text" passes a line to the board, ". 60" waits 60 ms; answers are printed as "< text". "= 60"
// waits 60 ms and prints the plate's state after each: "= driven amplitude", in µm peak to peak.
// "- 4" waits 4 ms during which the board is busy with something else.
// Build: g++ -std=c++11 -I ../slipscale_plate replay.cpp ../slipscale_plate/*.cpp -o replay
// Run: replay [TIME_CONSTANT_MS [GAIN]], the plate's; gain 1 is the firmware's own.
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>

#include "plate_board.h"

namespace {

// A plate that responds at once, or rings: the rules are tested here rather than the physics.
class DeskPlate : public slipscale::Hal {
 public:
  DeskPlate(double time_constant_ms, double gain)
      : gain_um_pp_per_v_(gain * 2.3 / 15),
        left_(time_constant_ms > 0 ? std::exp(-1 / time_constant_ms) : 0) {}

  void drive(float, float voltage_v) override { put(voltage_v); }
  void off() override { put(0); }
  float amplitude_um_pp() override { return static_cast<float>(amplitude_um_pp_); }
  float resonance_hz() override { return 30500.0F; }
  float temperature_c() override { return 22.0F; }

  void pass_a_millisecond() { ring(left_); }
  double driven_um_pp() const { return voltage_v_ * gain_um_pp_per_v_; }

 private:
  void put(float voltage_v) {
    voltage_v_ = voltage_v;
    if (left_ <= 0) ring(0);
  }
  void ring(double left) { amplitude_um_pp_ += (1 - left) * (driven_um_pp() - amplitude_um_pp_); }

  const double gain_um_pp_per_v_, left_;
  double voltage_v_ = 0, amplitude_um_pp_ = 0;
};

}  // namespace

int main(int count, char** words) {
  DeskPlate plate(count > 1 ? std::atof(words[1]) : 0, count > 2 ? std::atof(words[2]) : 1);
  slipscale::Board board(plate, slipscale::Settings(), 42);
  uint32_t now_ms = 0;
  std::string line;
  while (std::getline(std::cin, line)) {
    if (line.size() < 2) continue;
    const std::string text = line.substr(2);
    if (line[0] == '.' || line[0] == '=' || line[0] == '-') {
      for (long left = std::atol(text.c_str()); left > 0; --left) {
        plate.pass_a_millisecond();
        ++now_ms;
        if (line[0] != '-') board.tick(now_ms);
        const double amplitude_um_pp = static_cast<double>(plate.amplitude_um_pp());
        if (line[0] == '=') {
          std::cout << "= " << plate.driven_um_pp() << ' ' << amplitude_um_pp << '\n';
        }
      }
    } else if (line[0] == '>') {
      for (const char c : text + "\n") {
        const char* answer = board.receive(static_cast<uint8_t>(c), now_ms);
        if (answer) std::cout << "< " << answer << std::flush;
      }
    }
  }
}
