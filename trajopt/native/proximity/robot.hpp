// Kinematics of a reduced model: the group's positions in, joint placements and their velocities out.
#pragma once

#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>

#include <cmath>
#include <vector>

namespace proximity {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

// A joint of the group that moves a joint of the model, and how far it does.
struct Drive {
  int joint;
  double factor;
};

// What never changes: pinocchio's model as Python made it, and the map from the group's positions to it.
struct Robot {
  const pinocchio::Model* model;
  Eigen::MatrixXd expand;  // model joints by group joints
  Eigen::VectorXd offset;  // of joints that mimic others
  std::vector<pinocchio::Motion> axis;           // of each joint at unit speed, in its own frame
  std::vector<std::vector<int>> supports;        // joints from the root that carry each joint, itself included
  std::vector<std::vector<Drive>> driven;        // by which of the group's joints each joint is moved

  Robot(const pinocchio::Model& handed, Eigen::MatrixXd map, Eigen::VectorXd shift)
      : model(&handed), expand(std::move(map)), offset(std::move(shift)) {
    axis.resize(model->njoints, pinocchio::Motion::Zero());
    supports.resize(model->njoints);
    driven.resize(model->njoints);
    Eigen::VectorXd q = neutral();
    for (int joint = 1; joint < model->njoints; ++joint) {
      auto data = model->joints[joint].createData();
      model->joints[joint].calc(data, q);
      axis[joint] = pinocchio::Motion(data.S().matrix().col(0));
      supports[joint] = supports[model->parents[joint]];
      supports[joint].push_back(joint);
      const auto row = expand.row(model->joints[joint].idx_v());
      for (int drive = 0; drive < dofs(); ++drive) {
        if (row[drive] != 0.0) driven[joint].push_back({drive, row[drive]});
      }
    }
  }

  int joints() const { return model->njoints; }
  int dofs() const { return static_cast<int>(expand.cols()); }

  // Pinocchio writes an unbounded joint as cosine and sine; the group's positions have one number a joint.
  void configure(const double* positions, Eigen::VectorXd& q) const {
    const Eigen::VectorXd values = expand * Eigen::Map<const Eigen::VectorXd>(positions, dofs()) + offset;
    for (int joint = 1; joint < model->njoints; ++joint) {
      const auto& kind = model->joints[joint];
      const double value = values[kind.idx_v()];
      if (kind.nq() == 1) {
        q[kind.idx_q()] = value;
      } else {
        q[kind.idx_q()] = std::cos(value);
        q[kind.idx_q() + 1] = std::sin(value);
      }
    }
  }

  Eigen::VectorXd neutral() const {
    Eigen::VectorXd q(model->nq), zero = Eigen::VectorXd::Zero(dofs());
    configure(zero.data(), q);
    return q;
  }
};

// Placements of all joints at one configuration; owns pinocchio's scratch, so one per thread.
class Kinematics {
 public:
  explicit Kinematics(const Robot& robot) : robot_(robot), data_(*robot.model), q_(robot.neutral()) {
    data_.oMi[0].setIdentity();
  }

  const pinocchio::container::aligned_vector<pinocchio::SE3>& operator()(const double* positions) {
    robot_.configure(positions, q_);
    pinocchio::forwardKinematics(*robot_.model, data_, q_);
    return data_.oMi;
  }

 private:
  const Robot& robot_;
  pinocchio::Data data_;
  Eigen::VectorXd q_;
};

}  // namespace proximity
