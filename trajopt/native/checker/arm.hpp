// Forward kinematics at a grid of times, and bounds on how fast points move within intervals of time.
#pragma once

#include "motion.hpp"

namespace checker {

// Covers the rounding of sums and products of numbers that are not negative: each joint of a chain adds fewer than 20
// operations with a relative error of 1.2e-16, and there are at most 1,000 joints.
constexpr double SAFE = 1.0 + 1e-11;

struct PointTravel {
  double velocity = 0.0, acceleration = 0.0, jerk = 0.0;
};

// The rotation of a joint in its parent: A + B sin q + C cos q (Rodrigues).
struct Turning {
  std::array<double, 9> still{}, of_sine{}, of_cosine{};
  double error = 0.0;
  Turn at(Ball position) const;
};
Turning turning(const Joint& joint);

// The direction in its parent's frame along which a joint slides; zero if it turns.
inline Vec slide(const Joint& joint) { return joint.turns ? Vec{} : turned(joint.place.rotation, joint.axis); }

// A robot along its motion; joint 0 is the world, and rows of the arrays are of all joints.
struct Arm {
  const Statement& statement;
  const std::vector<double>& grid;
  Motion motion;
  int joints;                            // the world included
  std::vector<Turn> own, rotation;       // of joints in their parents and in the world, at each time
  std::vector<Vec> translation, axes;    // of joints in the world, at each time
  std::vector<bool> carried_by;          // whether a joint (row) is, or hangs on, another
  std::vector<bool> driven, moved;       // whether a joint follows time, and whether the robot moves it
  std::array<std::vector<double>, 3> rates;  // largest velocity, acceleration and jerk in each cell

  Arm(const Statement& statement, const std::vector<double>& grid);
  bool carries(int joint, int part) const { return carried_by[part * joints + joint]; }
  int at(int time, int joint) const { return time * joints + joint; }
  int parent(int joint) const { return statement.joints[joint - 1].place.joint; }
  // The last joint that carries both.
  int shared(int one, int other) const;
  Vec point(int time, int joint, const Vec& local) const {
    return translation[at(time, joint)] + turned(rotation[at(time, joint)], local);
  }
  // The largest velocity, acceleration and jerk of a joint in cells from a begin to before an end.
  std::array<double, 3> fastest(int joint, int begin, int end) const;

 private:
  std::array<std::vector<std::vector<double>>, 3> largest_;  // by the logarithm of the number of cells
};

// The points of a sphere that a joint carries.
//
// With r the largest distance from the axis of a joint that turns, a point with velocity v, acceleration u and jerk k
// behind that joint has at most v + w r, u + 2 w v + (w^2 + a) r and k + 3 w u + 3 (a + w^2) v + (j + 3 w a + w^3) r
// before it.
class Travel {
 public:
  Travel(const Arm& arm, int joint, const Vec& centre, double radius);
  // Bounds from a begin to an end in the grid, as seen from a joint that carries the first one.
  PointTravel bounds(int begin, int end, int seen);

 private:
  // Distances of the points from the axes of all joints of the chain that turn, at a time.
  const double* levers(int time);

  const Arm& arm_;
  Vec centre_;
  double radius_;
  std::vector<int> chain_;       // from the joint inward
  std::vector<double> levers_;   // negative: not yet known
};

}  // namespace checker
