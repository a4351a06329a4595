#include "amplitude_list.h"

#include <math.h>

namespace slipscale {

float along_edge(float start, float end, float part) {
  const float share = 0.5F - 0.5F * cosf(3.14159265F * part);
  return start + share * (end - start);
}

void AmplitudeList::put(size_t kept, const float* um_pp, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    points_[kept + i] = static_cast<uint16_t>(lroundf(um_pp[i] * 1e4F));
  }
  size_ = kept + count;
}

float AmplitudeList::mean_um_pp() const {
  float sum_um_pp = 0;
  for (size_t i = 0; i < size_; ++i) sum_um_pp += point_um_pp(i);
  return sum_um_pp / static_cast<float>(size_);
}

float AmplitudeList::largest_um_pp() const {
  float largest_um_pp = 0;
  for (size_t i = 0; i < size_; ++i) largest_um_pp = fmaxf(largest_um_pp, point_um_pp(i));
  return largest_um_pp;
}

void AmplitudeList::start(float from_um_pp, uint32_t step_us, uint32_t edge_us) {
  before_um_pp_ = from_um_pp;
  step_us_ = step_us;
  edge_us_ = edge_us;
  place_ = 0;
  in_step_us_ = 0;
}

// The remaining time counts for the next step, so that no time is lost if the call is late.
bool AmplitudeList::advance(uint32_t elapsed_us) {
  bool ended = false;
  for (in_step_us_ += elapsed_us; in_step_us_ >= step_us_; in_step_us_ -= step_us_) {
    before_um_pp_ = point_um_pp(place_);
    if (++place_ == size_) {
      place_ = 0;
      ended = true;
    }
  }
  return ended;
}

float AmplitudeList::due_um_pp() const {
  const float level_um_pp = point_um_pp(place_);
  if (in_step_us_ >= edge_us_) return level_um_pp;
  const float part = static_cast<float>(in_step_us_) / static_cast<float>(edge_us_);
  return along_edge(before_um_pp_, level_um_pp, part);
}

}  // namespace slipscale
