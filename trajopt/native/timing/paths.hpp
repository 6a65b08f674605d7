// The smooth path: a cubic spline q(s) with continuous curvature; and the same over a clock.
//
// From rest with bounded jerk a path parameter begins like t^3, so that its squared speed is no smooth function
// of it. Over a clock on which the parameter itself begins like clock^3, it is: the squared speed of the clock
// is positive everywhere, and any smooth one starts and ends at rest with zero acceleration.
//
// The same in plain Python, compared with this in the tests: tests/oracles/retiming/smooth_path.py.
#pragma once

#include "polynomials.hpp"

namespace timing {

constexpr std::size_t kDegree = 3;       // DEGREE of smooth_path.py, and so on
constexpr std::size_t kClockDegree = 4;  // the path parameter's third derivative by the clock is continuous
constexpr std::size_t kFlat = 3;         // control values at each end that are equal: two derivatives vanish there
constexpr double kApart = 0.1;   // knots nearer to each other than this part of an interval are one point of the grid
constexpr double kSpared = 0.2;  // part of an even interval by which one may be longer before it is cut

// A cubic B-spline in joint space over the path parameter s. Control points are relative to the origin, so that a
// joint that stands still has derivatives of exactly zero.
class SmoothPath {
 public:
  SmoothPath(Numbers origin, Numbers goal, Numbers knots, Table control)
      : origin(std::move(origin)), goal(std::move(goal)), knots(std::move(knots)), control(std::move(control)),
        spline_(this->knots, this->control, kDegree) {}

  std::size_t joints() const { return origin.size(); }
  double length() const { return knots.back(); }

  // The positions and their first derivatives by the parameter, a row for each order.
  void at(double s, std::size_t orders, double* values) const {
    spline_(s, orders, values);
    if (s >= length()) std::copy(goal.begin(), goal.end(), values);  // not off by the last bit
    else
      for (std::size_t joint = 0; joint < joints(); ++joint) values[joint] += origin[joint];
  }

  Numbers origin, goal;
  Numbers knots;  // where the third derivative may jump, increasing from 0
  Table control;

 private:
  Polynomials spline_;
};

// A motion along a path, to be smoothed: points with their parameters and rates.
struct RoughMotion {
  Numbers times, s, speed;
};

// Over a clock the end knots are repeated: control values stand at means of neighbouring knots.
inline Numbers clock_knots(const Numbers& clock) {
  Numbers all(kClockDegree, clock.front());
  all.insert(all.end(), clock.begin(), clock.end());
  all.insert(all.end(), kClockDegree, clock.back());
  return all;
}

// A smooth path q(s) with s a monotone spline of the clock.
class RampedPath {
 public:
  RampedPath(const SmoothPath& path, Numbers clock, const Numbers& control)
      : path(&path), clock(std::move(clock)), way_(this->clock, Table(control.size(), 1, control), kClockDegree) {}

  std::size_t joints() const { return path->joints(); }

  // The path parameter and its first derivatives, up to three.
  void way(double moment, std::size_t orders, double* values) const {
    way_(moment, orders, values);
    values[0] = std::clamp(values[0], 0.0, path->length());
    if (moment < clock.back()) return;
    values[0] = path->length();  // not off by the last bit, and at rest
    for (std::size_t order = 1; order <= std::min(orders, kFlat - 1); ++order) values[order] = 0.0;
  }

  double way(double moment) const {
    double value;
    way(moment, 0, &value);
    return value;
  }

  // The positions and their first derivatives by the clock, up to two, a row for each order.
  void at(double moment, std::size_t orders, double* values) const {
    double s[3];
    way(moment, orders, s);
    path->at(s[0], orders, values);
    double *slope = values + joints(), *bend = slope + joints();
    for (std::size_t joint = 0; orders > 1 && joint < joints(); ++joint)
      bend[joint] = bend[joint] * (s[1] * s[1]) + slope[joint] * s[2];
    for (std::size_t joint = 0; orders > 0 && joint < joints(); ++joint) slope[joint] *= s[1];
  }

  // The third derivative of the positions at the starts and at the ends of the intervals of the clock: the path's own
  // jumps at points of it only.
  void third(Table& starts, Table& ends) const {
    const std::size_t intervals = clock.size() - 1, n = joints();
    starts = ends = Table(intervals, n);
    Numbers values(4 * n), constant(intervals * n);
    for (std::size_t i = 0; i < intervals; ++i) {
      path->at(way((clock[i] + clock[i + 1]) / 2.0), 3, values.data());
      std::copy(values.begin() + 3 * n, values.end(), constant.begin() + i * n);
    }
    for (std::size_t i = 0; i <= intervals; ++i) {
      double s[4];
      way(clock[i], 3, s);
      path->at(s[0], 2, values.data());
      const double *slope = values.data() + n, *bend = slope + n, cube = s[1] * s[1] * s[1];
      for (std::size_t joint = 0; joint < n; ++joint) {
        const double others = 3.0 * bend[joint] * (s[1] * s[2]) + slope[joint] * s[3];
        if (i > 0) ends[i - 1][joint] = constant[(i - 1) * n + joint] * cube + others;
        if (i < intervals) starts[i][joint] = constant[i * n + joint] * cube + others;
      }
    }
  }

