// The query's bounds, farthest points, obstacles and enclosure, as far as they need no robot.
#include <coal/shape/convex.h>

#include "check.hpp"
#include "proximity/convex_pair.hpp"
#include "proximity/generator.hpp"
#include "proximity/obstacles.hpp"

using namespace proximity;
using check::uniform;

namespace {

Vector3 random_vector(std::mt19937& rng, double size) {
  return size * Vector3(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
}

Matrix3 random_rotation(std::mt19937& rng) {
  return Eigen::AngleAxisd(uniform(rng, -3, 3), random_vector(rng, 1.0).normalized()).toRotationMatrix();
}

Body random_box(std::mt19937& rng, double size) {
  const Vector3 half = (random_vector(rng, 0.1).cwiseAbs() + Vector3::Constant(0.02)), at = random_vector(rng, size);
  return {0, random_rotation(rng), at, at, half, half.norm(), std::make_shared<coal::Box>(2.0 * half), nullptr, {}, Vector3::Zero()};
}

// A prism whose ends, cut into triangles, are flat: many corners lie in one plane.
std::shared_ptr<coal::Convex<coal::Triangle>> prism(int corners) {
  auto points = std::make_shared<std::vector<coal::Vec3s>>();
  auto faces = std::make_shared<std::vector<coal::Triangle>>();
  for (int corner = 0; corner < corners; ++corner) {
    const double angle = 2.0 * M_PI * corner / corners;
    for (const double end : {-0.2, 0.2}) points->push_back({0.1 * std::cos(angle), 0.1 * std::sin(angle), end});
    const int here = 2 * corner, next = 2 * ((corner + 1) % corners);
    faces->push_back(coal::Triangle(here, next, here + 1));
    faces->push_back(coal::Triangle(next, next + 1, here + 1));
    if (corner == 0 || corner == corners - 1) continue;
    faces->push_back(coal::Triangle(0, next, here));
    faces->push_back(coal::Triangle(1, here + 1, next + 1));
  }
  return std::make_shared<coal::Convex<coal::Triangle>>(points, points->size(), faces, faces->size());
}

}  // namespace

TEST(the_farthest_corner_is_found_from_any_direction) {
  std::mt19937 rng(16);
  for (const int corners : {3, 7, 8, 40, 200}) {
    const auto shape = prism(corners);
    const Polytope polytope(*shape);
    const auto reaches = [&](const Vector3& direction) {
      double most = -INFINITY;
      for (const Vector3& point : *shape->points) most = std::max(most, point.dot(direction));
      CHECK_NEAR(polytope.farthest(direction).dot(direction), most, 1e-15);
    };
    for (int trial = 0; trial < 2000; ++trial) reaches(random_vector(rng, trial % 2 ? 1.0 : 1e-6));
    // Along faces and edges, where many corners are as far.
    for (int axis = 0; axis < 3; ++axis) reaches(Vector3::Unit(axis)), reaches(-Vector3::Unit(axis));
    reaches(Vector3::Zero());
    reaches(Vector3(1.0, 1.0, 1.0));
    reaches(Vector3(-1.0, 0.0, 1.0));
  }
}

TEST(bodies_are_at_least_as_far_apart_as_along_any_direction) {
  std::mt19937 rng(17);
  ConvexPair pair(1e-9);
  for (int trial = 0; trial < 200; ++trial) {
    Body a = random_box(rng, 0.5), b = random_box(rng, 0.5);
    const auto stand = [](Body& body) {
      auto box = std::make_shared<coal::Box>(2.0 * body.half);
      box->computeLocalAABB();
      body.geometry = box;
      body.support = Support::of(*box, nullptr);
      body.middle = Vector3::Zero();
    };
    stand(a), stand(b);
    const coal::Transform3s at_a(a.rotation, a.centre), at_b(b.rotation, b.centre);
    const Place place_a{a.rotation, a.centre}, place_b{b.rotation, b.centre};
    const Nearest found = pair(a, at_a, b, at_b, 10.0, true, 1e-6);
    if (found.distance > 0.0) {
      CHECK_NEAR(pair.along(a, place_a, b, place_b, found.normal), found.distance, 1e-8);
      CHECK_NEAR((found.second - found.first).norm(), found.distance, 1e-12);
    }
    for (int probe = 0; probe < 50; ++probe) {
      const Vector3 direction = random_vector(rng, 1.0).normalized();
      CHECK(pair.along(a, place_a, b, place_b, direction) <= std::max(found.distance, 0.0) + 1e-8);
    }
    // Given up beyond a reach, the direction says why.
    const double reach = 0.5 * found.distance;
    if (reach < 0.01) continue;
    const Nearest beyond = pair(a, at_a, b, at_b, reach, true, 1e-6);
    CHECK(beyond.distance > reach && beyond.distance <= found.distance + 1e-9);
    CHECK(pair.along(a, place_a, b, place_b, beyond.normal) >= beyond.distance - 1e-9);
  }
}

TEST(obstacles_near_a_ball_are_those_whose_boxes_meet_it_and_half_spaces) {
  std::mt19937 rng(13);
  for (const int count : {0, 1, 2, 30}) {
    Obstacles obstacles;
    std::vector<Body> bodies;
    for (int i = 0; i < count; ++i) bodies.push_back(random_box(rng, 1.0));
    for (int i = 0; i < count; ++i) obstacles.add(i, bodies[i]);
    Body plane = random_box(rng, 1.0);
    plane.radius = Obstacles::kUnbounded;
    obstacles.add(count, plane);
    obstacles.build();
    for (int trial = 0; trial < 100; ++trial) {
      const Vector3 centre = random_vector(rng, 1.5);
      const double radius = uniform(rng, 0.01, 0.5);
      std::vector<int> found;
      obstacles.near(centre, radius, found);
      std::vector<bool> seen(count + 1, false);
      for (const int index : found) {
        CHECK(!seen[index]);
        seen[index] = true;
      }
      CHECK(seen[count]);
      for (int i = 0; i < count; ++i) {
        const double apart = std::sqrt(outside_squared(bodies[i], {bodies[i].rotation, bodies[i].centre}, centre));
        if (apart < radius) CHECK(seen[i]);
        if (apart > 2.0 * radius + 2.0 * bodies[i].radius) CHECK(!seen[i]);
      }
    }
  }
}

TEST(bounds_of_distance_and_motion_hold_for_points_of_the_boxes) {
  std::mt19937 rng(14);
  for (int trial = 0; trial < 200; ++trial) {
    const Body a = random_box(rng, 0.5), b = random_box(rng, 0.5);
    const Place at_a{a.rotation, a.centre}, at_b{b.rotation, b.centre}, moved{random_rotation(rng), random_vector(rng, 0.5)};
    const double bound = lower_bound(a, at_a, b, at_b, 10.0), travel = motion(a, at_a, moved);
    for (int probe = 0; probe < 50; ++probe) {
      const Vector3 in_a = random_vector(rng, 1.0).cwiseProduct(a.half), in_b = random_vector(rng, 1.0).cwiseProduct(b.half);
      const Vector3 first = at_a.rotation * in_a + at_a.centre, second = at_b.rotation * in_b + at_b.centre;
      CHECK((second - first).norm() >= bound - 1e-12);
      CHECK((moved.rotation * in_a + moved.centre - first).norm() <= travel + 1e-12);
    }
  }
}

TEST(a_closed_surface_encloses_the_points_inside_it) {
  std::mt19937 rng(15);
  const Vector3 corners[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  std::vector<Solid::Triangle> shell;
  for (const auto& face : faces) shell.push_back({corners[face[0]], corners[face[1]], corners[face[2]]});
  const Solid tetrahedron({}, shell, nullptr, {}), point({Vector3::Zero()}, {}, nullptr, {});
  for (int trial = 0; trial < 500; ++trial) {
    const Vector3 at = random_vector(rng, 1.0);
    CHECK(tetrahedron.encloses(point, Matrix3::Identity(), at) == (at.minCoeff() > 0.0 && at.sum() < 1.0));
    CHECK(!point.encloses(tetrahedron, Matrix3::Identity(), at));
  }
}

// The first numbers of the authors' reference programs, for two seeds.
TEST(random_numbers_are_those_of_the_reference_on_every_platform) {
  Generator zero(0), other(42);
  for (const std::uint64_t expected : {0x53175d61490b23dfull, 0x61da6f3dc380d507ull, 0x5c0fdf91ec9a7bfcull}) {
    CHECK(zero.next() == expected);
  }
  for (const std::uint64_t expected : {0xd0764d4f4476689full, 0x519e4174576f3791ull, 0xfbe07cfb0c24ed8cull}) {
    CHECK(other.next() == expected);
  }
  double sum = 0.0, least = 1.0, most = 0.0;
  for (int count = 0; count < 20000; ++count) {
    const double value = other.uniform();
    sum += value;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  CHECK(least >= 0.0 && least < 0.001 && most < 1.0 && most > 0.999);
  CHECK_NEAR(sum / 20000, 0.5, 0.01);
}
