// The driver board's rules: docs/reference/board-protocol.md in C++, for any processor.
//
// This code does not depend on pins or libraries. The sketch (slipscale_plate.ino) passes in bytes,
// the time and a Hal; the host builds (../host) do the same on a desktop computer.
#ifndef SLIPSCALE_PLATE_BOARD_H
#define SLIPSCALE_PLATE_BOARD_H

#include <stddef.h>
#include <stdint.h>

#include "amplitude_list.h"

namespace slipscale {

// The electronics, as used by the rules. Volts are peak, amplitudes peak to peak.
class Hal {
 public:
  // Drive with this frequency and voltage. 0 V (in a texture's grooves) keeps the stage closed.
  virtual void drive(float frequency_hz, float voltage_v) = 0;
  // Open the output stage.
  virtual void off() = 0;
  // The vibration sensor's amplitude, µm peak to peak.
  virtual float amplitude_um_pp() = 0;
  // The plate's current resonance; called often while it vibrates.
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
  float list_step_ms = 4.0F;  // shortest step of a list
  float list_edge_ms = 2.0F;  // at least three time constants of the plate: 3 Q / (pi f0)
};

struct Settings {
  const char* identity = "Slipscale,slipscale-plate-1,EMULATED-1,1.2";
  float gain_um_pp_per_v = 2.3F / 15.0F;  // from slipscale plate calibrate
  float hottest_c = 60.0F;
  Limits limits;
};

class Board {
 public:
  Board(Hal& hal, const Settings& settings, uint32_t boot)
      : hal_(hal),
        settings_(settings),
        boot_(boot),
        volts_per_um_(1 / settings.gain_um_pp_per_v) {}

  // Process one byte from the line. Returns an answer to send before the next byte, or nullptr.
  const char* receive(uint8_t byte, uint32_t now_ms);
  // Advance the time; call at least once per millisecond.
  void tick(uint32_t now_ms);
  // Switch the output off; also called at start and when the line's DTR drops.
  void silence();
  // The state as reported by STAT?.
  const char* state() const;
  // The target amplitude in STAT?, µm peak to peak.
  float target_um_pp() const { return target_um_pp_; }
  // The amplitude due now, on a ramp or in a list; 0 in open loop.
  float due_um_pp() const { return now_um_pp_; }

 private:
  enum class State : uint8_t { kOff, kRamp, kHold, kSat, kList, kOpen, kWdog, kHot, kLong };
  struct Call {
    char** texts;  // the arguments
    size_t count;
    char* value;  // of the answer
    uint32_t now_ms;
  };
  struct Command {
    const char* header;
    size_t fewest, most;
    int (Board::*run)(const Call& call);
  };
  static const Command kCommands[];
  static constexpr size_t kLongest = 96;
  static constexpr size_t kErrors = 8;
  static constexpr size_t kValue = 72;  // an answer's value; also the limit of the identity

  bool vibrates() const;
  void stop(State why);
  const char* line(uint32_t now_ms);
  int obey(char* body, char* value, uint32_t now_ms);
  int tell_identity(const Call& call);
  int reset(const Call& call);
  int tell_error(const Call& call);
  int tell_limits(const Call& call);
  int tell_unit(const Call& call);
  int tell_list_limits(const Call& call);
  int tell_status(const Call& call);
  int set_amplitude(const Call& call);
  int set_open_loop(const Call& call);
  int set_output(const Call& call);
  int fill_list(const Call& call);
  int play_list(const Call& call);
  bool too_hot();
  void ramp(uint32_t now_ms);
  void hold(uint32_t now_ms);
  void begin_mean(uint32_t now_ms);
  State settled(float measured_um_pp, bool was_limited);
  void play(uint32_t now_ms);
  bool correct(float measured_um_pp, float largest_um_pp);
  void apply();
  void note(int code);

  Hal& hal_;
  const Settings settings_;
  const uint32_t boot_;
  State state_ = State::kOff;
  float target_um_pp_ = 0, from_um_pp_ = 0, now_um_pp_ = 0, voltage_v_ = 0, frequency_hz_ = 0;
  float volts_per_um_;  // for the current load
  uint32_t heard_ms_ = 0, commanded_ms_ = 0, corrected_ms_ = 0, played_ms_ = 0;
  bool arrived_ = false;  // the ramp's end has reached the plate
  bool limited_ = false;  // the voltage is at its limit
  float sum_um_pp_ = 0;   // of the readings since the last correction took effect
  uint16_t readings_ = 0;
  uint8_t means_inside_ = 0;
  AmplitudeList list_;
  bool playing_ = false, first_period_ = false;
  float mean_um_pp_ = 0, largest_um_pp_ = 0, measured_um_ms_ = 0, driven_um_ms_ = 0;
  char buffer_[kLongest + 2] = {};  // one more than the longest line, to detect longer ones
  size_t length_ = 0;
  char last_command_[kLongest + 1] = {};
  char reply_[kValue + 32] = {};
  int errors_[kErrors] = {};
  size_t error_count_ = 0;
};

}  // namespace slipscale

#endif
