// Inner loops over runs of numbers, eight at a time whatever the length: loops of a known length become vector
// instructions on every processor, and short ones lose nothing to their tails. So every run is followed by a group
// of zeros, and every vector has room for a group beyond its end.
#pragma once

#include "../processors.hpp"

namespace banded {

constexpr int kLanes = 8;

constexpr int padded(int length) { return (length + kLanes - 1) / kLanes * kLanes; }

// y += scale x, `length` numbers and those of the last group.
[[gnu::always_inline]] inline void add_scaled(double scale, const double* __restrict x, double* __restrict y,
                                              int length) {
  for (int k = 0; k < length; k += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane) y[k + lane] += scale * x[k + lane];
  }
}

[[gnu::always_inline]] inline double dot(const double* __restrict x, const double* __restrict y, int length) {
  double sums[kLanes] = {};
  for (int k = 0; k < length; k += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane) sums[lane] += x[k + lane] * y[k + lane];
  }
  for (int half = kLanes / 2; half > 0; half /= 2) {
    for (int lane = 0; lane < half; ++lane) sums[lane] += sums[lane + half];
  }
  return sums[0];
}

// The largest of -change / value, at least `floor`; `value` is positive. Any length.
[[gnu::always_inline]] inline double steepest(const double* __restrict value, const double* __restrict change,
                                              double sign, int length, double floor) {
  double most[kLanes];
  for (double& each : most) each = floor;
  int k = 0;
  for (; k + kLanes <= length; k += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const double ratio = -sign * change[k + lane] / value[k + lane];
      most[lane] = ratio > most[lane] ? ratio : most[lane];
    }
  }
  for (; k < length; ++k) {
    const double ratio = -sign * change[k] / value[k];
    most[0] = ratio > most[0] ? ratio : most[0];
  }
  for (double each : most) floor = each > floor ? each : floor;
  return floor;
}

}  // namespace banded
