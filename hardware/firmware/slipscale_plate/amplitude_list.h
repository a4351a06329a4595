// A list of amplitudes that is played repeatedly, with its position and the amplitude due there.
#ifndef SLIPSCALE_AMPLITUDE_LIST_H
#define SLIPSCALE_AMPLITUDE_LIST_H

#include <stddef.h>
#include <stdint.h>

namespace slipscale {

// The value at a fraction (0 to 1) of an edge, a half cosine that avoids a click.
float along_edge(float start, float end, float part);

class AmplitudeList {
 public:
  static constexpr size_t kPoints = 64;
  static constexpr float kLargest = 6.5F;  // µm peak to peak: 16 bits in units of 0.1 nm

  size_t size() const { return size_; }
  void clear() { size_ = 0; }
  // Keep the first `kept` points, append these, and drop the rest. The caller has checked that
  // there is room and that the points are from 0 to kLargest.
  void put(size_t kept, const float* um_pp, size_t count);
  float mean_um_pp() const;
  float largest_um_pp() const;

  // Start with the first point, coming from this amplitude.
  void start(float from_um_pp, uint32_t step_us, uint32_t edge_us);
  // Advance the time. Returns whether a period has ended.
  bool advance(uint32_t elapsed_us);
  // The amplitude due now: a half cosine on an edge, then constant.
  float due_um_pp() const;

 private:
  float point_um_pp(size_t place) const { return points_[place] * 1e-4F; }

  uint16_t points_[kPoints] = {};  // in units of 0.1 nm, to save memory
  size_t size_ = 0, place_ = 0;
  uint32_t step_us_ = 1, edge_us_ = 1, in_step_us_ = 0;
  float before_um_pp_ = 0;
};

}  // namespace slipscale

#endif
