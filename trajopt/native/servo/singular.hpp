// Singular values of a tool's Jacobian and their slopes; see trajopt/driving/servo_task.py.
#pragma once

#include <Eigen/Dense>

namespace servo {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vectors = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Column = Eigen::VectorXd;

// The joints that carry a tool, from the base on: the tool's linear and angular velocity by each, and the speed of each at
// unit speed of the joints of the group.
struct Chain {
  Eigen::Map<const Vectors> linear, angular;
  Eigen::Map<const Rows> mimic;
  double length;  // weight of angular velocities [m]
};

struct Singular {
  Rows left;    // vectors as columns, 6 x m
  Column values;
  Rows right;   // vectors as rows, m x joints
  Rows slopes;  // m x joints
};

inline Rows jacobian(const Chain& chain) {
  Rows columns(chain.linear.rows(), 6);
  columns << chain.linear, chain.length * chain.angular;
  return columns.transpose() * chain.mimic;
}

// The slope of a singular value by joint i is u . dJ/dq_i v. Joint a turns the columns of joint b, which is farther from
// the base, by w_a x l_b and w_a x w_b.
inline Singular singular_values(const Chain& chain) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> found(jacobian(chain), Eigen::ComputeThinU | Eigen::ComputeThinV);
  Singular singular{found.matrixU(), found.singularValues(), found.matrixV().transpose(), {}};
  const Eigen::Index joints = chain.linear.rows();
  Rows slopes = Rows::Zero(singular.values.size(), joints);
  for (Eigen::Index place = 0; place < singular.values.size(); ++place) {
    const Eigen::Vector3d pulled = singular.left.col(place).head<3>(), turned = singular.left.col(place).tail<3>();
    const Column rates = chain.mimic * singular.right.row(place).transpose();
    for (Eigen::Index far = 0; far < joints; ++far) {
      const Eigen::Vector3d moved = Eigen::Vector3d(chain.linear.row(far)).cross(pulled);
      const Eigen::Vector3d spun = chain.length * Eigen::Vector3d(chain.angular.row(far)).cross(turned);
      for (Eigen::Index near = 0; near <= far; ++near) {
        const double by_moving = chain.angular.row(near).dot(moved);
        slopes(place, near) += (by_moving + chain.angular.row(near).dot(spun)) * rates[far];
        if (near < far) slopes(place, far) += by_moving * rates[near];
      }
    }
  }
  singular.slopes = slopes * chain.mimic;
  return singular;
}

// How far each singular value is above the one at which a joint reaches its velocity limit on a twist, in lengths.
inline Column room(const Singular& singular, const Column& twist, const Column& velocity, double ending) {
  const Column along = singular.slopes.cwiseProduct(singular.right).rowwise().sum().cwiseAbs();
  const Column component = (singular.left.transpose() * twist).cwiseAbs();
  const double whole = twist.norm();
  Column room(singular.values.size());
  for (Eigen::Index place = 0; place < room.size(); ++place) {
    const double size = along[place] > ending * singular.slopes.row(place).norm() ? component[place] : whole;
    const double slowest = (singular.right.row(place).transpose().cwiseAbs().array() / velocity.array()).maxCoeff();
    room[place] = std::max(singular.values[place] - size * slowest, 0.0);
  }
  return room;
}

}  // namespace servo
