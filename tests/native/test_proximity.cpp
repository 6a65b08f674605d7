// The query's bounds, obstacles and enclosure, as far as they need no robot.
#include "check.hpp"
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
  return {0, random_rotation(rng), at, at, half, half.norm(), std::make_shared<coal::Box>(2.0 * half), nullptr};
}

}  // namespace

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
  const Solid tetrahedron({}, shell), point({Vector3::Zero()}, {});
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
