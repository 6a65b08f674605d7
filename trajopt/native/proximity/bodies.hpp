// Collision bodies: where they are at a configuration, and bounds of distance and of motion.
//
// A body is bounded by the box of its shape and by the sphere around that box. The motion of a body between two
// places is bounded by |dc| + |dR|_F / sqrt(2) r, with c the sphere's centre and r its radius: the chord of a
// rotation by angle a is 2 sin(a / 2) r, and |dR|_F = 2 sqrt(2) sin(a / 2).
#pragma once

#include <coal/collision_object.h>
#include <pinocchio/spatial/se3.hpp>

#include <algorithm>
#include <cmath>
#include <memory>

#include "enclosure.hpp"
#include "support.hpp"

namespace proximity {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

struct Body {
  int joint;              // 0: the world
  Matrix3 rotation;       // of the shape in the joint's frame
  Vector3 translation;
  Vector3 centre;         // of its bounding box, in the joint's frame
  Vector3 half;           // of the box's edges
  double radius;          // of the sphere around it
  std::shared_ptr<const coal::CollisionGeometry> geometry;
  std::shared_ptr<const Solid> solid;
  Support support;
  Vector3 middle;         // of its bounding box, in the shape's frame

  std::shared_ptr<const Body> element;  // of a cloud, one ball or cube about its origin; none for other shapes

  bool is_mesh() const { return geometry->getObjectType() == coal::OT_BVH; }
};

// Where a body is in the world.
struct Place {
  Matrix3 rotation;
  Vector3 centre;
};

inline Place place(const Body& body, const pinocchio::SE3& joint) {
  return {joint.rotation() * body.rotation, joint.rotation() * body.centre + joint.translation()};
}

inline coal::Transform3s transform(const Body& body, const Place& at, const pinocchio::SE3& joint) {
  return {at.rotation, joint.rotation() * body.translation + joint.translation()};
}

// How far any point of the body is between two places, at most.
inline double motion(const Body& body, const Place& from, const Place& to) {
  const double turn = (to.rotation - from.rotation).norm() * M_SQRT1_2;
  return (to.centre - from.centre).norm() + turn * body.radius;
}

// Distance from a sphere to a box, squared and without the sphere's radius.
inline double outside_squared(const Body& box, const Place& at, const Vector3& centre) {
  const Vector3 local = at.rotation.transpose() * (centre - at.centre);
  return (local.cwiseAbs() - box.half).cwiseMax(0.0).squaredNorm();
}

// Distance of two bodies, at least: each one's sphere against the other's box, and where that leaves them within
// reach, each one's box wrapped along the other's axes.
inline double lower_bound(const Body& a, const Place& at_a, const Body& b, const Place& at_b, double reach) {
  const Vector3 apart = at_b.centre - at_a.centre;
  const Vector3 outside_a = (at_a.rotation.transpose() * apart).cwiseAbs() - a.half;
  const Vector3 outside_b = (at_b.rotation.transpose() * apart).cwiseAbs() - b.half;
  const double spheres = std::max(outside_a.cwiseMax(0.0).norm() - b.radius, outside_b.cwiseMax(0.0).norm() - a.radius);
  if (spheres > reach) return spheres;
  const Matrix3 turned = (at_a.rotation.transpose() * at_b.rotation).cwiseAbs();
  const double boxes_a = (outside_a - turned * b.half).cwiseMax(0.0).squaredNorm();
  const double boxes_b = (outside_b - turned.transpose() * a.half).cwiseMax(0.0).squaredNorm();
  const double boxes = std::sqrt(std::max(boxes_a, boxes_b));
  return boxes > 0.0 ? std::max(spheres, boxes) : spheres;
}

// Whether these bounds show that two bodies keep a distance: their `lower_bound` exceeds it, asked with no more of it than
// it takes.
inline bool bounds_exceed(const Body& a, const Place& at_a, const Body& b, const Place& at_b, double reach) {
  const auto exceeds = [](const Vector3& outside, double most) { return most < 0.0 || outside.cwiseMax(0.0).squaredNorm() > most * most; };
  const Vector3 apart = at_b.centre - at_a.centre;
  const Vector3 outside_b = (at_b.rotation.transpose() * apart).cwiseAbs() - b.half;
  if (exceeds(outside_b, a.radius + reach)) return true;
  const Vector3 outside_a = (at_a.rotation.transpose() * apart).cwiseAbs() - a.half;
  if (exceeds(outside_a, b.radius + reach)) return true;
  const Matrix3 turned = (at_a.rotation.transpose() * at_b.rotation).cwiseAbs();
  const double most = std::max(reach, 0.0);
  return exceeds(outside_b - turned.transpose() * a.half, most) || exceeds(outside_a - turned * b.half, most);
}

}  // namespace proximity
