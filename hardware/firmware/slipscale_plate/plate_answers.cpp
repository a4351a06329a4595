// The board's answers to queries.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "plate_board.h"
#include "plate_text.h"

namespace slipscale {
namespace {

constexpr const char* kStates[] = {"OFF",  "RAMP", "HOLD", "SAT", "LIST",
                                   "OPEN", "WDOG", "HOT",  "LONG"};

}  // namespace

const char* Board::state() const { return kStates[static_cast<int>(state_)]; }

int Board::tell_identity(const Call& call) {
  strcpy(call.value, settings_.identity);
  return kOk;
}

void Board::note(int code) {
  if (error_count_ == kErrors) memmove(errors_, errors_ + 1, --error_count_ * sizeof errors_[0]);
  errors_[error_count_++] = code;
}

int Board::tell_error(const Call& call) {
  const int code = error_count_ ? errors_[0] : kOk;
  if (error_count_) memmove(errors_, errors_ + 1, --error_count_ * sizeof errors_[0]);
  sprintf(call.value, "%d,\"%s\"", code, meaning(code));
  return kOk;
}

int Board::tell_limits(const Call& call) {
  const Limits& limits = settings_.limits;
  const float numbers[] = {limits.amplitude_um_pp, limits.voltage_v, limits.frequency_min_hz,
                           limits.frequency_max_hz};
  const int decimals[] = {4, 3, 1, 1};
  char* end = call.value;
  for (size_t i = 0; i < 4; ++i) {
    end = append_fixed(end, numbers[i], decimals[i]);
    *end++ = ',';
  }
  sprintf(end, "%lu,%lu", static_cast<unsigned long>(limits.watchdog_ms),
          static_cast<unsigned long>(limits.on_time_s));
  return kOk;
}

// The unit of amplitudes: this board measures vibration.
int Board::tell_unit(const Call& call) {
  strcpy(call.value, "um_pp");
  return kOk;
}

int Board::tell_list_limits(const Call& call) {
  char* end = call.value + sprintf(call.value, "%u,", static_cast<unsigned>(AmplitudeList::kPoints));
  end = append_fixed(end, settings_.limits.list_step_ms, 3);
  *end++ = ',';
  append_fixed(end, settings_.limits.list_edge_ms, 3);
  return kOk;
}

// While a list is played, amplitudes are means over its last complete period, and the voltage is
// the largest.
int Board::tell_status(const Call& call) {
  const bool open = state_ == State::kOpen;
  const float largest_v = fminf(largest_um_pp_ * volts_per_um_, settings_.limits.voltage_v);
  const float numbers[] = {target_um_pp_, playing_ ? mean_um_pp_ : hal_.amplitude_um_pp(),
                           open ? frequency_hz_ : hal_.resonance_hz(),
                           playing_ ? largest_v : voltage_v_, hal_.temperature_c()};
  const int decimals[] = {4, 4, 1, 3, 1};
  char* end = call.value + sprintf(call.value, "%s", state());
  for (size_t i = 0; i < 5; ++i) {
    *end++ = ',';
    end = append_fixed(end, numbers[i], decimals[i]);
  }
  return kOk;
}

}  // namespace slipscale
