#include "nearest.hpp"

#include <algorithm>
#include <limits>

namespace proof {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double first_radius = 0.05, growth = 4.0, last_radius = 10.0;

}  // namespace

std::vector<double> measure_nearest(const Bodies& bodies, const Candidates& candidates, Meter& meter, Snapshot& at,
                                    const std::vector<char>& strict) {
  std::vector<double> measured(bodies.pairs.size(), infinite);
  double best = infinite;
  auto consider = [&](int number, double within) {
    const Pair& pair = bodies.pairs[number];
    if (measured[number] < infinite) return;
    if (!pair.planar && sphere_gap(bodies, at, pair) > within) return;
    const Measured found = meter.measure(number, at, within);
    if (!found.exact) return;
    measured[number] = found.distance;
    if (strict[number]) best = std::min(best, found.distance);
  };
  // Look farther and farther until the nearest is found.
  for (double radius = first_radius;; radius = radius < last_radius ? growth * radius : infinite) {
    auto within = [&] { return std::max(std::min(best, radius), 0.0) + 1e-9; };
    for (const int pair : candidates.listed()) consider(pair, within());
    for (const int mover : candidates.movers()) {
      candidates.visit(mover, at.centre(mover), bodies.form(mover).radius + within(),
                       [&](int pair) { consider(pair, within()); });
    }
    if (best <= radius || radius == infinite) break;
  }
  return measured;
}

}  // namespace proof
