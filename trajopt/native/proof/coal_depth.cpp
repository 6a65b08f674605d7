#include "coal_depth.hpp"

#include <coal/distance.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "upper_model.hpp"

namespace proof {

namespace {

constexpr double gjk_tolerance = 1e-9;   // Smaller than Coal's default, for better directions.
constexpr double epa_tolerance = 1e-7;   // With a smaller one round shapes get wrong depths.
constexpr int most_iterations = 512;
constexpr int even_directions = 2000, rounds = 48, most_attempts = 100;
constexpr int starts = 12;            // Between even directions a lower one may lead to a larger gap.
constexpr size_t most_cuts = 24;      // Of a model of the gap: its peaks grow with the square of them.
constexpr double negligible = 1e-10;  // Gaps that no model allows to be larger by more are the largest [m].
const double widest = 2.0 * std::sqrt(4.0 * pi / even_directions);  // The next even directions are within it [rad].

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

// The direction of the largest gap of two cores so far.
struct Summit {
  const Form& first;
  const Pose& first_at;
  const Form& second;
  const Pose& second_at;
  Vec best = Vec::UnitX();
  double largest = -std::numeric_limits<double>::infinity();

  // Point of the second core less the point of the first, both in the common frame, that decide the gap along n.
  Vec measure(const Vec& n) {
    const Vec difference = second_at * second.core_support(-(second_at.R.transpose() * n)) -
                           first_at * first.core_support(first_at.R.transpose() * n);
    if (n.dot(difference) > largest) largest = n.dot(difference), best = n;
    return difference;
  }

  // Search around a direction until no gap there is larger, or the model has too many cuts.
  UpperModel climb(Vec n, double spread) {
    UpperModel model(n, spread);
    for (int i = 0; i < most_attempts; ++i) {
      const Vec difference = measure(n);
      model.cut(difference, largest + negligible);
      if (model.exhausted() || model.size() >= most_cuts) break;
      n = model.highest();
    }
    return model;
  }
};

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
  Summit summit{first, first_at, second, second_at};
  std::vector<double> gaps;
  for (const Vec& n : even) gaps.push_back(n.dot(summit.measure(n)));
  for (int start = 0; start < starts; ++start) {
    const Vec middle = even[std::max_element(gaps.begin(), gaps.end()) - gaps.begin()];
    summit.climb(middle, widest);
    for (size_t i = 0; i < even.size(); ++i) {
      if (even[i].dot(middle) > std::cos(widest)) gaps[i] = -std::numeric_limits<double>::infinity();
    }
  }
  double spread = widest;
  for (int round = 0; round < rounds; ++round) {
    const UpperModel model = summit.climb(summit.best, spread);
    if (!model.exhausted()) {
      spread /= 4.0;  // Too round for so few cuts, but less so nearby.
    } else if (model.at_border(summit.best)) {
      spread = std::min(2.0 * spread, widest);
    } else {
      break;
    }
  }
  return summit.largest - first.rounding - second.rounding;
}

}  // namespace proof
