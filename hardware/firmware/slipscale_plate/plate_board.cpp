#include "plate_board.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

namespace slipscale {
namespace {

constexpr int kOk = 0, kDataType = -104, kMissing = -109, kUndefined = -113, kRange = -222;
constexpr int kTooHot = 101;
constexpr uint32_t kRampMs = 25, kSettleMs = 15, kCorrectMs = 10;
constexpr float kPi = 3.14159265F;
constexpr float kLargestCorrection = 0.05F;  // of the voltage, per kCorrectMs: no click

struct Meaning {
  int code;
  const char* text;
};
constexpr Meaning kMeanings[] = {
    {kOk, "No error"},
    {kDataType, "Data type error"},
    {kMissing, "Missing parameter"},
    {kUndefined, "Undefined header"},
    {kRange, "Data out of range"},
    {kTooHot, "Over temperature"},
};
constexpr const char* kStates[] = {"OFF", "RAMP", "HOLD", "SAT", "OPEN", "WDOG", "HOT", "LONG"};

const char* meaning(int code) {
  for (const Meaning& each : kMeanings) {
    if (each.code == code) return each.text;
  }
  return "Unknown error";
}

uint16_t crc16(const char* data, size_t length) {  // CRC-16/CCITT-FALSE
  uint16_t crc = 0xFFFF;
  for (size_t i = 0; i < length; ++i) {
    crc ^= static_cast<uint16_t>(static_cast<uint8_t>(data[i]) << 8);
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<uint16_t>((crc & 0x8000) ? (crc << 1) ^ 0x1021 : crc << 1);
    }
  }
  return crc;
}

// Small processors' printf knows no %f.
char* append_fixed(char* end, float value, int decimals) {
  long scale = 1;
  for (int i = 0; i < decimals; ++i) scale *= 10;
  const long scaled = lroundf(value * static_cast<float>(scale));
  const long size = scaled < 0 ? -scaled : scaled;
  end += sprintf(end, "%s%ld", scaled < 0 ? "-" : "", size / scale);
  if (decimals) end += sprintf(end, ".%0*ld", decimals, size % scale);
  return end;
}

bool digit(char c) { return c >= '0' && c <= '9'; }

// Plain decimals only: no exponent, no nan, no inf.
bool parse_number(const char* text, float* value) {
  const bool negative = *text == '-';
  if (*text == '-' || *text == '+') ++text;
  double result = 0, place = 1;
  int whole = 0, fraction = 0;
  for (; digit(*text); ++text, ++whole) result = result * 10 + (*text - '0');
  if (*text == '.') {
    for (++text; digit(*text); ++text, ++fraction) result += (*text - '0') * (place /= 10);
    if (fraction == 0) return false;
  }
  *value = static_cast<float>(negative ? -result : result);
  return *text == '\0' && whole > 0 && whole <= 7 && fraction <= 6;
}

int within(const char* text, float lowest, float highest, float* value) {
  if (!parse_number(text, value)) return kDataType;
  return *value >= lowest && *value <= highest ? kOk : kRange;
}

}  // namespace

const char* Board::receive(uint8_t byte, uint32_t now_ms) {
  if (byte == '!') {
    silence();
  } else if (byte == '\n') {
    buffer_[length_] = '\0';
    const char* answer = line(now_ms);
    length_ = 0;
    return answer;
  } else if (length_ < kLongest) {
    buffer_[length_++] = static_cast<char>(byte ? byte : '?');  // a zero would end the text
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
  } else if (state_ == State::kRamp) {
    ramp(now_ms);
  } else if (state_ != State::kOpen && now_ms - corrected_ms_ >= kCorrectMs) {
    corrected_ms_ = now_ms;
    hold();
  }
}

void Board::silence() { stop(State::kOff); }

bool Board::vibrates() const {
  return state_ == State::kRamp || state_ == State::kHold || state_ == State::kSat ||
         state_ == State::kOpen;
}

void Board::stop(State why) {
  voltage_v_ = target_um_pp_ = 0;
  hal_.drive(frequency_hz_, 0);
  state_ = why;
}

