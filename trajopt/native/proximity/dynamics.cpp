#include "dynamics.hpp"

#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>

namespace proximity {

namespace {
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
}  // namespace

Dynamics::Dynamics(Robot robot)
    : robot_(std::move(robot)),
      same_joints_(robot_.expand.isIdentity(0.0)),
      data_(std::make_unique<pinocchio::Data>(*robot_.model)),
      q_(robot_.neutral()),
      velocity_(robot_.model->nv),
      acceleration_(robot_.model->nv),
      slope_(Eigen::MatrixXd::Zero(robot_.model->nv, robot_.model->nv)) {}

Dynamics::~Dynamics() = default;

template <class Full>
void Dynamics::by_group(const Full& full, double* slopes) const {
  Eigen::Map<RowMajor> found(slopes, dofs(), dofs());
  if (same_joints_) {
    found = full;
  } else {
    found = robot_.expand.transpose() * full * robot_.expand;
  }
}

void Dynamics::torques(const double* positions, const double* velocities, const double* accelerations,
                       double* torques) {
  take(positions, velocities, accelerations);
  const auto& full = pinocchio::rnea(*robot_.model, *data_, q_, velocity_, acceleration_);
  Eigen::Map<Eigen::VectorXd>(torques, dofs()).noalias() = robot_.expand.transpose() * full;
}

void Dynamics::slopes(const double* positions, const double* velocities, const double* accelerations,
                      double* by_position, double* by_velocity, double* by_acceleration) {
  take(positions, velocities, accelerations);
  pinocchio::computeRNEADerivatives(*robot_.model, *data_, q_, velocity_, acceleration_);
  // Only the upper half of the mass matrix is written.
  data_->M.triangularView<Eigen::StrictlyLower>() = data_->M.transpose().triangularView<Eigen::StrictlyLower>();
  by_group(data_->dtau_dq, by_position);
  by_group(data_->dtau_dv, by_velocity);
  by_group(data_->M, by_acceleration);
}

void Dynamics::gravity(const double* positions, double* torques, double* slopes) {
  robot_.configure(positions, q_);
  pinocchio::computeGeneralizedGravityDerivatives(*robot_.model, *data_, q_, slope_);
  Eigen::Map<Eigen::VectorXd>(torques, dofs()) = robot_.expand.transpose() * data_->g;
  by_group(slope_, slopes);
}

void Dynamics::take(const double* positions, const double* velocities, const double* accelerations) {
  using Vector = Eigen::Map<const Eigen::VectorXd>;
  robot_.configure(positions, q_);
  velocity_.noalias() = robot_.expand * Vector(velocities, dofs());
  acceleration_.noalias() = robot_.expand * Vector(accelerations, dofs());
}

}  // namespace proximity
