// The judge's kernel: support functions, certified gaps, trees of triangles, polynomials and depths.
#include "check.hpp"
#include "proof/coal_depth.hpp"
#include "proof/curve.hpp"
#include "proof/gjk.hpp"
#include "proof/surface_tree.hpp"

using namespace proof;
using check::uniform, check::whole;

namespace {

Vec direction(std::mt19937& rng) {
  Vec n;
  do {
    n = Vec(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
  } while (n.norm() < 0.1);
  return n.normalized();
}

Pose random_pose(std::mt19937& rng, double size) {
  const Mat turn = Eigen::AngleAxisd(uniform(rng, -3, 3), direction(rng)).toRotationMatrix();
  return {turn, size * Vec(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1))};
}

// Corner numbers of the twelve triangles of a box; corner i is (i & 1, i & 2, i & 4), outward.
const int64_t kFaces[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                            2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};

std::vector<double> box_corners(const Vec& half) {
  std::vector<double> corners;
  for (int i = 0; i < 8; ++i) {
    corners.insert(corners.end(), {(i & 1 ? 1 : -1) * half.x(), (i & 2 ? 1 : -1) * half.y(),
                                   (i & 4 ? 1 : -1) * half.z()});
  }
  return corners;
}

SurfaceTree::Triangles box_triangles(const Vec& half) {
  const auto corners = box_corners(half);
  SurfaceTree::Triangles triangles;
  for (int face = 0; face < 12; ++face) {
    std::array<Vec, 3> triangle;
    for (int i = 0; i < 3; ++i) triangle[i] = Eigen::Map<const Vec>(corners.data() + 3 * kFaces[3 * face + i]);
    triangles.push_back(triangle);
  }
  return triangles;
}

Separation measure(const Form& first, const Pose& at, const Form& second, const Pose& other) {
  return separate({{&first}, {&second}, {&at, &at}, {&other, &other}}, other.p - at.p, INFINITY, Aim::Measure);
}

}  // namespace

TEST(solids_reach_as_far_as_their_farthest_point) {
  std::mt19937 rng(6);
  const auto box = make_solid(Kind::Box, {0.1, 0.2, 0.3}), sphere = make_solid(Kind::Sphere, {0.2, 0.2, 0.0});
  const auto cylinder = make_solid(Kind::Cylinder, {0.1, 0.1, 0.3}), capsule = make_solid(Kind::Capsule, {0.1, 0.1, 0.3});
  const auto cone = make_solid(Kind::Cone, {0.1, 0.1, 0.3});
  for (int trial = 0; trial < 200; ++trial) {
    const Vec n = direction(rng);
    const double across = std::hypot(n.x(), n.y()), along = std::abs(n.z());
    CHECK_NEAR(box->reach(n), n.cwiseAbs().dot(Vec(0.1, 0.2, 0.3)), 1e-14);
    CHECK_NEAR(sphere->reach(n), 0.2, 1e-14);
    CHECK_NEAR(cylinder->reach(n), 0.1 * across + 0.3 * along, 1e-14);
    CHECK_NEAR(capsule->reach(n), 0.1 + 0.3 * along, 1e-14);
    CHECK_NEAR(cone->reach(n), std::max(0.3 * n.z(), 0.1 * across - 0.3 * n.z()), 1e-14);
    for (const auto& form : {box, sphere, cylinder, capsule, cone}) CHECK(form->reach(n) <= form->radius + 1e-14);
  }
}

TEST(a_hull_reaches_as_far_as_its_farthest_vertex) {
  std::mt19937 rng(7);
  const auto corners = box_corners({0.1, 0.2, 0.3});
  const auto hull = make_hull(corners.data(), 8, kFaces, 12, true);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec n = direction(rng);
    CHECK_NEAR(hull->reach(n), n.cwiseAbs().dot(Vec(0.1, 0.2, 0.3)), 1e-14);
  }
}

