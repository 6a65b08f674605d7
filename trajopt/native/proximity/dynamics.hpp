// Joint torques of many states, by the recursive Newton-Euler algorithm.
#pragma once

#include <pinocchio/algorithm/rnea.hpp>

#include "robot.hpp"

namespace proximity {

// Owns pinocchio's scratch, so one per thread.
class Dynamics {
 public:
  explicit Dynamics(Robot robot) : robot_(std::move(robot)), data_(*robot_.model), q_(robot_.neutral()) {}

  int dofs() const { return robot_.dofs(); }

  // Torques of the group's joints; joints that mimic one hand theirs to it (virtual work).
  void operator()(const double* positions, const double* velocities, const double* accelerations, double* torques) {
    using Vector = Eigen::Map<const Eigen::VectorXd>;
    robot_.configure(positions, q_);
    const auto& full = pinocchio::rnea(*robot_.model, data_, q_, robot_.expand * Vector(velocities, dofs()),
                                       robot_.expand * Vector(accelerations, dofs()));
    Eigen::Map<Eigen::VectorXd>(torques, dofs()) = robot_.expand.transpose() * full;
  }

 private:
  Robot robot_;
  pinocchio::Data data_;
  Eigen::VectorXd q_;
};

}  // namespace proximity
