// What a descent asks of a robot among its obstacles. The core `proximity` answers; the two are compiled apart and
// meet in this class alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace distances {

// Pairs of bodies that are near each other at many configurations, one entry each; good until the next question.
struct Near {
  std::size_t count;
  const std::int64_t *sample, *pair;
  const double *distance, *jacobian;  // the latter by the group's positions, a row for each entry
};

// What was done: bounds of distance that were compared, and distances that were measured.
struct Work {
  std::int64_t bounds = 0, distances = 0;
};

class DistanceQuery {
 public:
  virtual ~DistanceQuery() = default;

  // Joints of the group, and pairs of bodies.
  virtual int joints() const = 0;
  virtual int pairs() const = 0;
  // Every pair nearer than its reach at configurations of the group, which lie one after the other.
  virtual Near near(const double* positions, int samples, const std::vector<double>& reach) = 0;
  virtual Work work() const = 0;
};

}  // namespace distances
