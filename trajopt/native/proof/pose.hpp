// Rotation and translation of one frame seen from another.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace proof {

using Vec = Eigen::Vector3d;
using Mat = Eigen::Matrix3d;

constexpr double pi = 3.14159265358979323846;

struct Pose {
  Mat R = Mat::Identity();
  Vec p = Vec::Zero();

  Vec operator*(const Vec& point) const { return R * point + p; }
  Pose operator*(const Pose& inner) const { return {R * inner.R, R * inner.p + p}; }
  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

}  // namespace proof
