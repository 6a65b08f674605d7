// Joint torques of many states, by the recursive Newton-Euler algorithm, and those of gravity with derivatives.
#pragma once

#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include "../robot_query.hpp"
#include "robot.hpp"

namespace proximity {

// Owns pinocchio's scratch, so one per thread.
class Dynamics : public robot::RobotDynamics {
 public:
  explicit Dynamics(Robot robot) : robot_(std::move(robot)), data_(*robot_.model), q_(robot_.neutral()),
        velocity_(robot_.model->nv), acceleration_(robot_.model->nv),
        slope_(Eigen::MatrixXd::Zero(robot_.model->nv, robot_.model->nv)) {}

  int dofs() const override { return robot_.dofs(); }

  // Torques of the group's joints; joints that mimic one hand theirs to it (virtual work).
  void torques(const double* positions, const double* velocities, const double* accelerations,
               double* torques) override {
    take(positions, velocities, accelerations);
    const auto& full = pinocchio::rnea(*robot_.model, data_, q_, velocity_, acceleration_);
    Eigen::Map<Eigen::VectorXd>(torques, dofs()).noalias() = robot_.expand.transpose() * full;
  }

  // Their derivatives, row by row.
  // Source: Carpentier and Mansard, Analytical derivatives of rigid body dynamics algorithms, RSS 2018.
  void slopes(const double* positions, const double* velocities, const double* accelerations, double* by_position,
              double* by_velocity, double* by_acceleration) override {
    take(positions, velocities, accelerations);
    pinocchio::computeRNEADerivatives(*robot_.model, data_, q_, velocity_, acceleration_);
    // Only the upper half of the mass matrix is written.
    data_.M.triangularView<Eigen::StrictlyLower>() = data_.M.transpose().triangularView<Eigen::StrictlyLower>();
    const auto by_group = [&](const auto& full, double* slopes) {
      Eigen::Map<RowMajor>(slopes, dofs(), dofs()) = robot_.expand.transpose() * full * robot_.expand;
    };
    by_group(data_.dtau_dq, by_position);
    by_group(data_.dtau_dv, by_velocity);
    by_group(data_.M, by_acceleration);
  }

  // Torques that hold the group's joints still, and their derivatives by its positions, row by row; same source.
  void gravity(const double* positions, double* torques, double* slopes) {
    robot_.configure(positions, q_);
    pinocchio::computeGeneralizedGravityDerivatives(*robot_.model, data_, q_, slope_);
    Eigen::Map<Eigen::VectorXd>(torques, dofs()) = robot_.expand.transpose() * data_.g;
    Eigen::Map<RowMajor>(slopes, dofs(), dofs()) = robot_.expand.transpose() * slope_ * robot_.expand;
  }

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  void take(const double* positions, const double* velocities, const double* accelerations) {
    using Vector = Eigen::Map<const Eigen::VectorXd>;
    robot_.configure(positions, q_);
    velocity_.noalias() = robot_.expand * Vector(velocities, dofs());
    acceleration_.noalias() = robot_.expand * Vector(accelerations, dofs());
  }

  Robot robot_;
  pinocchio::Data data_;
  Eigen::VectorXd q_, velocity_, acceleration_;
  Eigen::MatrixXd slope_;  // entries between joints of different branches are never written: they stay 0
};

}  // namespace proximity
