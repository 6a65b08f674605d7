#include <boost/python/extract.hpp>  // before pinocchio, which sets limits of boost.mpl that it cannot use

#include "robot.hpp"

#include <pinocchio/multibody/model.hpp>
#include <pinocchio/multibody/visitor.hpp>

#include <cmath>
#include <stdexcept>

namespace proximity {

namespace {

template <class Data>
pinocchio::JointDataBase<Data>& base(pinocchio::JointDataBase<Data>& data) {
  return data;
}

// Visitors of a joint's own kind. The constructor of Robot refuses kinds of several degrees of freedom, so these are left
// out of the compilation.

// The velocity of a joint at unit speed, in its own frame.
struct Axis : pinocchio::fusion::JointUnaryVisitorBase<Axis> {
  using ArgsType = boost::fusion::vector<const Eigen::VectorXd&, pinocchio::Motion&>;

  template <typename Kind>
  static void algo(const pinocchio::JointModelBase<Kind>& kind, const Eigen::VectorXd& q, pinocchio::Motion& axis) {
    if constexpr (Kind::NV == 1) {
      auto made = kind.createData();
      kind.calc(made, q);
      axis = pinocchio::Motion(base(made).S().matrix().col(0));
    }
  }
};

// Places a joint on its parent: what pinocchio's forwardKinematics does of each.
struct Placing : pinocchio::fusion::JointUnaryVisitorBase<Placing> {
  using ArgsType = boost::fusion::vector<const pinocchio::Model&, const Eigen::VectorXd&, Placements&>;

  template <typename Kind>
  static void algo(const pinocchio::JointModelBase<Kind>& kind, const pinocchio::Model& model, const Eigen::VectorXd& q,
                   Placements& placed) {
    if constexpr (Kind::NV == 1) {
      const auto joint = kind.id(), parent = model.parents[kind.id()];
      auto made = kind.createData();
      kind.calc(made, q);
      const pinocchio::SE3 moved = model.jointPlacements[joint] * base(made).M();
      if (parent > 0) {
        placed[joint] = placed[parent] * moved;
      } else {
        placed[joint] = moved;
      }
    }
  }
};

}  // namespace

const pinocchio::Model* pinocchio_model(PyObject* object) {
  const boost::python::extract<const pinocchio::Model&> extracted(object);
  return extracted.check() ? &extracted() : nullptr;
}

Robot::Robot(const pinocchio::Model& handed, Eigen::MatrixXd map, Eigen::VectorXd shift)
    : model(&handed), expand(std::move(map)), offset(std::move(shift)) {
  for (int joint = 1; joint < model->njoints; ++joint) {
    if (model->nvs[joint] != 1) throw std::invalid_argument("each joint of a reduced model needs one degree of freedom");
  }
  axis.resize(model->njoints, pinocchio::Motion::Zero());
  supports.resize(model->njoints);
  driven.resize(model->njoints);
  for (int joint = 1; joint < model->njoints; ++joint) {
    supports[joint] = supports[model->parents[joint]];
    supports[joint].push_back(joint);
    const auto row = expand.row(column(joint));
    for (int drive = 0; drive < dofs(); ++drive) {
      if (row[drive] != 0.0) driven[joint].push_back({drive, row[drive]});
    }
  }
  const Eigen::VectorXd q = neutral();
  for (int joint = 1; joint < model->njoints; ++joint) Axis::run(model->joints[joint], Axis::ArgsType(q, axis[joint]));
}

int Robot::column(int joint) const { return model->idx_vs[joint]; }

void Robot::configure(const double* positions, Eigen::VectorXd& q) const {
  for (int joint = 1; joint < model->njoints; ++joint) {
    double value = 0.0;
    for (const Drive& drive : driven[joint]) value += drive.factor * positions[drive.joint];
    value += offset[column(joint)];
    const int at = model->idx_qs[joint];
    if (model->nqs[joint] == 1) {
      q[at] = value;
    } else {
      q[at] = std::cos(value);
      q[at + 1] = std::sin(value);
    }
  }
}

Eigen::VectorXd Robot::neutral() const {
  Eigen::VectorXd q(model->nq), zero = Eigen::VectorXd::Zero(dofs());
  configure(zero.data(), q);
  return q;
}

const Placements& Kinematics::operator()(const double* positions) {
  robot_.configure(positions, q_);
  for (int joint = 1; joint < robot_.joints(); ++joint) {
    Placing::run(robot_.model->joints[joint], Placing::ArgsType(*robot_.model, q_, placed_));
  }
  return placed_;
}

}  // namespace proximity