const char* Board::line(uint32_t now_ms) {
  while (length_ > 0 && buffer_[length_ - 1] == '\r') buffer_[--length_] = '\0';
  if (strcmp(buffer_, "*IDN?") == 0) {  // plain, for whoever looks with a terminal
    snprintf(reply_, sizeof reply_, "%s\r\n", settings_.identity);
    last_command_[0] = '\0';  // what was kept there is gone
    return reply_;
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
  if (!space || space == frame + 1 || space - frame > 6 || !space[1]) return nullptr;
  for (const char* c = frame + 1; c < space; ++c) {
    if (!digit(*c)) return nullptr;
  }
  heard_ms_ = now_ms;
  if (strcmp(frame, last_command_) == 0) return reply_;  // a repetition: it ran before
  strcpy(last_command_, frame);
  tick(now_ms);
  *space = '\0';
  char value[96] = "";
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
  char* arguments = strchr(body, ' ');
  if (arguments) *arguments++ = '\0';
  const bool asked_with = arguments && *arguments;
  const bool is_amplitude = strcmp(body, "AMPL") == 0, is_output = strcmp(body, "OUTP") == 0;
  if (is_amplitude || is_output || strcmp(body, "DRIV") == 0) {
    if (!asked_with) return kMissing;
    if (is_amplitude) return set_amplitude(arguments, now_ms);
    if (!is_output) return set_open_loop(arguments, now_ms);
    if (strchr(arguments, ',')) return kDataType;
    if (strcmp(arguments, "OFF") != 0 && strcmp(arguments, "0") != 0) return kRange;
    silence();
    return kOk;
  }
  const char* const queries[] = {"*IDN?", "*RST", "SYST:ERR?", "LIM?", "STAT?"};
  int which = 0;
  while (which < 5 && strcmp(body, queries[which]) != 0) ++which;
  if (which == 5) return kUndefined;
  if (asked_with) return kDataType;
  switch (which) {
    case 0:
      strcpy(value, settings_.identity);
      break;
    case 1:
      silence();
      error_count_ = 0;
      break;
    case 2: {
      const int code = error_count_ ? errors_[0] : kOk;
      if (error_count_) memmove(errors_, errors_ + 1, --error_count_ * sizeof errors_[0]);
      sprintf(value, "%d,\"%s\"", code, meaning(code));
      break;
    }
    case 3:
      write_limits(value);
      break;
    default:
      write_status(value);
  }
  return kOk;
}

int Board::set_amplitude(const char* text, uint32_t now_ms) {
  float amplitude_um_pp = 0;
  const int code = within(text, 0, settings_.limits.amplitude_um_pp, &amplitude_um_pp);
  if (code != kOk) return code;
  if (hal_.temperature_c() > settings_.hottest_c) {
    stop(State::kHot);
    return kTooHot;
  }
  from_um_pp_ = state_ == State::kOpen ? 0 : target_um_pp_;
  target_um_pp_ = amplitude_um_pp;
  commanded_ms_ = now_ms;
  arrived_ = false;
  if (amplitude_um_pp == 0 && from_um_pp_ == 0) {
    silence();
  } else {
    state_ = State::kRamp;
  }
  return kOk;
}

int Board::set_open_loop(char* text, uint32_t now_ms) {
  char* comma = strchr(text, ',');
  if (!comma) return kMissing;
  *comma = '\0';
  if (strchr(comma + 1, ',')) return kDataType;
  const Limits& limits = settings_.limits;
  float frequency_hz = 0, voltage_v = 0;
  int code = within(text, limits.frequency_min_hz, limits.frequency_max_hz, &frequency_hz);
  if (code == kOk) code = within(comma + 1, 0, limits.voltage_v, &voltage_v);
  if (code != kOk) return code;
  if (hal_.temperature_c() > settings_.hottest_c) {
    stop(State::kHot);
    return kTooHot;
  }
  state_ = State::kOpen;
  target_um_pp_ = 0;
  commanded_ms_ = now_ms;
  frequency_hz_ = frequency_hz;
  voltage_v_ = voltage_v;
  hal_.drive(frequency_hz_, voltage_v_);
  return kOk;
}

// Settling counts from when the end of the ramp was really put on the plate: a late call of tick
// must not pass for a settled plate.
void Board::ramp(uint32_t now_ms) {
  if (arrived_) {
    if (now_ms - arrived_ms_ < kSettleMs) return;
    if (target_um_pp_ == 0) {
      silence();
    } else {
      hold();
    }
    return;
  }
  const uint32_t elapsed_ms = now_ms - commanded_ms_;
  const float part = elapsed_ms >= kRampMs ? 1 : static_cast<float>(elapsed_ms) / kRampMs;
  const float share = 0.5F - 0.5F * cosf(kPi * part);
  const float now_um_pp = from_um_pp_ + share * (target_um_pp_ - from_um_pp_);
  frequency_hz_ = hal_.resonance_hz();
  voltage_v_ = fminf(now_um_pp / settings_.gain_um_pp_per_v, settings_.limits.voltage_v);
  hal_.drive(frequency_hz_, voltage_v_);
  arrived_ = elapsed_ms >= kRampMs;
  arrived_ms_ = now_ms;
}

// Follow the resonance and correct the voltage a little towards the amplitude that is due.
void Board::hold() {
  const float measured_um_pp = hal_.amplitude_um_pp();
  float factor = measured_um_pp > 0 ? target_um_pp_ / measured_um_pp : 1 + kLargestCorrection;
  factor = fminf(fmaxf(factor, 1 - kLargestCorrection), 1 + kLargestCorrection);
  frequency_hz_ = hal_.resonance_hz();
  voltage_v_ = fminf(voltage_v_ * factor, settings_.limits.voltage_v);
  hal_.drive(frequency_hz_, voltage_v_);
  state_ = voltage_v_ >= settings_.limits.voltage_v ? State::kSat : State::kHold;
}

void Board::write_status(char* value) {
  const bool open = state_ == State::kOpen;
  char* end = value + sprintf(value, "%s,", kStates[static_cast<int>(state_)]);
  end = append_fixed(end, target_um_pp_, 4);
  *end++ = ',';
  end = append_fixed(end, hal_.amplitude_um_pp(), 4);
  *end++ = ',';
  end = append_fixed(end, open ? frequency_hz_ : hal_.resonance_hz(), 1);
  *end++ = ',';
  end = append_fixed(end, voltage_v_, 3);
  *end++ = ',';
  append_fixed(end, hal_.temperature_c(), 1);
}

void Board::write_limits(char* value) const {
  const Limits& limits = settings_.limits;
  char* end = append_fixed(value, limits.amplitude_um_pp, 4);
  *end++ = ',';
  end = append_fixed(end, limits.voltage_v, 3);
  *end++ = ',';
  end = append_fixed(end, limits.frequency_min_hz, 1);
  *end++ = ',';
  end = append_fixed(end, limits.frequency_max_hz, 1);
  sprintf(end, ",%lu,%lu", static_cast<unsigned long>(limits.watchdog_ms),
          static_cast<unsigned long>(limits.on_time_s));
}

void Board::note(int code) {
  if (error_count_ == kErrors) memmove(errors_, errors_ + 1, --error_count_ * sizeof errors_[0]);
  errors_[error_count_++] = code;
}

}  // namespace slipscale
