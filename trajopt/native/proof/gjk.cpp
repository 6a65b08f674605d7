#include "gjk.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cloud_points.hpp"
#include "surface_tree.hpp"

namespace proof {

namespace {

constexpr int most_steps = 96;
constexpr double tightness = 1e-9;   // Gap and distance this near are taken for one [m].
constexpr double touching = 1e-10;   // Nearer than this no direction can be trusted [m].
constexpr double good_share = 0.9;   // A sufficient gap is sharpened to this share of the possible one.

// Up to four points, reduced to those that carry the point nearest to the origin.
struct Simplex {
  std::array<Vec, 4> points;
  int count = 0;

  Vec segment(int i, int j, std::array<int, 3>& kept, int& n) const {
    const Vec &a = points[i], ab = points[j] - a;
    const double length = ab.squaredNorm();
    const double t = length > 0.0 ? -a.dot(ab) / length : 0.0;
    if (t <= 0.0) return kept = {i}, n = 1, a;
    if (t >= 1.0) return kept = {j}, n = 1, points[j];
    return kept = {i, j}, n = 2, Vec(a + t * ab);
  }

  // Source: Ericson, Real-Time Collision Detection, section 5.1.5.
  Vec triangle(int i, int j, int k, std::array<int, 3>& kept, int& n) const {
    const Vec &a = points[i], &b = points[j], &c = points[k];
    const Vec ab = b - a, ac = c - a;
    const double d1 = -ab.dot(a), d2 = -ac.dot(a);
    if (d1 <= 0.0 && d2 <= 0.0) return kept = {i}, n = 1, a;
    const double d3 = -ab.dot(b), d4 = -ac.dot(b);
    if (d3 >= 0.0 && d4 <= d3) return kept = {j}, n = 1, b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return segment(i, j, kept, n);
    const double d5 = -ab.dot(c), d6 = -ac.dot(c);
    if (d6 >= 0.0 && d5 <= d6) return kept = {k}, n = 1, c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return segment(i, k, kept, n);
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return segment(j, k, kept, n);
    const double sum = va + vb + vc;
    kept = {i, j, k}, n = 3;
    return a + ab * (vb / sum) + ac * (vc / sum);
  }

  // Point nearest to the origin; reduces the simplex. Four points kept say that the origin is inside.
  Vec reduce() {
    std::array<int, 3> kept{0};
    int n = 1;
    Vec nearest = points[0];
    if (count == 2) {
      nearest = segment(0, 1, kept, n);
    } else if (count == 3) {
      nearest = triangle(0, 1, 2, kept, n);
    } else if (count == 4) {
      static constexpr int face[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
      double least = std::numeric_limits<double>::infinity();
      for (const auto& f : face) {
        const Vec& a = points[f[0]];
        const Vec normal = (points[f[1]] - a).cross(points[f[2]] - a);
        // Outside of the face if the origin is not strictly on the side of the fourth point.
        if (-normal.dot(a) * normal.dot(points[f[3]] - a) > 0.0) continue;
        std::array<int, 3> some{0};
        int m = 1;
        const Vec found = triangle(f[0], f[1], f[2], some, m);
        if (found.squaredNorm() < least) least = found.squaredNorm(), nearest = found, kept = some, n = m;
      }
      if (std::isinf(least)) return Vec::Zero();
    }
    std::array<Vec, 3> rest{Vec::Zero(), Vec::Zero(), Vec::Zero()};
    for (int i = 0; i < n; ++i) rest[i] = points[kept[i]];
    std::copy(rest.begin(), rest.end(), points.begin());
    count = n;
    return nearest;
  }
};

}  // namespace

Vec Part::support(const Vec& direction) const {
  if (node < 0) return form->core_support(direction);
  if (form->points == nullptr) return form->tree->support(node, direction);
  const Vec& half = form->half;
  return form->points->corner(node, direction) + Vec(std::copysign(half.x(), direction.x()),
                                                     std::copysign(half.y(), direction.y()),
                                                     std::copysign(half.z(), direction.z()));
}

Vec Sweep::lowest(const Vec& d) const {
  auto farthest = [](const Part& part, const Pose& at, const Vec& along) -> Vec {
    return at * part.support(at.R.transpose() * along);
  };
  const Vec a = farthest(first, *first_at[0], d), b = farthest(second, *second_at[0], -d);
  const bool a_rests = first_at[0] == first_at[1], b_rests = second_at[0] == second_at[1];
  if (a_rests && b_rests) return b - a;
  const Vec later_a = a_rests ? a : farthest(first, *first_at[1], d);
  const Vec later_b = b_rests ? b : farthest(second, *second_at[1], -d);
  const Vec early = b - a, late = later_b - later_a;
  return d.dot(early) <= d.dot(late) ? early : late;
}

Separation separate(const Sweep& sweep, const Vec& guess, double enough, Aim aim) {
  const double rounding = sweep.first.rounding() + sweep.second.rounding();
  const double infinite = std::numeric_limits<double>::infinity();
  Separation result{-infinite, infinite, Vec::UnitX(), false};
  Simplex simplex;
  const double length = guess.norm();
  Vec direction = length > touching ? Vec(guess / length) : Vec::UnitX();
  double nearest = infinite;
  for (int iteration = 0; iteration < most_steps; ++iteration) {
    const Vec point = sweep.lowest(direction);
    const double gap = direction.dot(point) - rounding;
    if (gap > result.gap) result.gap = gap, result.direction = direction;
    simplex.points[simplex.count++] = point;
    const Vec v = simplex.reduce();
    const double distance = v.norm();
    if (simplex.count == 4 || distance < touching) {
      result.overlap = true;
      result.upper = -rounding;
      return result;
    }
    const bool stalled = distance >= nearest;
    nearest = std::min(nearest, distance);
    result.upper = nearest - rounding;
    if (result.gap >= enough && (aim == Aim::Measure || result.gap >= good_share * result.upper)) return result;
    if (aim == Aim::Prove && result.upper < enough) return result;
    if (result.upper - result.gap <= tightness || stalled) return result;
    direction = v / distance;
  }
  return result;
}

}  // namespace proof