  const SmoothPath* path;
  Numbers clock;  // knots of the spline, which are the grid for timing, from 0

 private:
  Polynomials way_;
};

// Cuts the clock evenly between the knots of the path that are apart.
inline Numbers clock_grid(const Numbers& knots, double length, std::size_t count) {
  const double cell = length / static_cast<double>(count);
  Numbers kept{0.0};
  for (std::size_t i = 1; i + 1 < knots.size(); ++i)
    if (knots[i] - kept.back() > kApart * cell && length - knots[i] > kApart * cell) kept.push_back(knots[i]);
  kept.push_back(length);
  std::vector<std::size_t> parts;
  for (std::size_t i = 0; i + 1 < kept.size(); ++i)
    parts.push_back(parts_of(std::ceil((kept[i + 1] - kept[i]) / cell - kSpared)));
  return cut(kept, parts);
}

// Corrects values of a function at Greville abscissae to control values that reproduce cubics.
//
// A control value is the blossom of the function at four knots; for a cubic that is its value at their mean less its
// second derivative times a sixth of their variance. Where that would not increase, the values themselves stay.
inline Numbers cubic_control(const Numbers& full, const Numbers& places, const Numbers& value) {
  const std::size_t count = value.size();
  Numbers control = value;
  for (std::size_t i = kFlat; i + kFlat < count; ++i) {
    double spread = 0.0;
    for (std::size_t knot = 1; knot <= kClockDegree; ++knot)
      spread += (full[i + knot] - places[i]) * (full[i + knot] - places[i]);
    spread /= static_cast<double>(kClockDegree);
    const double before = places[i] - places[i - 1], after = places[i + 1] - places[i];
    const double bend =
        2.0 * ((value[i + 1] - value[i]) / after - (value[i] - value[i - 1]) / before) / (before + after);
    control[i] -= spread / 6.0 * bend;
  }
  std::vector<bool> beside(count, false);  // near a place where they do not increase, but for the flat ends
  for (std::size_t i = kFlat - 1; i + kFlat < count; ++i) {
    if (control[i + 1] - control[i] > 0.0) continue;
    for (std::size_t near = i >= 2 ? i - 2 : 0; near <= std::min(i + 3, count - 1); ++near) beside[near] = true;
  }
  for (std::size_t i = 0; i < count; ++i)
    if (beside[i]) control[i] = value[i];
  return control;
}

// Lays a path over the clock of a rough motion along it.
//
// The motion is averaged over a time that gives the acceleration time to rise (0 for a motion that starts and ends
// without acceleration). Control values that reproduce cubics are taken where they increase, else the values of the
// motion itself, which always do. `count`: intervals of the grid to aim at.
inline RampedPath ramped(const SmoothPath& path, const RoughMotion& rough, double average, std::size_t count) {
  const Polynomials moved = Polynomials::hermite(rough.times, rough.s, rough.speed);
  const double end = rough.times.back(), length = path.length();
  Numbers knots;
  for (const double knot : path.knots) knots.push_back(interpolated(rough.s, rough.times, knot) + average / 2.0);
  Numbers clock = clock_grid(knots, end + average, count);
  const Numbers full = clock_knots(clock);
  const std::size_t controls = clock.size() + kClockDegree - 1;
  const Polynomials summed = average > 0.0 ? moved.integral() : Polynomials();
  const auto until = [&](double t) { return summed(std::clamp(t, 0.0, end)) + length * std::max(t - end, 0.0); };
  Numbers places(controls), value(controls);
  double largest = 0.0;
  for (std::size_t i = 0; i < controls; ++i) {
    places[i] = (full[i + 1] + full[i + 2] + full[i + 3] + full[i + 4]) / 4.0;
    const double found = average > 0.0 ? (until(places[i]) - until(places[i] - average)) / average : moved(places[i]);
    largest = std::max(largest, found);
    value[i] = std::min(largest, length);
  }
  std::fill(value.begin(), value.begin() + kFlat, 0.0), std::fill(value.end() - kFlat, value.end(), length);
  return RampedPath(path, std::move(clock), cubic_control(full, places, value));
}

}  // namespace timing
