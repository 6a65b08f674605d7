// What is made of a shape once, for all bodies that have it: its corners and edges where it is convex, and which bodies the
// closed surface of an exact mesh encloses, which Coal's distance to its triangles does not tell.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "cloud_tree.hpp"
#include "polytope.hpp"

namespace proximity {

// What of a shape can be inside another, and what another can be inside of; in the shape's own frame.
class Solid {
 public:
  using Vector3 = Eigen::Vector3d;
  using Triangle = std::array<Vector3, 3>;

  Solid(std::vector<Vector3> points, std::vector<Triangle> shell, std::unique_ptr<const Polytope> polytope,
        std::vector<Vector3> cloud)
      : polytope_(std::move(polytope)), cloud_(std::move(cloud)), points_(std::move(points)), shell_(std::move(shell)) {
    for (const Triangle& triangle : shell_) {
      for (const Vector3& corner : triangle) low_ = low_.cwiseMin(corner), high_ = high_.cwiseMax(corner);
    }
  }

  // Of a convex polytope; none for other shapes.
  const Polytope* polytope() const { return polytope_.get(); }

  // Of a cloud the centres of its balls or cubes; none for other shapes.
  const std::vector<Vector3>& cloud() const { return cloud_; }

  // Of a cloud; made when it is first asked for: beside boxes that contain the cloud nobody may ever ask.
  const CloudTree& tree() const {
    std::call_once(planted_, [&] { tree_ = std::make_unique<const CloudTree>(cloud_); });
    return *tree_;
  }

  // Whether the closed surface winds around a part of a body that is placed in this one's frame.
  bool encloses(const Solid& body, const Eigen::Matrix3d& rotation, const Vector3& translation) const {
    if (shell_.empty()) return false;
    for (const Vector3& point : body.points_) {
      if (winds_around(rotation * point + translation)) return true;
    }
    return false;
  }

 private:
  std::unique_ptr<const Polytope> polytope_;
  std::vector<Vector3> cloud_;
  mutable std::once_flag planted_;
  mutable std::unique_ptr<const CloudTree> tree_;
  std::vector<Vector3> points_;   // One of each connected part.
  std::vector<Triangle> shell_;   // Closed, seen counter-clockwise from outside.
  Vector3 low_ = Vector3::Constant(INFINITY), high_ = Vector3::Constant(-INFINITY);

  // Source: van Oosterom and Strackee, IEEE Trans. Biomedical Engineering, 1983.
  bool winds_around(const Vector3& point) const {
    if ((point.array() < low_.array()).any() || (point.array() > high_.array()).any()) return false;
    double angle = 0.0;
    for (const Triangle& triangle : shell_) {
      const Vector3 a = triangle[0] - point, b = triangle[1] - point, c = triangle[2] - point;
      const double la = a.norm(), lb = b.norm(), lc = c.norm();
      angle += 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return angle > 2.0 * M_PI;
  }
};

}  // namespace proximity
