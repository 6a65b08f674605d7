// Joint torques of many states, by the recursive Newton-Euler algorithm, and those of gravity with derivatives.
#pragma once

#include <memory>

#include "../robot_query.hpp"
#include "robot.hpp"

namespace proximity {

// Owns pinocchio's scratch, so one per thread.
class Dynamics : public robot::RobotDynamics {
 public:
  explicit Dynamics(Robot robot);
  ~Dynamics() override;

  int dofs() const override { return robot_.dofs(); }

  // Torques of the group's joints; joints that mimic one hand theirs to it (virtual work).
  void torques(const double* positions, const double* velocities, const double* accelerations,
               double* torques) override;

  // Their derivatives, row by row.
  // Source: Carpentier and Mansard, Analytical derivatives of rigid body dynamics algorithms, RSS 2018.
  void slopes(const double* positions, const double* velocities, const double* accelerations, double* by_position,
              double* by_velocity, double* by_acceleration) override;

  // Torques that hold the group's joints still, and their derivatives by its positions, row by row; same source.
  void gravity(const double* positions, double* torques, double* slopes);

 private:
  void take(const double* positions, const double* velocities, const double* accelerations);

  // Derivatives by the group's joints of those by the model's, row by row.
  template <class Full>
  void by_group(const Full& full, double* slopes) const;

  Robot robot_;
  const bool same_joints_;  // the group's are the model's: none mimics another
  std::unique_ptr<pinocchio::Data> data_;
  Eigen::VectorXd q_, velocity_, acceleration_;
  Eigen::MatrixXd slope_;  // entries between joints of different branches are never written: they stay 0
};

}  // namespace proximity