TEST(a_large_hull_is_climbed_to_its_farthest_vertex) {
  std::mt19937 rng(8);
  const int rings = 24, sides = 24;  // a ball of latitudes and longitudes, convex and closed
  std::vector<double> vertices{0.0, 0.0, -1.0};
  for (int ring = 1; ring < rings; ++ring) {
    for (int side = 0; side < sides; ++side) {
      const double up = M_PI * (double(ring) / rings - 0.5), around = 2.0 * M_PI * side / sides;
      vertices.insert(vertices.end(), {std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up)});
    }
  }
  vertices.insert(vertices.end(), {0.0, 0.0, 1.0});
  std::vector<int64_t> faces;
  const auto at = [&](int ring, int side) { return int64_t(1 + (ring - 1) * sides + side % sides); };
  const int64_t top = int64_t(vertices.size() / 3) - 1;
  for (int side = 0; side < sides; ++side) {
    faces.insert(faces.end(), {0, at(1, side + 1), at(1, side), top, at(rings - 1, side), at(rings - 1, side + 1)});
    for (int ring = 1; ring + 1 < rings; ++ring) {
      faces.insert(faces.end(), {at(ring, side), at(ring, side + 1), at(ring + 1, side)});
      faces.insert(faces.end(), {at(ring + 1, side), at(ring, side + 1), at(ring + 1, side + 1)});
    }
  }
  const auto hull = make_hull(vertices.data(), vertices.size() / 3, faces.data(), faces.size() / 3, true);
  CHECK(!hull->neighbours.empty());
  for (int trial = 0; trial < 500; ++trial) {
    const Vec n = direction(rng);
    double farthest = -INFINITY;
    for (size_t i = 0; i < vertices.size(); i += 3) {
      farthest = std::max(farthest, n.dot(Eigen::Map<const Vec>(vertices.data() + i)));
    }
    CHECK_NEAR(hull->reach(n), farthest, 1e-12);
  }
}

TEST(gaps_of_spheres_are_exact_and_gaps_of_boxes_are_proven) {
  std::mt19937 rng(9);
  const auto one = make_solid(Kind::Sphere, {0.1, 0.1, 0.0}), other = make_solid(Kind::Sphere, {0.2, 0.2, 0.0});
  const auto box = make_solid(Kind::Box, {0.1, 0.2, 0.3}), tube = make_solid(Kind::Cylinder, {0.1, 0.1, 0.3});
  for (int trial = 0; trial < 300; ++trial) {
    const Pose a = random_pose(rng, 1.0), b = random_pose(rng, 1.0);
    const double apart = (b.p - a.p).norm() - 0.3;
    if (apart > 1e-3) CHECK_NEAR(measure(*one, a, *other, b).gap, apart, 1e-9);
    const Separation found = measure(*box, a, *tube, b);
    if (found.overlap || !(found.gap > 0.0)) continue;
    CHECK_NEAR(found.direction.norm(), 1.0, 1e-9);
    CHECK_NEAR(found.gap, gap_along(*box, a, *tube, b, found.direction), 1e-12);
    CHECK(found.gap <= found.upper + 1e-12 && found.upper - found.gap < 1e-4);
    for (int probe = 0; probe < 50; ++probe) CHECK(gap_along(*box, a, *tube, b, direction(rng)) <= found.upper + 1e-9);
  }
}

TEST(a_gap_over_an_interval_holds_at_both_ends) {
  std::mt19937 rng(10);
  const auto box = make_solid(Kind::Box, {0.1, 0.2, 0.3}), ball = make_solid(Kind::Sphere, {0.2, 0.2, 0.0});
  int proven = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Pose rest, begin = random_pose(rng, 1.0);
    Pose end = begin;
    end.p += 0.1 * direction(rng);
    const Separation found =
        separate({{box.get()}, {ball.get()}, {&rest, &rest}, {&begin, &end}}, begin.p, 1e-3, Aim::Prove);
    if (!(found.gap >= 1e-3)) continue;
    ++proven;
    for (const Pose& at : {begin, end}) CHECK(gap_along(*box, rest, *ball, at, found.direction) >= found.gap - 1e-12);
  }
  CHECK(proven > 50);
}

