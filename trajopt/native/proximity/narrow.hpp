// Coal's signed distance of one pair, given up early beyond a reach.
#pragma once

#include <coal/collision.h>
#include <coal/distance.h>
#include <coal/distance_func_matrix.h>

#include <cmath>
#include <limits>

#include "cell.hpp"
#include "convex_pair.hpp"

namespace proximity {

class NarrowPhase {
 public:
  explicit NarrowPhase(const Accuracy& accuracy) : accuracy_(accuracy), convex_(accuracy.gjk) {
    request_.enable_signed_distance = true;
    request_.gjk_tolerance = accuracy.gjk;
    contacts_.num_max_contacts = 64;
    contacts_.enable_contact = true;
  }

  Nearest operator()(const Body& a, const coal::Transform3s& at_a, const Body& b, const coal::Transform3s& at_b,
                     double reach) {
    const bool mesh = a.is_mesh() || b.is_mesh();
    Nearest found = measure(a, at_a, b, at_b, reach, accuracy_.epa, mesh);
    if (!(std::abs(found.distance) < kImpossible)) {
      found = measure(a, at_a, b, at_b, reach, accuracy_.epa_again, mesh);
    }
    if (mesh && found.distance <= 0.0) return deepest(a, at_a, b, at_b);
    if (mesh && (within(a, at_a, b, at_b) || within(b, at_b, a, at_a))) {
      // The way to the surface, which is no longer than the way out.
      found = measure(a, at_a, b, at_b, std::numeric_limits<double>::infinity(), accuracy_.epa, mesh);
      return {-found.distance, -found.normal, found.first, found.second};
    }
    return found;
  }

  // How far apart two bodies are along a direction, where that can be asked: their distance is no less.
  double along(const Body& a, const Place& at_a, const Body& b, const Place& at_b, const Vector3& direction) {
    return convex_.along(a, at_a, b, at_b, direction);
  }

  // Whether a direction was found along which two bodies are as far apart, and can be asked again.
  static bool has_direction(const Body& a, const Body& b, const Nearest& found) {
    return a.support.farthest != nullptr && b.support.farthest != nullptr && found.normal.squaredNorm() > 0.5;
  }

  // Whether two bodies keep at least a distance, by how far they are apart: below it that says no more than this.
  Nearest keeping(const Body& a, const coal::Transform3s& at_a, const Body& b, const coal::Transform3s& at_b, double reach) {
    // How deep they touch is asked only where touching is not too near already.
    if (!(reach > 0.0) || a.is_mesh() || b.is_mesh()) return (*this)(a, at_a, b, at_b, reach);
    request_.enable_signed_distance = false;
    const Nearest found = measure(a, at_a, b, at_b, reach, accuracy_.epa, false);
    request_.enable_signed_distance = true;
    return found;
  }

 private:
  static constexpr double kMeshBeyond = 0.05;
  // Coal's expanding polytope reports the largest float as depth where it fails.
  static constexpr double kImpossible = 1e3;

  Nearest measure(const Body& a, const coal::Transform3s& at_a, const Body& b, const coal::Transform3s& at_b,
                  double reach, double epa_tolerance, bool mesh) {
    if (ConvexPair::measures(a, b)) {
      return convex_(a, at_a, b, at_b, reach, request_.enable_signed_distance, epa_tolerance);
    }
    request_.epa_tolerance = epa_tolerance;
    result_.clear();
    double distance = 0.0;
    if (mesh) {
      // A tree of triangles is cut where it cannot come nearer than what was found already. Somewhat beyond the
      // reach, so that the answer bounds the distance for more than this once.
      result_.min_distance = reach + kMeshBeyond;
      distance = coal::distance(a.geometry.get(), at_a, b.geometry.get(), at_b, request_, result_);
    } else {
      solver_.set(request_);
      solver_.distance_upper_bound = reach > 0.0 ? reach : 0.0;
      const auto measure = table_.distance_matrix[a.geometry->getNodeType()][b.geometry->getNodeType()];
      distance = measure(a.geometry.get(), at_a, b.geometry.get(), at_b, &solver_, request_, result_);
    }
    const Vector3 &first = result_.nearest_points[0], &second = result_.nearest_points[1];
    // Between two meshes Coal leaves the normal out.
    if (a.is_mesh() && b.is_mesh()) return {distance, (second - first) / distance, first, second};
    return {distance, result_.normal, first, second};
  }

  static bool within(const Body& body, const coal::Transform3s& at, const Body& shell, const coal::Transform3s& around) {
    const coal::Transform3s seen = around.inverseTimes(at);
    return shell.solid->encloses(*body.solid, seen.getRotation(), seen.getTranslation());
  }

  // A penetrating mesh: Coal's distance says only that it touches.
  Nearest deepest(const Body& a, const coal::Transform3s& at_a, const Body& b, const coal::Transform3s& at_b) {
    coal::CollisionResult result;
    coal::collide(a.geometry.get(), at_a, b.geometry.get(), at_b, contacts_, result);
    Nearest found{std::nan(""), Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
    for (size_t i = 0; i < result.numContacts(); ++i) {
      const coal::Contact& contact = result.getContact(i);
      if (!(contact.penetration_depth >= found.distance)) {
        found = {contact.penetration_depth, contact.normal, contact.nearest_points[0], contact.nearest_points[1]};
      }
    }
    return found;
  }

  Accuracy accuracy_;
  ConvexPair convex_;
  coal::DistanceFunctionMatrix table_;
  coal::GJKSolver solver_;
  coal::DistanceRequest request_;
  coal::DistanceResult result_;
  coal::CollisionRequest contacts_;
};

}  // namespace proximity
