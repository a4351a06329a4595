// Runs the firmware with random inputs under a compiler's sanitizers.
//
// Each input is a separate session with a new board: correct, wrong, broken, repeated and truncated
// frames, bytes of any value, and any time in between. In addition to the sanitizers, four rules
// are checked after every byte and every millisecond: the drive stays within the limits; answers
// end with a line end and fit in a line; the output is off after '!', and after the watchdog's time
// without a correct frame.
// Build: g++ -std=c++11 -g -O1 -fsanitize=address,undefined -fno-sanitize-recover=all
//        -I ../slipscale_plate fuzz.cpp ../slipscale_plate/*.cpp -o fuzz
// Run: fuzz [INPUTS [SEED]]; exit status 1 and the input's number if a rule is broken.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>

#include "plate_board.h"
#include "plate_text.h"

namespace {

// From docs/reference/board-protocol.md, not from the firmware's own constants.
constexpr float kHighestV = 16.5F, kLowestHz = 25000.0F, kHighestHz = 40000.0F;
constexpr uint32_t kWatchdogMs = 500;
constexpr float kHair = 1e-3F;
constexpr size_t kLongestAnswer = 104;  // kValue and the frame around it
constexpr uint32_t kLateMs = 2;         // the watchdog is checked once per millisecond

class WatchedPlate : public slipscale::Hal {
 public:
  void drive(float frequency_hz, float voltage_v) override {
    on = true;
    within = within && voltage_v >= 0 && voltage_v <= kHighestV + kHair &&
             frequency_hz >= kLowestHz && frequency_hz <= kHighestHz;
    amplitude = gain * voltage_v;
  }
  void off() override {
    on = false;
    amplitude = 0;
  }
  float amplitude_um_pp() override { return amplitude; }
  float resonance_hz() override { return 30500.0F; }
  float temperature_c() override { return temperature; }

  bool on = false, within = true;
  float amplitude = 0, gain = 2.3F / 15.0F, temperature = 22.0F;
};

class Input {
 public:
  Input(uint64_t seed, uint64_t number)
      : chance_(static_cast<uint32_t>(seed * 0x9E3779B9U + number)),
        boot_(below(0xFFFFFFFFU)),
        now_ms_(below(4) ? below(1000) : 0xFFFFFFFFU - below(1000)),
        board_(plate_, slipscale::Settings(), boot_) {
    plate_.gain *= static_cast<float>(below(20)) / 10;
  }

  // Return the rule that was broken, or nullptr.
  const char* run() {
    heard_ms_ = now_ms_;
    for (unsigned left = 1 + below(24); left > 0 && !broken_; --left) {
      plate_.temperature = below(60) ? 22.0F : 75.0F;
      if (below(3)) {
        say(spoiled(frame()));
      } else {
        pass(below(5) ? below(40) : below(900));
      }
    }
    return broken_;
  }

 private:
  unsigned below(unsigned limit) { return static_cast<unsigned>(chance_() % limit); }

  std::string number() {
    static const char* const kOdd[] = {"0",   "2.5",  "2.51", "-1",  "nan", "1e9", "",
                                       "1.",  ".5",   "+1",   "16.5", "25000", "40000",
                                       "64",  "65",   "700000", "00000001", "4294967296"};
    if (below(3) == 0) return kOdd[below(sizeof kOdd / sizeof *kOdd)];
    char text[32];
    snprintf(text, sizeof text, "%.*f", static_cast<int>(below(6)), below(3000) / 1000.0);
    return text;
  }

  std::string body() {
    static const char* const kHeaders[] = {"*IDN?", "*RST", "SYST:ERR?", "LIM?", "AMPL", "AMPL",
                                           "DRIV", "OUTP", "LIST:LIM?", "LIST:AMPL", "LIST:AMPL",
                                           "LIST:PLAY", "STAT?", "FOO"};
    switch (below(8)) {
      case 0: return "OUTP " + std::string(below(2) ? "OFF" : "0");
      case 1: return "DRIV " + std::to_string(25000 + below(15001)) + "," + number();
      case 2: return "LIST:AMPL 1," + number() + ",0.5,1.5";
      case 3: return "LIST:PLAY " + std::to_string(below(70)) + "," + number() + ",2";
      default: break;
    }
    std::string text = kHeaders[below(sizeof kHeaders / sizeof *kHeaders)];
    for (unsigned left = below(11), first = 1; left > 0; --left, first = 0) {
      text += (first ? " " : ",") + number();
    }
    return text;
  }

  std::string frame() {
    if (below(30) == 0) return "*IDN?\n";
    if (last_.size() && below(6) == 0) return last_;
    std::string text = std::to_string(below(below(10) ? 65536 : 100000)) + " " + body();
    char check[8];
    snprintf(check, sizeof check, "*%04X",
             static_cast<unsigned>(slipscale::crc16(text.data(), text.size())));
    return last_ = ">" + text + check + "\n";
  }

  std::string spoiled(std::string text) {
    if (below(2)) return text;
    for (unsigned left = 1 + below(4); left > 0; --left) {
      const size_t at = text.empty() ? 0 : below(static_cast<unsigned>(text.size()));
      const char any = static_cast<char>(below(256));
      switch (below(6)) {
        case 0: text.insert(at, 1, any); break;
        case 1: text.erase(at, 1 + below(5)); break;
        case 2: if (!text.empty()) text[at] = any; break;
        case 3: text.insert(at, 1, '!'); break;
        case 4: text.insert(at, std::string(below(200), any)); break;
        default: text += frame(); break;
      }
    }
    return text;
  }

  void say(const std::string& text) {
    for (const char each : text) {
      const char* answer = board_.receive(static_cast<uint8_t>(each), now_ms_);
      if (answer) {
        const size_t length = strlen(answer);
        if (length == 0 || length > kLongestAnswer || answer[length - 1] != '\n') {
          broken_ = "an answer fits a line and ends it";
        }
        // A framed answer means that the frame was correct, even if the command was rejected.
        if (answer[0] == '<') heard_ms_ = now_ms_;
      }
      if (each == '!' && plate_.on) broken_ = "'!' leaves the output off";
      look();
    }
  }

  void pass(unsigned duration_ms) {
    for (; duration_ms > 0 && !broken_; --duration_ms) {
      board_.tick(++now_ms_);
      look();
    }
  }

  void look() {
    if (!plate_.within) broken_ = "what is driven stays within the limits";
    if (plate_.on && now_ms_ - heard_ms_ > kWatchdogMs + kLateMs) {
      broken_ = "the output is off after the watchdog's time";
    }
  }

  std::mt19937 chance_;
  const uint32_t boot_;
  uint32_t now_ms_, heard_ms_ = 0;
  WatchedPlate plate_;
  slipscale::Board board_;
  std::string last_;
  const char* broken_ = nullptr;
};

}  // namespace

int main(int count, char** words) {
  const uint64_t inputs = count > 1 ? std::strtoull(words[1], nullptr, 10) : 100000;
  const uint64_t seed = count > 2 ? std::strtoull(words[2], nullptr, 10) : 1;
  for (uint64_t number = 0; number < inputs; ++number) {
    Input input(seed, number);
    if (const char* rule = input.run()) {
      std::printf("input %llu of seed %llu breaks a rule: %s\n",
                  static_cast<unsigned long long>(number), static_cast<unsigned long long>(seed),
                  rule);
      return 1;
    }
  }
  std::printf("%llu inputs, no finding\n", static_cast<unsigned long long>(inputs));
}
