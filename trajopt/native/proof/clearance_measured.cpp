// How near everything comes, once it is decided that it keeps apart: what a reader of the certificate is told.
#include <algorithm>
#include <cmath>

#include "clearance_search.hpp"
#include "nearest.hpp"

namespace proof {

namespace {

constexpr int probes = 9, sharpenings = 3;  // The smallest distance is sharpened by so many measurements, so often.

}  // namespace

// If nothing comes near, look as far as the nearest is at the ends, and forget what was proven for less.
bool ClearanceSearch::nothing_near() {
  for (size_t level = 0; level < best_.size(); ++level) {
    if (best_[level] <= bodies_.levels[level] + far_) return false;
  }
  const std::vector<char> strict(bodies_.pairs.size(), 1);
  for (const double time : {motion_.begin(), motion_.end()}) {
    const auto end = at(time);
    const std::vector<double> measured = measure_nearest(bodies_, candidates_, meter_, *end, strict);
    for (size_t pair = 0; pair < measured.size(); ++pair) {
      if (std::isfinite(measured[pair]) && !windows_.accept(time, int(pair))) {
        note_free(int(pair), measured[pair], time);
      }
    }
  }
  double nearest = infinite;
  for (size_t level = 0; level < best_.size(); ++level) nearest = std::min(nearest, best_[level] - bodies_.levels[level]);
  if (!std::isfinite(nearest)) return false;
  far_ = std::max(far_, nearest);
  forget_bounds();
  return true;
}

// Measure, here and there, every pair whose bound says that it may have come near.
void ClearanceSearch::measure_near_pairs() {
  std::vector<int> tightest(bodies_.levels.size(), -1);
  for (int pair = 0; pair < int(bodies_.pairs.size()); ++pair) {
    if (free.proven[pair] <= required(pair) + options_.far) {
      measure_free(pair, *at(tight_time_[pair]));
      for (const auto& sample : samples_) measure_free(pair, *sample);
    }
    int& first = tightest[bodies_.pairs[pair].level];
    if (std::isfinite(free.measured[pair]) && (first < 0 || free.measured[pair] < free.measured[first])) first = pair;
  }
  for (const int pair : tightest) {
    if (pair >= 0 && free.measured[pair] <= required(pair) + options_.far) sharpen(pair);
  }
}

// Take note of a pair's distance if it is its smallest so far.
void ClearanceSearch::measure_free(int pair, Snapshot& at) {
  const double within = std::min(free.measured[pair], required(pair) + options_.far);
  if (windows_.accept(at.time, pair)) return;
  if (!bodies_.pairs[pair].planar && sphere_gap(at, bodies_.pairs[pair]) > within) return;
  const Measured found = meter_.measure(pair, at, within);
  if (found.exact) note_free(pair, found.distance, at.time);
}

// Look around the smallest distance of a pair for a smaller one.
void ClearanceSearch::sharpen(int pair) {
  double span = motion_.duration() / first_intervals;
  for (int round = 0; round < sharpenings; ++round, span /= probes / 2.0) {
    const double middle = free.time[pair];
    for (int i = 0; i < probes; ++i) {
      const double time = middle + span * (2.0 * i / (probes - 1) - 1.0);
      measure_free(pair, *at(std::clamp(time, motion_.begin(), motion_.end())));
    }
  }
}

}  // namespace proof
