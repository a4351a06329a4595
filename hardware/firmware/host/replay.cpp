// The firmware on a desk computer: takes a transcript on standard input, answers on the output.
//
// "> text" hands a line to the board, ". 60" lets 60 ms pass; answers come as "< text".
// Build: g++ -std=c++11 -I ../slipscale_plate replay.cpp ../slipscale_plate/plate_board.cpp
#include <cstdlib>
#include <iostream>
#include <string>

#include "plate_board.h"

namespace {

// A plate that answers at once: what is tested here are the rules, not the physics.
class DeskPlate : public slipscale::Hal {
 public:
  void drive(float, float voltage_v) override { voltage_v_ = voltage_v; }
  float amplitude_um_pp() override { return voltage_v_ * 2.3F / 15.0F; }
  float resonance_hz() override { return 30500.0F; }
  float temperature_c() override { return 22.0F; }

 private:
  float voltage_v_ = 0;
};

}  // namespace

int main() {
  DeskPlate plate;
  slipscale::Board board(plate, slipscale::Settings(), 42);
  uint32_t now_ms = 0;
  std::string line;
  while (std::getline(std::cin, line)) {
    if (line.size() < 2) continue;
    const std::string text = line.substr(2);
    if (line[0] == '.') {
      for (long left = std::atol(text.c_str()); left > 0; --left) board.tick(++now_ms);
    } else if (line[0] == '>') {
      for (const char c : text + "\n") {
        const char* answer = board.receive(static_cast<uint8_t>(c), now_ms);
        if (answer) std::cout << "< " << answer << std::flush;
      }
    }
  }
}
