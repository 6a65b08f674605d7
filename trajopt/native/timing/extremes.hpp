// Exact extremes of the velocity and acceleration of quintic pieces.
//
// Over the part u in [0, 1] of a piece the acceleration is a cubic, monotone between its turning points: its
// extremes lie there or at the ends. Speed is largest at the ends or where the acceleration is zero, and each
// monotone part with a change of sign holds one zero: Newton's method within a bracket finds it. What the speed
// could still gain between where that stops and the true zero is added.
//
// The same in plain Python, compared with this in the tests: tests/oracles/extremes.py.
#pragma once

#include <algorithm>
#include <cmath>

namespace extremes {

constexpr int kSteps = 40;           // Newton's steps at most; bisection alone would be through by then
constexpr double kMissing = 1e-12;   // part of the speed that may be missing when the steps end

// a + b u + c u² + d u³ and its derivative.
struct Cubic {
  double a, b, c, d;

  double at(double u) const { return a + u * (b + u * (c + u * d)); }
  double slope(double u) const { return b + u * (2.0 * c + u * 3.0 * d); }
};

// The quotient where it is between 0 and 1; else 0.
inline double part(double above, double below) {
  const bool inside = std::abs(above) < std::abs(below) && (above < 0.0) == (below < 0.0);
  return inside ? above / below : 0.0;
}

// Where a cubic turns within [0, 1], in order; 0 where it does not.
// Source: the quadratic formula without cancellation, Press et al., Numerical Recipes, 2007, 5.6.
inline void turning_points(const Cubic& cubic, double& first, double& second) {
  const double leading = 3.0 * cubic.d, half = cubic.c;
  const double root = std::sqrt(std::max(half * half - leading * cubic.b, 0.0));
  const double q = -half - std::copysign(root, half);
  first = part(q, leading), second = part(cubic.b, q);
  if (second < first) std::swap(first, second);
}

struct Extremes {
  double speed;  // largest absolute velocity
  double low;    // least acceleration
  double high;   // largest acceleration
};

// Of one joint in one piece. `c` are the coefficients of its quintic, highest power of time first, `stride` apart;
// `width` is how long it takes.
inline Extremes of_piece(const double* c, std::size_t stride, double width) {
  const double h = width;
  const double c0 = c[0], c1 = c[stride], c2 = c[2 * stride], c3 = c[3 * stride], c4 = c[4 * stride];
  const Cubic acceleration{2.0 * c3, 6.0 * c2 * h, 12.0 * c1 * h * h, 20.0 * c0 * h * h * h};
  const auto speed = [&](double u) {
    const double t = u * h;
    return std::abs(c4 + t * (2.0 * c3 + t * (3.0 * c2 + t * (4.0 * c1 + t * 5.0 * c0))));
  };
  double ends[4] = {0.0, 0.0, 0.0, 1.0}, values[4];
  turning_points(acceleration, ends[1], ends[2]);
  for (int i = 0; i < 4; ++i) values[i] = acceleration.at(ends[i]);

  Extremes found{std::max(speed(0.0), speed(1.0)), *std::min_element(values, values + 4),
                 *std::max_element(values, values + 4)};
  for (int i = 0; i < 3; ++i) {
    if ((values[i] > 0.0) == (values[i + 1] > 0.0)) continue;
    const bool rising = values[i + 1] > 0.0;
    double low = ends[i], high = ends[i + 1];
    double u = low + (high - low) * values[i] / (values[i] - values[i + 1]), missing = 0.0;
    for (int step = 0;; ++step) {
      const double value = acceleration.at(u), slope = acceleration.slope(u);
      missing = std::abs(value) * (high - low) * h;
      if (step == kSteps || missing <= kMissing * found.speed) break;
      ((value > 0.0) == rising ? high : low) = u;
      const double next = u - value / slope;
      u = next >= low && next <= high ? next : (low + high) / 2.0;
    }
    found.speed = std::max(found.speed, speed(u) + missing);
  }
  return found;
}

}  // namespace extremes
