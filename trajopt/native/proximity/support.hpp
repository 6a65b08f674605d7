// What GJK asks of a body: its farthest point along a direction, in its own frame, without the sphere swept around it.
#pragma once

#include <coal/narrowphase/support_functions.h>

#include "polytope.hpp"

namespace proximity {

struct Support {
  using Vector3 = Eigen::Vector3d;
  using Farthest = void (*)(const Support&, const Vector3& direction, Vector3& found, coal::details::ShapeSupportData&);

  coal::NODE_TYPE type = coal::BV_UNKNOWN;
  const coal::ShapeBase* shape = nullptr;
  const Polytope* polytope = nullptr;
  double swept = 0.0;           // radius of the sphere
  Farthest farthest = nullptr;  // none for what has no farthest point: meshes and half-spaces

  static Support of(const coal::CollisionGeometry& geometry, const Polytope* polytope);
};

namespace supports {

inline void of_box(const Support& support, const Eigen::Vector3d& direction, Eigen::Vector3d& found,
                   coal::details::ShapeSupportData&) {
  // Of a face or an edge that is farthest as a whole the middle: any corner of it would prefer a side.
  constexpr double kFlat = 1e-12;
  const Eigen::Vector3d& half = static_cast<const coal::Box*>(support.shape)->halfSide;
  for (int axis = 0; axis < 3; ++axis) {
    found[axis] = std::abs(direction[axis]) > kFlat ? std::copysign(half[axis], direction[axis]) : 0.0;
  }
}

inline void of_polytope(const Support& support, const Eigen::Vector3d& direction, Eigen::Vector3d& found,
                    coal::details::ShapeSupportData&) {
  found = support.polytope->farthest(direction);
}

template <class Shape>
void of_shape(const Support& support, const Eigen::Vector3d& direction, Eigen::Vector3d& found,
              coal::details::ShapeSupportData& data) {
  int hint = 0;
  coal::details::getShapeSupport<coal::details::SupportOptions::NoSweptSphere>(static_cast<const Shape*>(support.shape),
                                                                               direction, found, hint, data);
}

}  // namespace supports

inline Support Support::of(const coal::CollisionGeometry& geometry, const Polytope* polytope) {
  Support support;
  support.type = geometry.getNodeType();
  support.polytope = polytope;
  if (geometry.getObjectType() != coal::OT_GEOM) return support;
  support.shape = static_cast<const coal::ShapeBase*>(&geometry);
  support.swept = support.shape->getSweptSphereRadius();
  switch (support.type) {
    case coal::GEOM_BOX:
      support.farthest = supports::of_box;
      break;
    case coal::GEOM_CONVEX:
      support.farthest = supports::of_polytope;
      break;
    case coal::GEOM_CYLINDER:
      support.farthest = supports::of_shape<coal::Cylinder>;
      break;
    case coal::GEOM_CONE:
      support.farthest = supports::of_shape<coal::Cone>;
      break;
    case coal::GEOM_SPHERE:
      support.swept += static_cast<const coal::Sphere*>(support.shape)->radius;
      support.farthest = supports::of_shape<coal::Sphere>;
      break;
    case coal::GEOM_CAPSULE:
      support.swept += static_cast<const coal::Capsule*>(support.shape)->radius;
      support.farthest = supports::of_shape<coal::Capsule>;
      break;
    default:
      break;
  }
  return support;
}

}  // namespace proximity
