// Kinematics of a reduced model: the group's positions in, joint placements and their velocities out.
#pragma once

#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/multibody/model.hpp>
#include <pinocchio/multibody/visitor.hpp>

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

using Placements = pinocchio::container::aligned_vector<pinocchio::SE3>;

// Places a joint on its parent: what pinocchio's forwardKinematics does of each.
struct Placing : pinocchio::fusion::JointUnaryVisitorBase<Placing> {
  using ArgsType = boost::fusion::vector<const pinocchio::Model&, const Eigen::VectorXd&, Placements&>;

  template <typename JointModel>
  static void algo(const pinocchio::JointModelBase<JointModel>& kind,
                   pinocchio::JointDataBase<typename JointModel::JointDataDerived>& data, const pinocchio::Model& model,
                   const Eigen::VectorXd& q, Placements& placed) {
    const auto joint = kind.id(), parent = model.parents[kind.id()];
    kind.calc(data.derived(), q);
    const pinocchio::SE3 moved = model.jointPlacements[joint] * data.M();
    if (parent > 0) {
      placed[joint] = placed[parent] * moved;
    } else {
      placed[joint] = moved;
    }
  }
};

// Placements of all joints at one configuration; owns the joints' scratch, so one per thread. It does without
// pinocchio's data of a model, which holds tensors as large as the cube of the number of joints: where time drives
// three joints of each of fifty things these are a hundred megabytes, all of them set to zero.
class Kinematics {
 public:
  explicit Kinematics(const Robot& robot)
      : robot_(robot), q_(robot.neutral()), placed_(robot.joints(), pinocchio::SE3::Identity()) {
    for (int joint = 1; joint < robot.joints(); ++joint) moved_.push_back(robot.model->joints[joint].createData());
  }

  const Placements& operator()(const double* positions) {
    robot_.configure(positions, q_);
    for (int joint = 1; joint < robot_.joints(); ++joint) {
      Placing::run(robot_.model->joints[joint], moved_[joint - 1], Placing::ArgsType(*robot_.model, q_, placed_));
    }
    return placed_;
  }

 private:
  const Robot& robot_;
  Eigen::VectorXd q_;
  Placements placed_;                                        // by joint
  pinocchio::container::aligned_vector<pinocchio::JointData> moved_;  // by joint, the root left out
};

}  // namespace proximity
