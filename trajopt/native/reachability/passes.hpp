// The fastest profile on a grid: one pass backward, one forward.
//
// A profile is given by control values y of the squared path speed at stations, 0 at the first and the last.
// Between stations i and i + 1 lies grid point i with its half-planes
//
//     onward * y[i + 1] + held * y[i] <= room,    room > 0.
//
// Backward: the largest y[i], below its bound, from which some controllable y[i + 1] can be reached: a linear
// program in two variables. Seen over y[i + 1], the half-planes with held > 0 are a roof on y[i] (concave),
// those with held < 0 a floor (convex) that lies below the roof at 0. So the program is solved in two searches
// along the roof that take one line at a time and end exactly. Forward: the largest y[i + 1] that stays
// controllable.
//
// Source: Pham and Pham, IEEE T-RO 34(3), 2018, algorithm 1 (TOPP-RA).
// The body in plain Python, and the oracle of this one, is trajopt/retime/reachability.py.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace passes {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kRounds = 200;       // a search takes each line once at most; rounding may make it turn in place
constexpr double kTrifle = 1e-13;  // part of a value that is no progress but rounding

struct Line {
  double value;  // at the argument asked for
  double slope;
};

// The half-planes of one grid point.
struct Stage {
  const double* onward;
  const double* held;
  const double* room;
  std::size_t count;

  // The lowest line above y[i], at y[i + 1] = after.
  Line roof(double after) const {
    Line lowest{kInfinity, 0.0};
    for (std::size_t j = 0; j < count; ++j) {
      if (held[j] <= 0.0) continue;
      const double value = (room[j] - onward[j] * after) / held[j];
      if (value < lowest.value) lowest = {value, -onward[j] / held[j]};
    }
    return lowest;
  }

  // The highest line below y[i], at y[i + 1] = after.
  Line floor(double after) const {
    Line highest{-kInfinity, 0.0};
    for (std::size_t j = 0; j < count; ++j) {
      if (held[j] >= 0.0) continue;
      const double value = (room[j] - onward[j] * after) / held[j];
      if (value > highest.value) highest = {value, -onward[j] / held[j]};
    }
    return highest;
  }

  // Largest y[i + 1] reached from y[i] = before.
  double reached(double before) const {
    double least = kInfinity;
    for (std::size_t j = 0; j < count; ++j)
      if (onward[j] > 0.0) least = std::min(least, (room[j] - held[j] * before) / onward[j]);
    return least;
  }

  // Largest y[i + 1], at most `after`, over which roof and floor leave a gap: Newton's method from the right.
  double feasible(double after) const {
    for (std::size_t j = 0; j < count; ++j)
      if (held[j] == 0.0 && onward[j] > 0.0) after = std::min(after, room[j] / onward[j]);
    for (int round = 0; round < kRounds; ++round) {
      const Line above = roof(after), below = floor(after);
      const double gap = above.value - below.value, closing = below.slope - above.slope;
      if (!(gap < 0.0 && closing > 0.0)) break;
      const double next = std::max(after + gap / closing, 0.0);
      if (!(next < after * (1.0 - kTrifle))) break;
      after = next;
    }
    return after;
  }

  // Highest point of the roof over [0, after]: where a rising and a falling line cross below all others.
  double summit(double after) const {
    double left = 0.0, right = after;
    Line rise = roof(left), fall = roof(right);
    if (rise.slope <= 0.0) return fall.slope < 0.0 ? left : right;
    if (fall.slope >= 0.0) return right;
    for (int round = 0; round < kRounds; ++round) {
      const double apart = fall.value - fall.slope * right - rise.value + rise.slope * left;
      const double at = std::clamp(apart / (rise.slope - fall.slope), left, right);
      const Line there = roof(at);
      const double expected = rise.value + rise.slope * (at - left);
      if (there.slope == 0.0 || there.value >= expected - kTrifle * std::abs(there.value)) return at;
      if (there.slope > 0.0) {
        left = at, rise = there;
      } else {
        right = at, fall = there;
      }
    }
    return left;
  }
};

// Half-planes of all grid points, `rows` of them each, and the bound at the stations.
struct Course {
  const double *onward, *held, *room, *bound;
  std::size_t points, rows;

  Stage stage(std::size_t i) const { return {onward + i * rows, held + i * rows, room + i * rows, rows}; }
};

inline std::vector<double> fastest(const Course& course) {
  std::vector<double> control(course.points + 1, 0.0);
  for (std::size_t i = course.points; i-- > 0;) {
    const Stage stage = course.stage(i);
    const double after = stage.summit(stage.feasible(control[i + 1]));
    control[i] = std::max(0.0, std::min(stage.roof(after).value, course.bound[i]));
  }
  control[0] = 0.0;
  for (std::size_t i = 0; i < course.points; ++i)
    control[i + 1] = std::max(0.0, std::min(course.stage(i).reached(control[i]), control[i + 1]));
  return control;
}

}  // namespace passes
