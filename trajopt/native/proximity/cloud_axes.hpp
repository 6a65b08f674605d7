// Along which axes a cloud's flat parts are flat, as far as they agree.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace proximity {

// What space is cut into has so many cells at most.
constexpr double kMostCells = 4e6;

// The axis-aligned box around points.
struct Bounds {
  using Vector3 = Eigen::Vector3d;

  explicit Bounds(const std::vector<Vector3>& points) : low(points[0]), high(points[0]) {
    for (const Vector3& point : points) low = low.cwiseMin(point), high = high.cwiseMax(point);
  }
  Vector3 low, high;
};

// Columns: the axes.
Eigen::Matrix3d axes_of(const std::vector<Eigen::Vector3d>& cloud);

}  // namespace proximity
