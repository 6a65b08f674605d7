// The parts of the covers' core: hulls of all kinds of points, sides of a plane, distances, what is inside.
#include "check.hpp"
#include "covers/cover.hpp"
#include "covers/cut.hpp"

using namespace covers;

namespace {

Vec somewhere(std::mt19937& rng, double size) {
  return {check::uniform(rng, -size, size), check::uniform(rng, -size, size), check::uniform(rng, -size, size)};
}

Triangles faces_of(const Hull& hull) {
  Triangles triangles;
  for (size_t face = 0; face < hull.faces.size(); ++face) triangles.push_back(hull.corners(face));
  return triangles;
}

Triangles box(const Vec& low, const Vec& high) {
  Points corners;
  for (const double x : {low.x, high.x})
    for (const double y : {low.y, high.y})
      for (const double z : {low.z, high.z}) corners.push_back({x, y, z});
  return faces_of(hull_of(corners));
}

void add(Triangles& all, const Triangles& more) { all.insert(all.end(), more.begin(), more.end()); }

// Points of one kind: spread, on a lattice, on a drum's two rims, on a sphere, on a line's ends with rounding.
Vec point_of_kind(std::mt19937& rng, int kind, int number) {
  const double angle = 0.3 * (number % 21);
  switch (kind) {
    case 0: return somewhere(rng, 1.0);
    case 1: return {1.0 * check::whole(rng, -2, 2), 1.0 * check::whole(rng, -2, 2), 1.0 * check::whole(rng, -2, 2)};
    case 2: return {std::cos(angle), std::sin(angle), number % 2 ? 0.1 : -0.1};
    case 3: {
      const Vec point = somewhere(rng, 1.0);
      return 1.0 / norm(point) * point;
    }
    default: return {1.0 * check::whole(rng, 0, 1), check::uniform(rng, -1e-9, 1e-9), static_cast<float>(0.1 * number)};
  }
}

}  // namespace

TEST(hulls_hold_all_points_and_are_closed) {
  std::mt19937 rng(1);
  for (int run = 0; run < 200; ++run) {
    Points points;
    const int count = check::whole(rng, 1, 150);
    for (int number = 0; number < count; ++number) points.push_back(point_of_kind(rng, run % 5, number));
    for (const double accuracy : {0.0, 1e-4}) {
      const Hull hull = hull_of(points, accuracy);
      double highest = -1.0;
      for (const Vec& point : points) highest = std::max(highest, hull.height(point));
      CHECK(highest <= (accuracy > 0.0 ? 3e-3 : 1e-10));
      CHECK(hull.faces.size() == 2 * hull.vertices.size() - 4);  // Euler's formula.
      CHECK(hull.volume > 0.0);
      Vec middle;
      for (const Vec& vertex : hull.vertices) middle += 1.0 / static_cast<double>(hull.vertices.size()) * vertex;
      CHECK(hull.holds(middle));
      CHECK(!hull.holds(hull.vertices.front()));
    }
  }
}

TEST(both_sides_of_a_plane_make_up_the_triangles) {
  std::mt19937 rng(2);
  const auto area = [](const Triangles& triangles) {
    double sum = 0.0;
    for (const Triangle& t : triangles) sum += 0.5 * norm(cross(t[1] - t[0], t[2] - t[0]));
    return sum;
  };
  for (int run = 0; run < 200; ++run) {
    Triangles triangles;
    for (int count = 0; count < 20; ++count)
      triangles.push_back(
          run % 2 ? Triangle{somewhere(rng, 1.0), somewhere(rng, 1.0), somewhere(rng, 1.0)}
                  : Triangle{point_of_kind(rng, 1, 0), point_of_kind(rng, 1, 0), point_of_kind(rng, 1, 0)});
    const Plane plane = run % 2 ? Plane{{0.6, 0.0, 0.8}, 0.1} : Plane{{0.0, 0.0, 1.0}, 1.0};
    const auto sides = clipped(triangles, plane, 1e-9);
    CHECK_NEAR(area(sides[0]) + area(sides[1]), area(triangles), 1e-12 * area(triangles));
    for (const Triangle& t : sides[0])
      for (const Vec& corner : t) CHECK(plane.height(corner) <= 1e-9);
    for (const Triangle& t : sides[1])
      for (const Vec& corner : t) CHECK(plane.height(corner) >= -1e-9);
    const auto corners = clipped_corners(indexed(triangles), plane, 1e-9);
    for (int side = 0; side < 2; ++side) {
      CHECK(corners[side].corners.empty() == sides[side].empty());
      CHECK_NEAR(0.5 * corners[side].area, area(sides[side]), 1e-12 * area(triangles));
      if (sides[side].empty()) continue;
      const Hull hull = hull_of(corners[side].corners);
      for (const Triangle& t : sides[side])
        for (const Vec& corner : t) CHECK(hull.height(corner) <= 1e-9);
    }
  }
}

