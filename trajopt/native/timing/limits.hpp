// What limits a profile: linear constraints on path acceleration and squared path speed, tools, torques.
//
// Source: Pham and Pham, A new approach to time-optimal path parameterization based on reachability analysis, IEEE
// T-RO 34(3), 2018.
//
// Grids are many and fine, and the torque along a path changes slowly: so the inverse dynamics are evaluated once, at
// the ends and the middle of panels of the path, and every grid interpolates the torque by parabolas through them. No
// panel reaches beyond a knot of the path, where the derivative of the curvature jumps. What the parabolas miss shows
// when the trajectory is measured (`torque_range`).
//
// The same in plain Python, compared with this in the tests: tests/oracles/retiming/constraints.py.
#pragma once

#include <functional>

#include "paths.hpp"

namespace timing {

// States of the joints, positions, velocities and accelerations -> torques of the limited joints.
using Torques = std::function<Table(const Table&, const Table&, const Table&)>;
// Positions and velocities -> speeds of the limited tools.
using Speeds = std::function<Table(const Table&, const Table&)>;

constexpr double kReach = 0.8;         // REACH of constraints.py, and so on: what joints move in a panel at most
constexpr double kMostPanels = 500.0;  // panels of very long paths are longer, so that there are about as many
constexpr double kLargestSquaredSpeed = 1e8;  // where no velocity limit binds, since all joints turn back at once

// The limits of a motion, what is left to be used of each; of torques and tools none where there is no function.
struct Limits {
  Numbers velocity, acceleration, jerk;  // of the n joints; those of the jerk may be infinite
  Torques torques;
  Numbers torque;
  Speeds speeds;
  Numbers tool;

  std::size_t joints() const { return velocity.size(); }
  std::size_t speed_columns() const { return joints() + tool.size(); }
  std::size_t row_columns() const { return joints() + torque.size(); }
};

// Limits |a u + b x + c| <= limit at every grid point, one column a limit: factors of the path acceleration and of the
// squared path speed, and what remains at rest (gravity).
struct Rows {
  Table a, b, c;
};

// Torque along a path as a u + b x + c.
class TorqueAlong {
 public:
  TorqueAlong() = default;

  // With v = q' ds/dt and a = q' u + q'' x the equation of motion M(q) a + C(q, v) v + g(q) gives a = M q',
  // b = M q'' + C(q, q') q', c = g. Torque that is not of this form (friction) is not seen here, but is when the
  // trajectory is measured.
  TorqueAlong(const SmoothPath& path, const Limits& limits) : edges_(panels(path)), columns_(limits.torque.size()) {
    const std::size_t count = edges_.size(), asked = 2 * count - 1, joints = path.joints();
    Table q(3 * asked, joints), v(3 * asked, joints), a(3 * asked, joints);
    Numbers values(3 * joints);
    for (std::size_t i = 0; i < asked; ++i) {
      const double s = i < count ? edges_[i] : (edges_[i - count] + edges_[i - count + 1]) / 2.0;
      path.at(s, 2, values.data());
      for (std::size_t kind = 0; kind < 3; ++kind) q.set(kind * asked + i, values.data());
      a.set(i, values.data() + joints), v.set(asked + i, values.data() + joints);
      a.set(asked + i, values.data() + 2 * joints);
    }
    table_ = limits.torques(q, v, a);
    for (std::size_t i = 0; i < asked; ++i) {
      for (std::size_t column = 0; column < columns_; ++column) {
        table_[i][column] -= table_[2 * asked + i][column];
        table_[asked + i][column] -= table_[2 * asked + i][column];
      }
    }
  }

  // Factors at a parameter of the path.
  void at(double s, double* a, double* b, double* c) const {
    const std::size_t count = edges_.size(), asked = 2 * count - 1;
    const std::size_t panel = std::upper_bound(edges_.begin() + 1, edges_.end() - 1, s) - edges_.begin() - 1;
    const double part = (s - edges_[panel]) / (edges_[panel + 1] - edges_[panel]);
    double* found[3] = {a, b, c};
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const double *begin = table_[kind * asked + panel], *end = table_[kind * asked + panel + 1];
      const double* middle = table_[kind * asked + count + panel];
      for (std::size_t column = 0; column < columns_; ++column) {
        const double bend = 2.0 * (begin[column] - 2.0 * middle[column] + end[column]);
        found[kind][column] = begin[column] + part * ((end[column] - begin[column]) - bend * (1.0 - part));
      }
    }
  }

 private:
  // Cuts the pieces of a path evenly.
  static Numbers panels(const SmoothPath& path) {
    Numbers values(2 * path.joints()), moved;
    const auto speed = [&](double s) {
      path.at(s, 1, values.data());
      double sum = 0.0;
      for (std::size_t joint = 0; joint < path.joints(); ++joint) sum += std::abs(values[path.joints() + joint]);
      return sum;
    };
    double total = 0.0;
    for (std::size_t i = 0; i + 1 < path.knots.size(); ++i) {
      const double begin = path.knots[i], end = path.knots[i + 1];
      moved.push_back(std::max({speed(begin), speed(end), speed((begin + end) / 2.0)}) * (end - begin));
      total += moved.back();
    }
    const double reach = std::max(kReach, total / kMostPanels);
    std::vector<std::size_t> parts;
    for (const double each : moved) parts.push_back(parts_of(std::ceil(each / reach)));
    return cut(path.knots, parts);
  }

  Numbers edges_;  // where the panels meet
  std::size_t columns_ = 0;
  Table table_;  // of a, of b, of c: at all edges, then in all middles
};

// The bound of x = (ds/dt)² at a station by the velocity limits.
inline double squared_speed_bound(const double* slope, const double* velocity, std::size_t count) {
  const double fastest = std::sqrt(kLargestSquaredSpeed);
  double least = fastest;
  for (std::size_t column = 0; column < count; ++column) {
    const double steep = std::abs(slope[column]);
    if (steep > velocity[column] / fastest) least = std::min(least, velocity[column] / steep);
  }
  return least * least;
}

}  // namespace timing
