// The fastest profile on a grid: one pass backward, one forward.
//
// A profile is given by control values y of the squared path speed at stations, 0 at the first and the last.
// Between stations i and i + 1, `distance` apart, lies grid point i. A limit |a u + b x + c| <= limit of the path
// acceleration u = (y[i + 1] - y[i]) / (2 distance) and of the squared speed x shall hold with x = y[i] and with
// x = y[i + 1]: four half-planes
//
//     onward * y[i + 1] + held * y[i] <= room,    room > 0.
//
// Backward: the largest y[i], below its bound, from which some controllable y[i + 1] can be reached: a linear
// program in two variables. Seen over y[i + 1], the half-planes with held > 0 are a roof on y[i] (concave), those
// with held < 0 a floor (convex) that lies below the roof at 0. So the program is solved in two searches along
// the roof that take one line at a time and end exactly. Forward: the largest y[i + 1] that stays controllable.
//
// Source: Pham and Pham, IEEE T-RO 34(3), 2018, algorithm 1 (TOPP-RA).
// The same in plain Python, compared with this in the tests: tests/oracles/reachability.py.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace passes {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLeastRoom = 1e-6;  // part of each limit that is left to motion: LEAST_ROOM of retiming/constraints.py
constexpr int kRounds = 200;         // a search takes each line once at most; rounding may make it turn in place
constexpr double kSteep = 1e-8;      // a factor that is this much smaller than the other is rounding: STEEP there
constexpr double kTrifle = 1e-13;    // part of a value that is no progress but rounding

// The limits at all grid points, tables with a row for each of them, and the bound at the stations.
struct Course {
  const double *distance, *a, *b, *c, *limit, *bound;
  std::size_t points, columns;
};

// Calls visit(onward, held, room) for every half-plane of a grid point.
template <typename Visit>
void half_planes(const Course& course, std::size_t point, const Visit& visit) {
  const bool rest = point == 0 || point + 1 == course.points;
  for (std::size_t j = point * course.columns; j < (point + 1) * course.columns; ++j) {
    const double a = course.a[j] / (2.0 * course.distance[point]), b = rest ? 0.0 : course.b[j];
    const double limit = course.limit[j], least = kLeastRoom * limit;
    const double above = std::max(limit - course.c[j], least), below = std::max(limit + course.c[j], least);
    visit(a, b - a, above);
    visit(a + b, -a, above);
    visit(-a, a - b, below);
    visit(-a - b, a, below);
  }
}

// A line, or what it is at an argument: then `value` is its height there.
struct Line {
  double value;  // at 0
  double slope;
};

using Lines = std::vector<Line>;

inline Line lowest(const Lines& lines, double argument) {
  Line found{kInfinity, 0.0};
  for (const Line& line : lines) {
    const double value = line.value + line.slope * argument;
    if (value < found.value) found = {value, line.slope};
  }
  return found;
}

inline Line highest(const Lines& lines, double argument) {
  Line found{-kInfinity, 0.0};
  for (const Line& line : lines) {
    const double value = line.value + line.slope * argument;
    if (value > found.value) found = {value, line.slope};
  }
  return found;
}

// Largest argument, at most `end`, over which roof and floor leave a gap: Newton's method from the right.
inline double feasible(const Lines& roof, const Lines& floor, double end) {
  for (int round = 0; round < kRounds; ++round) {
    const Line above = lowest(roof, end), below = highest(floor, end);
    const double gap = above.value - below.value, closing = below.slope - above.slope;
    if (!(gap < 0.0 && closing > 0.0)) break;
    const double next = std::max(end + gap / closing, 0.0);
    if (!(next < end * (1.0 - kTrifle))) break;
    end = next;
  }
  return end;
}

// Where in [0, end] the roof is highest: where a rising and a falling line cross below all others.
inline double summit(const Lines& roof, double end) {
  double left = 0.0, right = end;
  Line rise = lowest(roof, left), fall = lowest(roof, right);
  if (fall.slope >= 0.0) return right;
  if (rise.slope <= 0.0) return left;
  for (int round = 0; round < kRounds; ++round) {
    const double apart = fall.value - fall.slope * right - rise.value + rise.slope * left;
    const double at = std::clamp(apart / (rise.slope - fall.slope), left, right);
    if (!(left < at && at < right)) return at;  // rounding errors of steep lines let the search go no further
    const Line there = lowest(roof, at);
    const double expected = rise.value + rise.slope * (at - left);
    if (there.slope == 0.0 || there.value >= expected - kTrifle * std::abs(there.value)) return at;
    if (there.slope > 0.0) {
      left = at, rise = there;
    } else {
      right = at, fall = there;
    }
  }
  return right;
}

inline std::vector<double> fastest(const Course& course) {
  std::vector<double> control(course.points + 1, 0.0);
  Lines roof, floor;
  for (std::size_t i = course.points; i-- > 0;) {
    roof.clear(), floor.clear();
    double after = control[i + 1];
    half_planes(course, i, [&](double onward, double held, double room) {
      if (std::abs(held) > kSteep * std::abs(onward))
        (held > 0.0 ? roof : floor).push_back({room / held, -onward / held});
      else if (onward > 0.0)
        after = std::min(after, room / onward);
    });
    after = summit(roof, feasible(roof, floor, after));
    control[i] = std::max(0.0, std::min(lowest(roof, after).value, course.bound[i]));
  }
  control[0] = 0.0;
  for (std::size_t i = 0; i < course.points; ++i) {
    double reached = control[i + 1];
    half_planes(course, i, [&](double onward, double held, double room) {
      if (onward > kSteep * std::abs(held)) reached = std::min(reached, (room - held * control[i]) / onward);
    });
    control[i + 1] = std::max(0.0, reached);
  }
  return control;
}

}  // namespace passes
