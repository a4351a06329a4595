// The driver board's rules: docs/board-protocol.md in C++, for any processor.
//
// Nothing here knows a pin or a library. The sketch (slipscale_plate.ino) hands in bytes, the
// time and a Hal; the host build (../host/replay.cpp) does the same on a desk computer.
#ifndef SLIPSCALE_PLATE_BOARD_H
#define SLIPSCALE_PLATE_BOARD_H

#include <stddef.h>
#include <stdint.h>

namespace slipscale {

// What the rules need of the electronics. Volts are peak, amplitudes peak to peak.
class Hal {
 public:
  // Drive with this frequency and voltage. 0 V must open the output stage, not only lower it.
  virtual void drive(float frequency_hz, float voltage_v) = 0;
  // The vibration sensor's amplitude, µm peak to peak.
  virtual float amplitude_um_pp() = 0;
  // The frequency at which the plate resonates now; called often while it vibrates.
  virtual float resonance_hz() = 0;
  virtual float temperature_c() = 0;

 protected:
  ~Hal() {}
};

struct Limits {
  float amplitude_um_pp = 2.5F;
  float voltage_v = 16.5F;
  float frequency_min_hz = 25000.0F;
  float frequency_max_hz = 40000.0F;
  uint32_t watchdog_ms = 500;
  uint32_t on_time_s = 600;
};

struct Settings {
  const char* identity = "Slipscale,slipscale-plate-1,EMULATED-1,1.0";
  float gain_um_pp_per_v = 2.3F / 15.0F;  // from slipscale plate calibrate
  float hottest_c = 60.0F;
  Limits limits;
};

class Board {
 public:
  Board(Hal& hal, const Settings& settings, uint32_t boot)
      : hal_(hal), settings_(settings), boot_(boot) {}

  // Take one byte from the line. Returns an answer to send, or nullptr.
  const char* receive(uint8_t byte, uint32_t now_ms);
  // Let time pass: call at least once a millisecond.
  void tick(uint32_t now_ms);
  // Switch the output off; also at start and when the line's DTR drops.
  void silence();

 private:
  enum class State : uint8_t { kOff, kRamp, kHold, kSat, kOpen, kWdog, kHot, kLong };
  static constexpr size_t kLongest = 96;
  static constexpr size_t kErrors = 8;

  bool vibrates() const;
  void stop(State why);
  const char* line(uint32_t now_ms);
  int obey(char* body, char* value, uint32_t now_ms);
  int set_amplitude(const char* text, uint32_t now_ms);
  int set_open_loop(char* text, uint32_t now_ms);
  void ramp(uint32_t now_ms);
  void hold();
  void write_status(char* value);
  void write_limits(char* value) const;
  void note(int code);

  Hal& hal_;
  const Settings settings_;
  const uint32_t boot_;
  State state_ = State::kOff;
  float target_um_pp_ = 0, from_um_pp_ = 0, voltage_v_ = 0, frequency_hz_ = 0;
  uint32_t heard_ms_ = 0, commanded_ms_ = 0, arrived_ms_ = 0, corrected_ms_ = 0;
  bool arrived_ = false;  // the end of the ramp is on the plate, since arrived_ms_
  char buffer_[kLongest + 1] = {};
  size_t length_ = 0;
  char last_command_[kLongest + 1] = {};
  char reply_[160] = {};
  int errors_[kErrors] = {};
  size_t error_count_ = 0;
};

}  // namespace slipscale

#endif