TEST(depths_of_boxes_and_spheres_are_lower_bounds_near_the_truth) {
  const auto box = make_solid(Kind::Box, {0.2, 0.2, 0.2}), ball = make_solid(Kind::Sphere, {0.1, 0.1, 0.0});
  for (const double x : {0.05, 0.15, 0.25, 0.29, 0.35, 0.6}) {
    const Pose at{Mat::Identity(), Vec(x, 0.0, 0.0)};
    const double expected = x - 0.3;
    for (const double found : {signed_distance(*box, Pose{}, *ball, at), largest_gap(*box, Pose{}, *ball, at)}) {
      CHECK(found <= expected + 1e-9);
      CHECK_NEAR(found, expected, 1e-5);
    }
  }
}

TEST(a_tree_of_triangles_knows_its_inside_and_how_far_it_reaches) {
  std::mt19937 rng(11);
  const Vec half(0.1, 0.2, 0.3);
  const SurfaceTree tree(box_triangles(half));
  for (int trial = 0; trial < 300; ++trial) {
    const Vec point = 0.5 * Vec(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
    CHECK(tree.encloses(point) == ((point.cwiseAbs() - half).maxCoeff() < 0.0));
    const Vec n = direction(rng);
    CHECK(n.dot(tree.support(0, n)) >= n.cwiseAbs().dot(half) - 1e-12);
    for (size_t node = 0; node < tree.nodes.size(); ++node) {
      if (!tree.nodes[node].leaf()) continue;
      double farthest = -INFINITY;
      for (const Vec& corner : tree.nodes[node].corners) farthest = std::max(farthest, n.dot(corner));
      CHECK_NEAR(n.dot(tree.support(int(node), n)), farthest, 1e-12);
    }
  }
}

TEST(polynomials_stay_within_their_bounds_and_reach_their_extremes) {
  std::mt19937 rng(12);
  for (int trial = 0; trial < 100; ++trial) {
    Curve curve;
    curve.degree = whole(rng, 0, Curve::highest_degree), curve.functions = whole(rng, 1, 3);
    curve.times = {0.0};
    for (int piece = whole(rng, 1, 4); piece > 0; --piece) curve.times.push_back(curve.times.back() + uniform(rng, 0.01, 1.0));
    curve.coefficients.resize(size_t(curve.degree + 1) * curve.pieces() * curve.functions);
    for (double& each : curve.coefficients) each = uniform(rng, -1.0, 1.0);
    const double last = curve.times.back(), begin = uniform(rng, 0.0, 0.9 * last), end = uniform(rng, begin + 1e-6, last);
    std::vector<double> low(curve.functions), high(low), values(low), most(curve.functions, -INFINITY);
    curve.range(begin, end, low.data(), high.data());
    for (int i = 0; i < 1000; ++i) {  // a sample at a breakpoint belongs to the next piece, which may jump
      curve.evaluate(begin + (end - begin) * i / 1000, values.data());
      for (int f = 0; f < curve.functions; ++f) CHECK(low[f] - 1e-9 <= values[f] && values[f] <= high[f] + 1e-9);
      curve.evaluate(last * i / 1000, values.data());
      for (int f = 0; f < curve.functions; ++f) most[f] = std::max(most[f], values[f]);
    }
    for (int f = 0; f < curve.functions; ++f) {
      double value = 0.0, time = 0.0;
      curve.largest(f, 1.0, 1e-9, value, time);
      CHECK(value >= most[f] - 1e-8 && 0.0 <= time && time <= last);
    }
    const Curve slope = curve.derivative();
    const double at = curve.times[0] + 0.5 * (curve.times[1] - curve.times[0]), step = 1e-6;
    std::vector<double> before(low), after(low), rate(low);
    curve.evaluate(at - step, before.data()), curve.evaluate(at + step, after.data()), slope.evaluate(at, rate.data());
    for (int f = 0; f < curve.functions; ++f) CHECK_NEAR(rate[f], (after[f] - before[f]) / (2.0 * step), 1e-5);
  }
}
