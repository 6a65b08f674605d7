#include "nearest.hpp"

#include <algorithm>

namespace proof {

namespace {

constexpr double first_radius = 0.05, growth = 4.0, last_radius = 10.0;

}  // namespace

std::vector<double> measure_nearest(const Bodies& bodies, const Candidates& candidates, Meter& meter, Snapshot& at,
                                    const std::vector<char>& strict) {
  std::vector<double> measured(bodies.pairs.size(), infinite);
  double best = infinite;
  const double farthest = bodies.levels.empty() ? 0.0 : bodies.levels.back();
  auto consider = [&](int number, double within) {
    const Pair& pair = bodies.pairs[number];
    if (measured[number] < infinite) return;
    if (!pair.planar && sphere_gap(at, pair) > within) return;
    const Measured found = meter.measure(number, at, within);
    if (!found.exact) return;
    measured[number] = found.distance;
    if (strict[number]) best = std::min(best, found.distance);
  };
  // Look farther and farther until the nearest is found.
  for (double radius = first_radius;; radius = radius < last_radius ? growth * radius : infinite) {
    // Up to what a pair must keep, or to the nearest so far.
    auto within = [&](double required) { return std::max(std::min(best, radius), required) + 1e-9; };
    for (const int pair : candidates.listed()) consider(pair, within(bodies.pairs[pair].required));
    for (const int mover : candidates.movers()) {
      candidates.visit(mover, at.centre(mover), bodies.form(mover).radius + within(farthest) + candidates.reserve(),
                       [&](int pair) { consider(pair, within(bodies.pairs[pair].required)); });
    }
    if (best <= radius || radius == infinite) break;
  }
  return measured;
}

}  // namespace proof
