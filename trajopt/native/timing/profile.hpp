// The profile s(t): how fast the path parameter runs.
//
// The same in plain Python, compared with this in the tests: tests/oracles/retiming/profile.py.
#pragma once

#include "table.hpp"

namespace timing {

// artanh(r) / r of r² = square; for a negative square its continuation arctan(r) / r.
inline double stretch(double square) {
  const double root = std::sqrt(std::abs(square));
  if (root < 1e-3) return 1.0 + square / 3.0 + square * square / 5.0;
  return (square > 0.0 ? std::atanh(std::min(root, 1.0 - 1e-15)) : std::atan(root)) / root;
}

// A profile whose path acceleration is continuous, and linear in s between grid points.
struct Profile {
  Numbers s;      // grid, increasing
  Numbers x;      // squared speed (ds/dt)² at the grid points, positive between the ends
  Numbers u;      // path acceleration d²s/dt² = dx/ds / 2 there
  Numbers times;  // of each grid point, from 0

  // Makes the profile whose squared speed is a quadratic B-spline with these control values at the stations.
  //
  // Source: between grid points x is the quadratic that runs from chord to chord of the control polygon; it is an
  // average of control values with positive weights, and so stays positive. On an interval x is a quadratic in s with
  // leading factor alpha = du/ds; the integral of ds / sqrt(x) is
  // 2 / sqrt(alpha) * artanh(sqrt(alpha) * ds / (speed + speed after)).
  Profile(Numbers grid, const Numbers& control, bool rests)
      : s(std::move(grid)), x(s.size()), u(s.size()), times(s.size(), 0.0) {
    const Numbers station = stations(s);
    for (std::size_t i = 0; i < s.size(); ++i) {
      const double distance = station[i + 1] - station[i], rise = control[i + 1] - control[i];
      x[i] = control[i] + (s[i] - station[i]) / distance * rise, u[i] = rise / (2.0 * distance);
    }
    if (rests) x.back() = 0.0;  // not off by a rounding error
    for (std::size_t i = 0; i + 1 < s.size(); ++i) {
      const double ds = s[i + 1] - s[i], mean = ds / (std::sqrt(x[i]) + std::sqrt(x[i + 1]));
      const double alpha = (u[i + 1] - u[i]) / ds;
      times[i + 1] = times[i] + 2.0 * mean * stretch(alpha * mean * mean);
    }
  }

  double duration() const { return times.back(); }
};

}  // namespace timing
