// The program of a jerk-limited profile: minimise the duration within rows of limits.
//
// The unknowns are control values z at the stations of a squared clock speed y, a quadratic B-spline as in profile.hpp,
// but positive at the ends too. With p = dq/dclock and so on, at a grid point
//
//     acceleration  q'' = p u + p' y,                   u = y' / 2,
//     jerk          q''' = sqrt(y) (p y'' / 2 + 3/2 p' y' + p'' y).
//
// The acceleration is linear in z. The jerk's limit reads |linear in z| <= jerk / sqrt(y), whose right-hand side is
// convex: its tangent lies below, so what holds with the tangent holds exactly.
//
// Source: the form of the rows is that of Debrouwere et al., Time-optimal path following for robots with
// convex-concave constraints using sequential convex programming, IEEE T-RO 29(6), 2013.
// The same in plain Python, compared with this in the tests: tests/oracles/retiming/jerk_program.py.
#pragma once

#include "barrier.hpp"
#include "grid.hpp"

namespace timing {

constexpr double kLargest = 1e4;  // bound of the squared clock speed where nothing else bounds it

class JerkProgram {
 public:
  // The part that does not depend on the limits. Joints that stand still have no rows.
  JerkProgram(const DiscretisedPath& on, const RampedPath& ramp) : on_(on) {
    const std::size_t count = on.pieces(), joints = on.joints(), limited = on.rows.a.columns;
    for (std::size_t joint = 0; joint < joints; ++joint)
      for (std::size_t i = 0; i < on.points(); ++i)
        if (on.dq[i][joint] != 0.0) {
          columns_.push_back(joint);
          break;
        }
    moving_ = columns_.size();
    for (std::size_t column = joints; column < limited; ++column) columns_.push_back(column);
    program_ = barrier::Program(count, columns_.size(), moving_);
    Table starts, ends;
    ramp.third(starts, ends);
    const Numbers station = stations(on.s);
    const auto speeds = [&](std::size_t point, std::size_t place) {  // of y at a grid point, by the stations beside it
      const double part = (on.s[point] - station[point]) / (station[point + 1] - station[point]);
      return place == 0 ? 1.0 - part : part;
    };
    for (std::size_t i = 0; i < count; ++i) {
      const double width = on.s[i + 1] - on.s[i], before = 1.0 / (station[i + 1] - station[i]);
      const double after = 1.0 / (station[i + 2] - station[i + 1]);
      const double speed[2][3] = {{speeds(i, 0), speeds(i, 1), 0.0}, {0.0, speeds(i + 1, 0), speeds(i + 1, 1)}};
      const double rate[2][3] = {{-before, before, 0.0}, {0.0, -after, after}};
      for (std::size_t place = 0; place < 3; ++place) {
        for (std::size_t end = 0; end < 2; ++end) program_.speed_row(end, place, i) = speed[end][place];
        // The share of each control value in the mean of y.
        const double share = (speed[0][place] + speed[1][place]) / 3.0 + (place == 1 ? 1.0 / 3.0 : 0.0);
        program_.weight[i + place] += width * share;
        for (std::size_t j = 0; j < columns_.size(); ++j)
          program_.row(j, place, i) = on.rows.a[i][columns_[j]] * (rate[0][place] / 2.0) +
                                      on.rows.b[i][columns_[j]] * speed[0][place];
        const double curvature = (rate[1][place] - rate[0][place]) / width;
        for (std::size_t end = 0; end < 2; ++end) {
          const double* third = end == 0 ? starts[i] : ends[i];
          for (std::size_t j = 0; j < moving_; ++j) {
            const std::size_t joint = columns_[j];
            program_.row(columns_.size() + end * moving_ + j, place, i) =
                on.dq[i + end][joint] * (curvature / 2.0) + on.ddq[i + end][joint] * (1.5 * rate[end][place]) +
                third[joint] * speed[end][place];
          }
        }
      }
    }
  }

  const DiscretisedPath& on() const { return on_; }

  // Control values of nearly the least duration within limits; no acceleration rises to its limit faster than `shown`
  // says. Empty if no uniform scaling of the start is within them.
  Numbers minimise(const Bounds& bounds, const Numbers& shown, Numbers start, double first_gap, double gap) {
    barrier::Program& program = program_;
    for (std::size_t i = 0; i < program.unknowns(); ++i)
      program.bound[i] =
          std::min(squared_speed_bound(on_.slope[i], bounds.velocity[i], on_.slope.columns), kLargest);
    for (std::size_t i = 0; i < program.blocks; ++i) {
      for (std::size_t j = 0; j < columns_.size(); ++j) {
        const double room = bounds.rows[i][columns_[j]], c = on_.rows.c[i][columns_[j]];
        program.above[j * program.stride + i] = std::max(room - c, passes::kLeastRoom * room);
        program.below[j * program.stride + i] = std::max(room + c, passes::kLeastRoom * room);
      }
      for (std::size_t j = 0; j < moving_; ++j) {
        const double allowed = std::min(bounds.jerk[i][columns_[j]], shown[columns_[j]]);
        for (std::size_t end = 0; end < 2; ++end) program.jerk[(end * moving_ + j) * program.stride + i] = allowed;
      }
    }
    int steps = 0;
    return barrier::minimise(program, std::move(start), first_gap, gap, steps);
  }

 private:
  const DiscretisedPath& on_;
  std::vector<std::size_t> columns_;  // of the moving joints' accelerations and of the torques among the path's rows
  std::size_t moving_ = 0;
  barrier::Program program_;
};

}  // namespace timing