TEST(triangles_in_the_plane_part_from_those_beside_it) {
  const Triangles cube = box({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0});
  const auto counts = [](const Triangles& triangles, double offset) {
    const auto sides = clipped(triangles, {{0.0, 0.0, 1.0}, offset}, 1e-9);
    return std::array<size_t, 2>{sides[0].size(), sides[1].size()};
  };
  CHECK((counts(cube, 0.0) == std::array<size_t, 2>{2, 10}));
  CHECK((counts(cube, 1.0) == std::array<size_t, 2>{10, 2}));
  CHECK((counts(cube, -1.0) == std::array<size_t, 2>{0, 12}));
  CHECK((counts(cube, 0.5) == std::array<size_t, 2>{14, 14}));
  Triangles step = box({0.0, 0.0, 0.0}, {2.0, 1.0, 1.0});
  add(step, box({0.0, 0.0, 1.0}, {1.0, 1.0, 2.0}));
  CHECK((counts(step, 1.0) == std::array<size_t, 2>{12, 12}));  // Each with the solid that it bounds.
}

TEST(distances_to_a_surface_are_the_least_to_its_triangles) {
  std::mt19937 rng(3);
  Triangles triangles;
  for (int count = 0; count < 300; ++count) {
    const Vec at = somewhere(rng, 1.0);
    triangles.push_back({at, at + somewhere(rng, 0.2), at + somewhere(rng, 0.2)});
  }
  const Surface surface(triangles, std::vector<int>(triangles.size(), -1));
  for (int run = 0; run < 200; ++run) {
    const Vec point = somewhere(rng, 1.5);
    double least = HUGE_VAL;
    for (int triangle = 0; triangle < 300; ++triangle) least = std::min(least, surface.distance(point, triangle));
    CHECK(surface.nearest(point).distance == least);
    CHECK(surface.nearest(point, run).distance == least);
  }
}

TEST(what_closed_parts_hold_is_inside) {
  Triangles triangles = box({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0});
  std::vector<int> parts(triangles.size(), 0);
  add(triangles, box({0.5, 0.0, 0.0}, {2.0, 1.0, 1.0}));  // Overlaps the first.
  parts.resize(triangles.size(), 1);
  add(triangles, box({0.0, 2.0, 0.0}, {1.0, 3.0, 1.0}));  // Bounds no solid.
  parts.resize(triangles.size(), -1);
  std::mt19937 rng(4);
  Points points;
  for (int count = 0; count < 500; ++count) points.push_back(Vec{1.0, 1.5, 0.5} + somewhere(rng, 2.0));
  const std::vector<std::uint8_t> inside = Surface(triangles, parts).contains(points);
  for (size_t index = 0; index < points.size(); ++index) {
    const Vec& p = points[index];
    const bool expected = p.x > 0.0 && p.x < 2.0 && p.y > 0.0 && p.y < 1.0 && p.z > 0.0 && p.z < 1.0;
    CHECK(static_cast<bool>(inside[index]) == expected);
  }
}

TEST(a_hull_stands_out_as_far_as_its_farthest_face) {
  Triangles triangles = box({0.0, 0.0, 0.0}, {1.0, 0.1, 0.1});
  add(triangles, box({0.0, 0.0, 0.0}, {0.1, 1.0, 0.1}));
  const Hull hull = hull_of(indexed(triangles).corners);
  const Surface surface(triangles, std::vector<int>(triangles.size(), 0));
  const StandOut measured = stand_out(hull, surface, nullptr, {0.0, HUGE_VAL, 1, 1e-3, 100000});
  // On the slope from (1, 0.1) to (0.1, 1) its middle is farthest, as far from both bars.
  CHECK_NEAR(measured.bound, 0.45, 2e-3);
  CHECK(measured.found <= measured.bound && measured.bound <= measured.found + 1e-3);
}

TEST(pieces_cover_and_stay_near) {
  Triangles triangles = box({0.0, 0.0, 0.0}, {0.4, 0.05, 0.05});
  std::vector<int> parts(triangles.size(), 0);
  add(triangles, box({0.0, 0.0, 0.0}, {0.05, 0.4, 0.05}));
  parts.resize(triangles.size(), 1);
  const Options options{0.05, 0.01, 64, 5000, 1e8};
  const Cover made = cover(indexed(triangles), parts, options);
  CHECK(made.cut && made.pieces.size() == 2);
  CHECK(made.reach <= kFarthest * options.tolerance);
  std::vector<Hull> hulls;
  for (const Points& piece : made.pieces) hulls.push_back(hull_of(piece));
  for (const Triangle& t : triangles)
    for (const Vec& corner : t) {
      double least = HUGE_VAL;
      for (const Hull& hull : hulls) least = std::min(least, hull.height(corner));
      CHECK(least <= 1e-10);
    }
  const Cover again = cover(indexed(triangles), parts, options);
  CHECK(again.pieces == made.pieces && again.reach == made.reach);
  const Cover whole = cover(indexed(triangles), parts, {0.05, 0.01, 1, 5000, 1e8});
  CHECK(whole.pieces.size() == 1 && whole.reach > 0.1);
}
