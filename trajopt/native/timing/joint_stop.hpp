// How joints that move come to rest, each as hard as its limits allow: on to a deceleration, with it, and off it
// again, in three pieces of constant jerk whose lengths are whole numbers of ticks.
//
// The same in plain Python, compared with this in the tests: tests/oracles/joint_stops.py.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "table.hpp"

namespace stopping {

using timing::Numbers;

// Of one joint, at one moment.
struct Moving {
  double position, velocity, acceleration;

  Moving after(double t, double jerk) const {
    return {position + t * (velocity + t * (acceleration / 2.0 + t * jerk / 6.0)),
            velocity + t * (acceleration + t * jerk / 2.0), acceleration + t * jerk};
  }
};

struct JointLimit {
  double lower, upper, velocity, acceleration, jerk;
};

using Ticks = std::array<long, 3>;

// How soon a joint's velocity and acceleration can be zero, within limits of it and its jerk.
inline Ticks soonest(const Moving& joint, const JointLimit& limit, double tick) {
  const double jerk = limit.jerk, most = limit.acceleration;
  // The velocity that is left where the acceleration is brought to zero at once says which way to brake.
  const double left = joint.velocity + joint.acceleration * std::abs(joint.acceleration) / (2.0 * jerk);
  const double side = left >= 0.0 ? 1.0 : -1.0, speed = side * joint.velocity, gain = side * joint.acceleration;
  double peak = std::min(std::sqrt(std::max(jerk * speed + gain * gain / 2.0, 0.0)), most);
  const double held = peak == most ? (speed + gain * gain / (2.0 * jerk)) / most - most / jerk : 0.0;
  const auto ticks = [&](double time) { return static_cast<long>(std::ceil(time / tick - 1e-9)); };
  long on = std::max(ticks((gain + peak) / jerk), 1L), hold = ticks(std::max(held, 0.0)), off = std::max(ticks(peak / jerk), 1L);
  for (;; ++on, ++hold, ++off) {
    const auto a = static_cast<double>(on), b = static_cast<double>(hold), c = static_cast<double>(off);
    peak = (speed / tick + gain * a / 2.0) / (a / 2.0 + b + c / 2.0);
    const double rise = (gain + peak) / (a * tick), fall = peak / (c * tick);
    if (std::max({std::abs(peak) / most, std::abs(rise) / jerk, std::abs(fall) / jerk}) <= 1.0) return {on, hold, off};
  }
}

struct JointStop {
  std::vector<long> ticks;  // Of its points.
  std::vector<Moving> rows;  // One of each joint for each point.
};

// The motion of joints that brake in given times.
inline JointStop braked(const std::vector<Moving>& begin, const std::vector<Ticks>& lengths, double tick) {
  const std::size_t joints = begin.size();
  JointStop found{{0}, begin};
  std::vector<Ticks> ends(joints);
  std::vector<std::array<double, 3>> jerks(joints);
  for (std::size_t j = 0; j < joints; ++j) {
    const double on = tick * static_cast<double>(lengths[j][0]), hold = tick * static_cast<double>(lengths[j][1]);
    const double off = tick * static_cast<double>(lengths[j][2]);
    const double peak = (begin[j].velocity + begin[j].acceleration * on / 2.0) / (on / 2.0 + hold + off / 2.0);
    jerks[j] = {-(begin[j].acceleration + peak) / on, 0.0, peak / off};
    ends[j] = {lengths[j][0], lengths[j][0] + lengths[j][1], lengths[j][0] + lengths[j][1] + lengths[j][2]};
    found.ticks.insert(found.ticks.end(), ends[j].begin(), ends[j].end());
  }
  std::sort(found.ticks.begin(), found.ticks.end());
  found.ticks.erase(std::unique(found.ticks.begin(), found.ticks.end()), found.ticks.end());
  for (std::size_t row = 1; row < found.ticks.size(); ++row) {
    const long now = found.ticks[row - 1], then = found.ticks[row];
    for (std::size_t j = 0; j < joints; ++j) {
      // Joints whose last piece is over are at rest.
      const std::size_t piece = now < ends[j][0] ? 0 : now < ends[j][1] ? 1 : 2;
      const double jerk = now < ends[j][2] ? jerks[j][piece] : 0.0;
      Moving next = found.rows[(row - 1) * joints + j].after(tick * static_cast<double>(then - now), jerk);
      if (then == ends[j][2]) next.velocity = next.acceleration = 0.0;  // Exactly.
      found.rows.push_back(next);
    }
  }
  return found;
}

// Whether a joint keeps its limits in a piece of constant jerk, at all times.
inline bool keeps(const Moving& begin, const Moving& end, double length, const JointLimit& limit, double excess) {
  const double jerk = (end.acceleration - begin.acceleration) / length, more = 1.0 + excess;
  const auto inside = [&](const Moving& at) {
    return at.position >= limit.lower && at.position <= limit.upper && std::abs(at.velocity) <= limit.velocity * more &&
           std::abs(at.acceleration) <= limit.acceleration * more;
  };
  if (!inside(begin) || !inside(end) || !(std::abs(jerk) <= limit.jerk * more)) return false;
  // Velocity turns where there is no acceleration, position where there is no velocity.
  const auto inside_at = [&](double t) { return !(t > 0.0 && t < length) || inside(begin.after(t, jerk)); };
  if (jerk == 0.0) return begin.acceleration == 0.0 || inside_at(-begin.velocity / begin.acceleration);
  const double square = begin.acceleration * begin.acceleration - 2.0 * jerk * begin.velocity;
  if (!inside_at(-begin.acceleration / jerk)) return false;
  if (square <= 0.0) return true;
  return inside_at((-begin.acceleration - std::sqrt(square)) / jerk) && inside_at((-begin.acceleration + std::sqrt(square)) / jerk);
}

inline bool keeps(const JointStop& stop, const std::vector<JointLimit>& limits, double tick, double excess) {
  const std::size_t joints = limits.size();
  for (std::size_t row = 1; row < stop.ticks.size(); ++row) {
    const double length = tick * static_cast<double>(stop.ticks[row] - stop.ticks[row - 1]);
    for (std::size_t j = 0; j < joints; ++j) {
      const Moving &begin = stop.rows[(row - 1) * joints + j], &end = stop.rows[row * joints + j];
      if (!keeps(begin, end, length, limits[j], excess)) return false;
    }
  }
  return true;
}

// All joints brake together, so that the arm goes on nearly as it was going; where that takes one of them out of its
// limits, each brakes by itself.
inline JointStop stop_from(const std::vector<Moving>& begin, const std::vector<JointLimit>& limits, double tick, double excess) {
  std::vector<Ticks> alone;
  Ticks longest{0, 0, 0};
  for (std::size_t j = 0; j < begin.size(); ++j) {
    alone.push_back(soonest(begin[j], limits[j], tick));
    for (std::size_t k = 0; k < 3; ++k) longest[k] = std::max(longest[k], alone[j][k]);
  }
  JointStop together = braked(begin, std::vector<Ticks>(begin.size(), longest), tick);
  return keeps(together, limits, tick, excess) ? together : braked(begin, alone, tick);
}

}  // namespace stopping
