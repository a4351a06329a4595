// A list of amplitudes that is played over and over: where it is, and what is due there.
#ifndef SLIPSCALE_AMPLITUDE_LIST_H
#define SLIPSCALE_AMPLITUDE_LIST_H

#include <stddef.h>
#include <stdint.h>

namespace slipscale {

// What is due after a part (0 to 1) of an edge: half a period of a cosine, no click.
float along_edge(float start, float end, float part);

class AmplitudeList {
 public:
  static constexpr size_t kPoints = 64;
  static constexpr float kLargest = 6.5F;  // µm peak to peak: 16 bits of a tenth of a nanometre

  size_t size() const { return size_; }
  void clear() { size_ = 0; }
  // Keep so many, put these behind them, forget the rest. The caller has checked the room, and
  // that they lie from 0 to kLargest.
  void put(size_t kept, const float* um_pp, size_t count);
  float mean_um_pp() const;
  float largest_um_pp() const;

  // Begin with the first, coming from this amplitude.
  void start(float from_um_pp, uint32_t step_us, uint32_t edge_us);
  // Let time pass. Returns whether a period has come to its end.
  bool advance(uint32_t elapsed_us);
  // The amplitude that is due now: on an edge half a period of a cosine, then level.
  float due_um_pp() const;

 private:
  float point_um_pp(size_t place) const { return points_[place] * 1e-4F; }

  uint16_t points_[kPoints] = {};  // 0.1 nm: memory is short
  size_t size_ = 0, place_ = 0;
  uint32_t step_us_ = 1, edge_us_ = 1, in_step_us_ = 0;
  float before_um_pp_ = 0;
};

}  // namespace slipscale

#endif
