// Kinematics of a reduced model: the group's positions in, joint placements and their velocities out.
//
// Pinocchio's models and algorithms take most of the time of a compilation: only robot.cpp and dynamics.cpp include them.
#pragma once

#include <pinocchio/container/aligned-vector.hpp>
#include <pinocchio/multibody/fwd.hpp>
#include <pinocchio/spatial/motion.hpp>
#include <pinocchio/spatial/se3.hpp>

#include <vector>

using PyObject = struct _object;

namespace proximity {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

// The model inside an object that boost.python handed out; null for any other object.
const pinocchio::Model* pinocchio_model(PyObject* object);

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

  // Throws std::invalid_argument if a joint of the model has more than one degree of freedom.
  Robot(const pinocchio::Model& handed, Eigen::MatrixXd map, Eigen::VectorXd shift);

  int joints() const { return static_cast<int>(axis.size()); }
  int dofs() const { return static_cast<int>(expand.cols()); }
  // Velocities of the model, and a joint's place among them.
  int columns() const { return static_cast<int>(expand.rows()); }
  int column(int joint) const;

  // Pinocchio writes an unbounded joint as cosine and sine; the group's positions have one number a joint.
  void configure(const double* positions, Eigen::VectorXd& q) const;
  Eigen::VectorXd neutral() const;
};

using Placements = pinocchio::container::aligned_vector<pinocchio::SE3>;

// Placements of all joints at one configuration, kept until the next, so one per thread. It does without pinocchio's
// data of a model, which holds tensors as large as the cube of the number of joints: where time drives three joints of
// each of fifty things these are a hundred megabytes, all of them set to zero.
class Kinematics {
 public:
  explicit Kinematics(const Robot& robot)
      : robot_(robot), q_(robot.neutral()), placed_(robot.joints(), pinocchio::SE3::Identity()) {}

  const Placements& operator()(const double* positions);

 private:
  const Robot& robot_;
  Eigen::VectorXd q_;
  Placements placed_;  // by joint
};

}  // namespace proximity
