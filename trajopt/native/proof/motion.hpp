// A trajectory of the group's joints moving the arm: positions of its joints and bounds on how they change.
#pragma once

#include "curve.hpp"
#include "travel.hpp"

namespace proof {

struct Motion {
  Curve position, velocity, acceleration;  // Of the group's joints.
  Eigen::MatrixXd expand;                  // (joints of the arm but the world, joints of the group).
  Eigen::VectorXd offset;
  bool smooth = true;                      // The velocity has no jumps.

  double begin() const { return position.times.front(); }
  double end() const { return position.times.back(); }
  double duration() const { return end() - begin(); }
  // Positions of the arm's joints but the world's.
  std::vector<double> joints(double time) const;
  JointBounds bounds(double begin, double end) const;
};

}  // namespace proof
