// The soonest stop of a motion along its own path.
//
// The motion's clock slows down: at the rate r, with the slope w = dr/dt, a joint that has the velocity q', the
// acceleration q'' and the jerk q''' there has the acceleration r² q'' + w q' and the jerk r³ q''' + 3 r w q'' +
// dw/dt q'. In each step the slope is linear, and at its end the least that a share of the limits allows. So that
// the jerk is within its limit where the clock stands still at last, the slope stays above -sqrt(2 r b), with the
// largest dw/dt = b there.
//
// The same in plain Python, compared with this in the tests: tests/oracles/stopping.py.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace stopping {

constexpr double kStill = 1e-9;  // a joint or a clock this slow stands

// Quintic pieces of n joints: (6, pieces, n), highest power first, of the time since the start of each piece.
struct Motion {
  const double* times;
  const double* coefficients;
  std::size_t pieces, joints;
};

struct Rates {
  double velocity, acceleration, jerk;
};

// Of one joint, `since` the start of a piece.
inline Rates rates(const Motion& motion, std::size_t piece, std::size_t joint, double since) {
  const std::size_t stride = motion.pieces * motion.joints;
  const double* c = motion.coefficients + piece * motion.joints + joint;
  const double c0 = c[0], c1 = c[stride], c2 = c[2 * stride], c3 = c[3 * stride], c4 = c[4 * stride], t = since;
  return {c4 + t * (2.0 * c3 + t * (3.0 * c2 + t * (4.0 * c1 + t * 5.0 * c0))),
          2.0 * c3 + t * (6.0 * c2 + t * (12.0 * c1 + t * 20.0 * c0)),
          6.0 * c2 + t * (24.0 * c1 + t * 60.0 * c0)};
}

struct Limits {
  const double* acceleration;
  const double* jerk;
  double ramp;   // least time in which braking takes an acceleration from nothing to its limit
  double share;  // of the accelerations, and of the jerks where the brake is let go
  double kept;   // of the jerks otherwise
};

// The clock, its rate and its slope at the end of each step, and how long the last step is, in which the slope
// falls to nothing; infinite where the limits leave no way to stop before the motion ends.
struct Braking {
  std::vector<double> clock, rate, slope;
  double last = std::numeric_limits<double>::infinity();
};

// The least time in which a joint comes to rest with bounded acceleration and jerk, whatever it does: on to the peak of
// a deceleration, maybe some time with it, and off it again.
inline double least_stop(const Rates& at, double acceleration, double jerk) {
  // The velocity that is left where the acceleration is brought to zero at once says which way to brake.
  const double left = at.velocity + at.acceleration * std::abs(at.acceleration) / (2.0 * jerk);
  if (std::abs(left) < kStill) return std::abs(at.acceleration) / jerk;
  const double side = left > 0.0 ? 1.0 : -1.0, speed = side * at.velocity, gain = side * at.acceleration;
  if (std::isinf(jerk)) return speed / acceleration;
  const double peak = std::sqrt(std::max(jerk * speed + gain * gain / 2.0, 0.0));
  if (peak <= acceleration) return (gain + 2.0 * peak) / jerk;
  const double held = (speed + gain * gain / (2.0 * jerk)) / acceleration - acceleration / jerk;
  return (gain + 2.0 * acceleration) / jerk + held;
}

inline std::size_t piece_at(const Motion& motion, double time) {
  const double* end = motion.times + motion.pieces;
  const double* after = std::upper_bound(motion.times + 1, end, time);
  return static_cast<std::size_t>(after - motion.times) - 1;
}

// Braking from a time on; what is not at rest some time after that is of no use.
inline Braking brake(const Motion& motion, const Limits& limits, double begin, double step,
                     double within = std::numeric_limits<double>::infinity()) {
  const double infinity = std::numeric_limits<double>::infinity(), duration = motion.times[motion.pieces];
  Braking found{{begin}, {1.0}, {0.0}};
  double clock = begin, rate = 1.0, slope = 0.0;
  while (clock < duration && step * static_cast<double>(found.clock.size() - 1) < within) {
    if (slope < 0.0 && -2.0 * rate / slope <= 2.0 * step) {
      found.last = -2.0 * rate / slope;
      break;
    }
    // At the begin of the step, and at its end as it would be with the slope of now.
    const double ahead = rate + step * slope, end = std::min(clock + step * (rate + step * slope / 2.0), duration);
    double down = -infinity, up = infinity, hardest = -infinity, away = infinity;
    const std::size_t first = piece_at(motion, clock), second = piece_at(motion, end);
    for (std::size_t j = 0; j < motion.joints; ++j) {
      const double jerk = limits.kept * limits.jerk[j], ramp = limits.acceleration[j] / limits.ramp;
      const auto bound = [&](const Rates& at, double r, double since) {
        const double side = at.velocity < 0.0 ? -1.0 : 1.0, speed = std::max(std::abs(at.velocity), kStill);
        const double others = side * (r * r * r * at.jerk + 3.0 * r * slope * at.acceleration);
        const double turning = std::max(speed + 3.0 * since * r * side * at.acceleration, kStill);
        down = std::max(down, std::max(-jerk - others, -ramp) / turning);
        up = std::min(up, std::min(jerk - others, ramp) / turning);
      };
      bound(rates(motion, first, j, clock - motion.times[first]), rate, 0.0);
      const Rates then = rates(motion, second, j, end - motion.times[second]);
      bound(then, ahead, step);
      const double side = then.velocity < 0.0 ? -1.0 : 1.0, speed = std::max(std::abs(then.velocity), kStill);
      const double room = -limits.share * limits.acceleration[j] - ahead * ahead * then.acceleration * side;
      hardest = std::max(hardest, room / speed), away = std::min(away, limits.share * std::min(limits.jerk[j], ramp) / speed);
    }
    // The rate at the end of the step, of which the root is, depends on the slope there.
    const double left = rate + step * slope / 2.0, bend = step * away;
    const double soft = (bend - std::sqrt(bend * bend + 8.0 * away * std::max(left, 0.0))) / 2.0;
    const double next = std::min(std::max({hardest, slope + step * down, soft}), 0.0);
    const double slower = rate + step * (slope + next) / 2.0;
    if (slower <= 0.0 || next > slope + step * std::max(up, down) + kStill) break;
    clock += step * (rate + step * (2.0 * slope + next) / 6.0), rate = slower, slope = next;
    found.clock.push_back(clock), found.rate.push_back(rate), found.slope.push_back(slope);
  }
  return found;
}

}  // namespace stopping
