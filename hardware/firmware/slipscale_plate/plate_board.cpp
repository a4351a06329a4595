#include "plate_board.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "plate_text.h"

namespace slipscale {
namespace {

constexpr uint32_t kRampMs = 25, kRampDownMs = 15, kCorrectMs = 10;
constexpr uint32_t kFollowMs = 5;  // after a correction, wait for the plate before measuring
constexpr float kLargestCorrection = 0.05F;  // of the voltage per step, to avoid a click
// Largest correction factor of the calibrated volts per µm. A finger that reduces Q from 60 to 50
// requires 1.2. Without a limit, a dead sensor would drive the plate to the voltage limit.
constexpr float kGainBand = 1.5F;
// Settled: kMeansSettled consecutive means within the band, a fraction of the target or µm p-p.
constexpr float kBand = 0.025F, kBandUm = 0.025F;
constexpr uint8_t kMeansSettled = 2;
constexpr size_t kPointsALine = 8;

}  // namespace

// The commands: header, fewest and most arguments, and action.
const Board::Command Board::kCommands[] = {
    {"*IDN?", 0, 0, &Board::tell_identity},
    {"*RST", 0, 0, &Board::reset},
    {"SYST:ERR?", 0, 0, &Board::tell_error},
    {"LIM?", 0, 0, &Board::tell_limits},
    {"UNIT?", 0, 0, &Board::tell_unit},
    {"AMPL", 1, 1, &Board::set_amplitude},
    {"DRIV", 2, 2, &Board::set_open_loop},
    {"OUTP", 1, 1, &Board::set_output},
    {"LIST:LIM?", 0, 0, &Board::tell_list_limits},
    {"LIST:AMPL", 2, 1 + kPointsALine, &Board::fill_list},
    {"LIST:PLAY", 3, 3, &Board::play_list},
    {"STAT?", 0, 0, &Board::tell_status},
};

// The byte '!' silences the plate and clears the line, so that earlier bytes cannot become a command.
const char* Board::receive(uint8_t byte, uint32_t now_ms) {
  if (byte == '!') {
    silence();
    length_ = 0;
  } else if (byte == '\n') {
    const char* answer = nullptr;
    if (length_ <= kLongest) {
      buffer_[length_] = '\0';
      answer = line(now_ms);
    }
    length_ = 0;
    return answer;
  } else if (length_ <= kLongest) {
    constexpr char kUnprintable = 0x7F;  // a zero would end the text
    buffer_[length_++] = byte ? static_cast<char>(byte) : kUnprintable;
  }
  return nullptr;
}

void Board::tick(uint32_t now_ms) {
  if (!vibrates()) return;
  if (now_ms - heard_ms_ > settings_.limits.watchdog_ms) {
    stop(State::kWdog);
  } else if (now_ms - commanded_ms_ > settings_.limits.on_time_s * 1000) {
    stop(State::kLong);
  } else if (hal_.temperature_c() > settings_.hottest_c) {
    stop(State::kHot);
  } else if (state_ == State::kRamp && !arrived_) {
    ramp(now_ms);
  } else if (playing_) {
    play(now_ms);
  } else if (state_ != State::kOpen) {
    hold(now_ms);
  }
}

void Board::silence() { stop(State::kOff); }

bool Board::vibrates() const {
  return state_ == State::kRamp || state_ == State::kHold || state_ == State::kSat ||
         state_ == State::kList || state_ == State::kOpen;
}

void Board::stop(State why) {
  voltage_v_ = target_um_pp_ = now_um_pp_ = 0;
  volts_per_um_ = 1 / settings_.gain_um_pp_per_v;
  playing_ = limited_ = false;
  hal_.off();
  state_ = why;
}

const char* Board::line(uint32_t now_ms) {
  while (length_ > 0 && buffer_[length_ - 1] == '\r') buffer_[--length_] = '\0';
  if (strcmp(buffer_, "*IDN?") == 0) {  // unframed, for people with a terminal
    // Keep the last answer, because its command may be repeated; the line buffer can be reused.
    snprintf(buffer_, sizeof buffer_, "%s\r\n", settings_.identity);
    return buffer_;
  }
  char* frame = strrchr(buffer_, '>');
  char* star = frame ? strrchr(frame, '*') : nullptr;
  if (!star || strlen(star) != 5) return nullptr;
  char expected[6];
  snprintf(expected, sizeof expected, "*%04X",
           static_cast<unsigned>(crc16(frame + 1, static_cast<size_t>(star - frame - 1))));
  if (strcmp(star, expected) != 0) return nullptr;
  *star = '\0';
  char* space = strchr(frame, ' ');
  if (!space || !space[1] || !sequence_number(frame + 1, space) || !printable(space)) return nullptr;
  heard_ms_ = now_ms;
  if (strcmp(frame, last_command_) == 0) return reply_;  // a repetition: already executed
  strcpy(last_command_, frame);
  tick(now_ms);
  *space = '\0';
  char value[kValue] = "";
  const int code = obey(space + 1, value, now_ms);
  if (code != kOk) {
    note(code);
    strcpy(value, meaning(code));
  }
  int size = snprintf(reply_, sizeof reply_ - 8, "<%s %08lX %d %s", frame + 1,
                      static_cast<unsigned long>(boot_), code, value);
  snprintf(reply_ + size, 8, "*%04X\n",
           static_cast<unsigned>(crc16(reply_ + 1, static_cast<size_t>(size - 1))));
  return reply_;
}

int Board::obey(char* body, char* value, uint32_t now_ms) {
  char* text = strchr(body, ' ');
  if (text) *text++ = '\0';
  for (const Command& each : kCommands) {
    if (strcmp(body, each.header) != 0) continue;
    char* texts[1 + kPointsALine];
    const size_t count = split(text, texts, 1 + kPointsALine);
    if (count < each.fewest) return kMissing;
    if (count > each.most) return kDataType;
    return (this->*each.run)(Call{texts, count, value, now_ms});
  }
  return kUndefined;
}

int Board::reset(const Call&) {
  silence();
  error_count_ = 0;
  list_.clear();
  return kOk;
}

int Board::set_amplitude(const Call& call) {
  float amplitude_um_pp = 0;
  const int code = within(call.texts[0], 0, settings_.limits.amplitude_um_pp, &amplitude_um_pp);
  if (code != kOk) return code;
  if (too_hot()) return kTooHot;
  from_um_pp_ = now_um_pp_;
  target_um_pp_ = amplitude_um_pp;
  commanded_ms_ = call.now_ms;
  arrived_ = playing_ = false;
  means_inside_ = 0;
  if (amplitude_um_pp == 0 && from_um_pp_ == 0) {
    silence();
  } else {
    state_ = State::kRamp;
  }
  return kOk;
}

int Board::set_open_loop(const Call& call) {
  const Limits& limits = settings_.limits;
  float frequency_hz = 0, voltage_v = 0;
  int code = within(call.texts[0], limits.frequency_min_hz, limits.frequency_max_hz, &frequency_hz);
  if (code == kOk) code = within(call.texts[1], 0, limits.voltage_v, &voltage_v);
  if (code != kOk) return code;
  if (too_hot()) return kTooHot;
  state_ = State::kOpen;
  target_um_pp_ = now_um_pp_ = 0;
  playing_ = false;
  commanded_ms_ = call.now_ms;
  frequency_hz_ = frequency_hz;
  voltage_v_ = voltage_v;
  hal_.drive(frequency_hz_, voltage_v_);
  return kOk;
}

int Board::set_output(const Call& call) {
  if (strcmp(call.texts[0], "OFF") != 0 && strcmp(call.texts[0], "0") != 0) return kRange;
  silence();
  return kOk;
}

int Board::fill_list(const Call& call) {
  size_t first = 0;
  int code = whole_within(call.texts[0], 1, list_.size() + 1, &first);
  float um_pp[kPointsALine];
  const size_t count = call.count - 1, kept = first - 1;
  const float largest_um_pp = fminf(settings_.limits.amplitude_um_pp, AmplitudeList::kLargest);
  for (size_t i = 0; i < count && code == kOk; ++i) {
    code = within(call.texts[1 + i], 0, largest_um_pp, &um_pp[i]);
  }
  if (code != kOk) return code;
  if (kept + count > AmplitudeList::kPoints) return kRange;
  if (playing_) return kConflict;
  list_.put(kept, um_pp, count);
  return kOk;
}

int Board::play_list(const Call& call) {
  const Limits& limits = settings_.limits;
  size_t count = 0;
  float step_ms = 0, edge_ms = 0;
  int code = whole_within(call.texts[0], 2, AmplitudeList::kPoints, &count);
  const float longest_ms = static_cast<float>(limits.on_time_s) * 1000;
  if (code == kOk) code = within(call.texts[1], limits.list_step_ms, longest_ms, &step_ms);
  if (code == kOk) code = within(call.texts[2], limits.list_edge_ms, step_ms, &edge_ms);
  if (code != kOk) return code;
  if (too_hot()) return kTooHot;
  if (state_ != State::kHold || count != list_.size()) return kConflict;
  list_.start(target_um_pp_, static_cast<uint32_t>(lroundf(step_ms * 1000)),
              static_cast<uint32_t>(lroundf(edge_ms * 1000)));
  mean_um_pp_ = hal_.amplitude_um_pp();
  target_um_pp_ = list_.mean_um_pp();
  largest_um_pp_ = list_.largest_um_pp();
  commanded_ms_ = played_ms_ = call.now_ms;
  playing_ = first_period_ = true;
  measured_um_ms_ = driven_um_ms_ = 0;
  state_ = State::kList;
  return kOk;
}

bool Board::too_hot() {
  if (hal_.temperature_c() <= settings_.hottest_c) return false;
  stop(State::kHot);
  return true;
}

// Times after the ramp count from when its end actually reached the plate, so that a late call of
// tick is not mistaken for a settled plate.
void Board::ramp(uint32_t now_ms) {
  const uint32_t elapsed_ms = now_ms - commanded_ms_;
  const float part = elapsed_ms >= kRampMs ? 1 : static_cast<float>(elapsed_ms) / kRampMs;
  now_um_pp_ = along_edge(from_um_pp_, target_um_pp_, part);
  frequency_hz_ = hal_.resonance_hz();
  apply();
  arrived_ = elapsed_ms >= kRampMs;
  begin_mean(now_ms);
}

void Board::begin_mean(uint32_t now_ms) {
  corrected_ms_ = now_ms;
  sum_um_pp_ = 0;
  readings_ = 0;
}

// Follow the resonance, and correct the voltage in small steps towards the amplitude due, by the
// mean of the readings since the last correction took effect.
void Board::hold(uint32_t now_ms) {
  const uint32_t elapsed_ms = now_ms - corrected_ms_;
  if (target_um_pp_ == 0) {
    if (elapsed_ms >= kRampDownMs) silence();
    return;
  }
  if (elapsed_ms <= kFollowMs) return;
  sum_um_pp_ += hal_.amplitude_um_pp();
  ++readings_;
  if (elapsed_ms < kCorrectMs) return;
  const float measured_um_pp = sum_um_pp_ / static_cast<float>(readings_);
  const bool was_limited = limited_;
  limited_ = !correct(measured_um_pp, target_um_pp_);
  frequency_hz_ = hal_.resonance_hz();
  apply();
  begin_mean(now_ms);
  state_ = settled(measured_um_pp, was_limited);
}

// The state for a mean: HOLD after several means within the band, SAT if the voltage is at its
// limit, otherwise RAMP.
Board::State Board::settled(float measured_um_pp, bool was_limited) {
  const float band_um = fmaxf(kBand * target_um_pp_, kBandUm);
  const float short_by_um = target_um_pp_ - measured_um_pp;
  if (fabsf(short_by_um) > band_um) {
    means_inside_ = 0;
    return was_limited && short_by_um > 0 ? State::kSat : State::kRamp;
  }
  if (means_inside_ < kMeansSettled) ++means_inside_;
  return means_inside_ < kMeansSettled ? State::kRamp : State::kHold;
}

// The list follows the clock. The voltage is corrected by the mean over each complete period, which
// a ringing plate preserves. It is compared with what was driven, so that a late tick is not
// mistaken for a weak plate. The first period does not count, because it starts at the settled mean.
void Board::play(uint32_t now_ms) {
  const uint32_t elapsed_ms = now_ms - played_ms_;
  if (elapsed_ms == 0) return;
  played_ms_ = now_ms;
  const float measured_um_pp = hal_.amplitude_um_pp();
  measured_um_ms_ += measured_um_pp * static_cast<float>(elapsed_ms);
  driven_um_ms_ += now_um_pp_ * static_cast<float>(elapsed_ms);
  if (list_.advance(elapsed_ms * 1000)) {
    if (!first_period_ && driven_um_ms_ > 0) {
      mean_um_pp_ = target_um_pp_ * measured_um_ms_ / driven_um_ms_;
      state_ = correct(mean_um_pp_, largest_um_pp_) ? State::kList : State::kSat;
    }
    first_period_ = false;
    measured_um_ms_ = driven_um_ms_ = 0;
  }
  now_um_pp_ = list_.due_um_pp();
  // In a groove there is too little vibration to follow the phase.
  if (now_um_pp_ >= target_um_pp_) frequency_hz_ = hal_.resonance_hz();
  apply();
}

// Correct the voltage; return whether it suffices for the largest amplitude due.
bool Board::correct(float measured_um_pp, float largest_um_pp) {
  if (largest_um_pp <= 0) return true;
  float factor = measured_um_pp > 0 ? target_um_pp_ / measured_um_pp : 1 + kLargestCorrection;
  factor = fminf(fmaxf(factor, 1 - kLargestCorrection), 1 + kLargestCorrection);
  const float nominal = 1 / settings_.gain_um_pp_per_v;
  const float most = fminf(settings_.limits.voltage_v / largest_um_pp, kGainBand * nominal);
  volts_per_um_ = fminf(fmaxf(volts_per_um_ * factor, nominal / kGainBand), most);
  return volts_per_um_ < most;
}

void Board::apply() {
  voltage_v_ = fminf(now_um_pp_ * volts_per_um_, settings_.limits.voltage_v);
  hal_.drive(frequency_hz_, voltage_v_);
}

}  // namespace slipscale
