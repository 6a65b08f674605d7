// Signed distance of two convex bodies: Coal's GJK and EPA, fed with the farthest points of `Support`.
//
// Between polytopes GJK starts where their boxes say that they come nearest, which is part of its way. On curved bodies
// its last digits hang on where it starts: there it starts as Coal does. It knows nothing of earlier calls, so that its
// digits do not either.
#pragma once

#include <coal/narrowphase/gjk.h>

#include <limits>

#include "bodies.hpp"
#include "support.hpp"

namespace proximity {

struct Nearest {
  double distance;  // signed; beyond the reach only a lower bound, and without points; NaN where Coal has no answer
  Vector3 normal;   // from the first body to the second; beyond the reach a direction along which they are so far apart
  Vector3 first, second;
};

class ConvexPair {
 public:
  explicit ConvexPair(double tolerance) : tolerance_(tolerance), gjk_(kRounds, tolerance), epa_(0, tolerance) {}

  // Whether this measures a pair; Coal has formulas for some, and other means for the rest.
  static bool measures(const Body& a, const Body& b) {
    if (a.support.farthest == nullptr || b.support.farthest == nullptr) return false;
    const auto formula = [](coal::NODE_TYPE one, coal::NODE_TYPE other) {
      const bool round = other == coal::GEOM_SPHERE || other == coal::GEOM_CAPSULE;
      if (one == coal::GEOM_CAPSULE) return round;
      return one == coal::GEOM_SPHERE && (round || other == coal::GEOM_BOX || other == coal::GEOM_CYLINDER);
    };
    return !formula(a.support.type, b.support.type) && !formula(b.support.type, a.support.type);
  }

  // The distance, given up beyond a reach; in penetration the depth where it is asked for, else a touch of 0.
  Nearest operator()(const Body& a, const coal::Transform3s& at_a, const Body& b, const coal::Transform3s& at_b,
                     double reach, bool depth, double depth_tolerance) {
    difference_.bodies[0] = &a.support;
    difference_.bodies[1] = &b.support;
    difference_.shapes[0] = a.support.shape;
    difference_.shapes[1] = b.support.shape;
    difference_.swept_sphere_radius << a.support.swept, b.support.swept;
    difference_.oR1.noalias() = at_a.getRotation().transpose() * at_b.getRotation();
    difference_.ot1.noalias() = at_a.getRotation().transpose() * (at_b.getTranslation() - at_a.getTranslation());
    gjk_.reset(kRounds, tolerance_);
    gjk_.setDistanceEarlyBreak(reach > 0.0 ? reach : 0.0);
    const Vector3 guess = polytope(a.support) && polytope(b.support) ? across(*a.geometry, *b.geometry) : Vector3::UnitX();
    Nearest found{0.0, Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
    switch (gjk_.evaluate(difference_, guess)) {
      case coal::details::GJK::NoCollisionEarlyStopped:
        found.distance = gjk_.distance;
        found.normal = at_a.getRotation() * -gjk_.ray.normalized();
        return found;
      case coal::details::GJK::Collision:
        if (!depth) {
          found.distance = gjk_.distance;
          return found;
        }
        epa_.reset(kDepthRounds, depth_tolerance);
        epa_.evaluate(gjk_, -guess);
        if (epa_.status == coal::details::EPA::FallBack) {
          found.distance = -std::numeric_limits<double>::max();
          return found;
        }
        found.distance = std::min(0.0, -epa_.depth);
        epa_.getWitnessPointsAndNormal(difference_, found.first, found.second, found.normal);
        break;
      default:
        found.distance = gjk_.distance;
        gjk_.getWitnessPointsAndNormal(difference_, found.first, found.second, found.normal);
    }
    // On curved shapes the two points are only nearly along the normal.
    const Vector3 middle = at_a.transform(0.5 * (found.first + found.second));
    found.normal = at_a.getRotation() * found.normal;
    found.first = middle - 0.5 * found.distance * found.normal;
    found.second = middle + 0.5 * found.distance * found.normal;
    return found;
  }

  // How far apart two bodies are along a direction from the first to the second: their distance is no less.
  double along(const Body& a, const Place& at_a, const Body& b, const Place& at_b, const Vector3& direction) {
    Vector3 first, second;
    const Vector3 local_a = at_a.rotation.transpose() * direction, local_b = at_b.rotation.transpose() * direction;
    a.support.farthest(a.support, local_a, first, difference_.data[0]);
    b.support.farthest(b.support, -local_b, second, difference_.data[1]);
    return direction.dot(at_b.centre - at_a.centre) + local_b.dot(second - b.middle) - local_a.dot(first - a.middle) -
           a.support.swept - b.support.swept;
  }

 private:
  // Coal's own defaults.
  static constexpr std::size_t kRounds = coal::GJK_DEFAULT_MAX_ITERATIONS, kDepthRounds = coal::EPA_DEFAULT_MAX_ITERATIONS;

  static bool polytope(const Support& support) {
    return support.type == coal::GEOM_BOX || support.type == coal::GEOM_CONVEX;
  }

  // The first body less the second, in the first one's frame.
  struct Difference : coal::details::MinkowskiDiff {
    Difference() { getSupportFunc = &farthest; }

    static void farthest(const coal::details::MinkowskiDiff& both, const Vector3& direction, Vector3& first, Vector3& second,
                         coal::support_func_guess_t&, coal::details::ShapeSupportData data[2]) {
      const auto& here = static_cast<const Difference&>(both);
      here.bodies[0]->farthest(*here.bodies[0], direction, first, data[0]);
      Vector3 local;
      here.bodies[1]->farthest(*here.bodies[1], -(here.oR1.transpose() * direction), local, data[1]);
      second.noalias() = here.oR1 * local;
      second += here.ot1;
    }

    const Support* bodies[2];
  };

  // From the second body to the first where their boxes come nearest, about: the first box's point nearest to the
  // second one's centre, and that one's nearest to it.
  Vector3 across(const coal::CollisionGeometry& a, const coal::CollisionGeometry& b) const {
    const auto& turn = difference_.oR1;
    const Vector3 centre = turn * b.aabb_local.center() + difference_.ot1;
    const Vector3 first = centre.cwiseMax(a.aabb_local.min_).cwiseMin(a.aabb_local.max_);
    const Vector3 local = turn.transpose() * (first - difference_.ot1);
    const Vector3 second = turn * local.cwiseMax(b.aabb_local.min_).cwiseMin(b.aabb_local.max_) + difference_.ot1;
    const Vector3 apart = first - second;
    return apart.squaredNorm() > tolerance_ * tolerance_ ? apart : a.aabb_local.center() - centre;
  }

  double tolerance_;
  Difference difference_;
  coal::details::GJK gjk_;
  coal::details::EPA epa_;
};

}  // namespace proximity
