#include "coal_depth.hpp"

#include <coal/distance.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

#include <cmath>
#include <limits>

namespace proof {

namespace {

constexpr double doubtful = 1e-5;        // Where Coal and the gap along its normal differ by more [m].
constexpr double gjk_tolerance = 1e-9;   // Smaller than Coal's default, for better directions.
constexpr double epa_tolerance = 1e-7;   // With a smaller one round shapes get wrong depths.
constexpr int most_iterations = 512;
constexpr int even_directions = 2000, steps = 300, rounds = 48;
constexpr double pi = 3.14159265358979323846;

std::shared_ptr<const coal::CollisionGeometry> make(const Form& form) {
  const Vec& h = form.half;
  switch (form.kind) {
    case Kind::Box:
      return std::make_shared<coal::Box>(2.0 * h.x(), 2.0 * h.y(), 2.0 * h.z());
    case Kind::Sphere:
      return std::make_shared<coal::Sphere>(h.x());
    case Kind::Cylinder:
      return std::make_shared<coal::Cylinder>(h.x(), 2.0 * h.z());
    case Kind::Capsule:
      return std::make_shared<coal::Capsule>(h.x(), 2.0 * h.z());
    case Kind::Cone:
      return std::make_shared<coal::Cone>(h.x(), 2.0 * h.z());
    default:
      break;
  }
  auto points = std::make_shared<std::vector<coal::Vec3s>>();
  auto triangles = std::make_shared<std::vector<coal::Triangle>>();
  for (size_t i = 0; i < form.x.size(); ++i) points->emplace_back(form.x[i], form.y[i], form.z[i]);
  for (const auto& face : form.faces) triangles->emplace_back(face[0], face[1], face[2]);
  return std::make_shared<coal::Convex<coal::Triangle>>(points, unsigned(points->size()), triangles,
                                                        unsigned(triangles->size()));
}

// Coal's twin of a form; null where Coal has none: it refuses hulls of which a vertex has 256 neighbours.
const coal::CollisionGeometry* twin(const Form& form) {
  std::call_once(form.coal_once, [&form] {
    try {
      form.coal = make(form);
    } catch (const std::exception&) {
      form.coal = nullptr;
    }
  });
  return form.coal.get();
}

// Unit vectors spread evenly over the sphere along a spiral.
std::vector<Vec> spread_evenly(int count) {
  std::vector<Vec> found;
  for (int i = 0; i < count; ++i) {
    const double height = 1.0 - (2.0 * i + 1.0) / count, angle = pi * (1.0 + std::sqrt(5.0)) * i;
    const double radius = std::sqrt(1.0 - height * height);
    found.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
  }
  return found;
}

}  // namespace

double gap_along(const Form& first, const Pose& first_at, const Form& second, const Pose& second_at, const Vec& n) {
  return n.dot(second_at.p - first_at.p) - first.reach(first_at.R.transpose() * n) -
         second.reach(-(second_at.R.transpose() * n));
}

double signed_distance(const Form& first, const Pose& first_at, const Form& second, const Pose& second_at) {
  const coal::CollisionGeometry *one = twin(first), *other = twin(second);
  if (one == nullptr || other == nullptr) return largest_gap(first, first_at, second, second_at);
  coal::DistanceRequest request;
  request.enable_signed_distance = true;
  request.gjk_tolerance = gjk_tolerance;
  request.epa_tolerance = epa_tolerance;
  request.gjk_max_iterations = request.epa_max_iterations = most_iterations;
  coal::DistanceResult result;
  const double proposed = coal::distance(one, coal::Transform3s(first_at.R, first_at.p), other,
                                         coal::Transform3s(second_at.R, second_at.p), request, result);
  const double length = result.normal.norm();
  double found = -std::numeric_limits<double>::infinity();
  if (length > 0.5 && std::isfinite(length)) {
    found = gap_along(first, first_at, second, second_at, result.normal / length);
  }
  if (!(std::abs(found - proposed) <= doubtful)) {
    found = std::max(found, largest_gap(first, first_at, second, second_at));
  }
  return found;
}

double largest_gap(const Form& first, const Pose& first_at, const Form& second, const Pose& second_at) {
  static const std::vector<Vec> even = spread_evenly(even_directions);
  static const std::vector<Vec> near = spread_evenly(steps);
  Vec best = Vec::UnitX();
  double largest = -std::numeric_limits<double>::infinity();
  auto attempt = [&](const Vec& n) {
    const double gap = gap_along(first, first_at, second, second_at, n);
    if (gap > largest) largest = gap, best = n;
  };
  for (const Vec& n : even) attempt(n);
  double spread = 2.0 * std::sqrt(4.0 * pi / even_directions);
  for (int round = 0; round < rounds; ++round) {
    const Vec middle = best;
    const double before = largest;
    for (int i = 0; i < steps; ++i) {
      // Steps in all directions, of all lengths up to one, in no order.
      const double length = std::sqrt(std::fmod(i * 0.618034, 1.0));
      attempt((middle + spread * length * near[i]).normalized());
    }
    if (largest == before) spread /= 2.0;
  }
  return largest;
}

}  // namespace proof
