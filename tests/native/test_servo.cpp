// The servo's tick: bounds and states after it, speeds of a body, singular values of a planar arm, and the program.
#include "check.hpp"
#include "servo/body_speeds.hpp"
#include "servo/settling.hpp"
#include "servo/singular.hpp"

using namespace servo;
using check::uniform;

namespace {

Braking braking() {
  return {{-2.0, -1.0}, {2.0, 1.0}, {1.0, 2.0}, {5.0, 4.0}, {50.0, 80.0}, {0.09, 0.065}, 0.01, 1e-3, 1e-9, 1e-5};
}

}  // namespace

TEST(the_state_after_a_tick_is_within_the_limits) {
  std::mt19937 rng(1);
  const Braking made = braking();
  for (int trial = 0; trial < 200; ++trial) {
    Numbers state(6), lower(2), upper(2), then(6), settled(2);
    for (std::size_t joint = 0; joint < 2; ++joint) {
      state[joint] = uniform(rng, made.lower[joint], made.upper[joint]);
      state[2 + joint] = uniform(rng, -made.velocity[joint], made.velocity[joint]);
      state[4 + joint] = uniform(rng, -made.acceleration[joint], made.acceleration[joint]);
    }
    made.bounds(state.data(), lower.data(), upper.data());
    for (std::size_t joint = 0; joint < 2; ++joint) {
      CHECK(lower[joint] <= upper[joint]);
      settled[joint] = uniform(rng, lower[joint], upper[joint]);
    }
    made.after(state.data(), settled.data(), then.data());
    for (std::size_t joint = 0; joint < 2; ++joint) {
      CHECK(std::abs(then[4 + joint]) <= made.acceleration[joint]);
      CHECK(std::abs(then[4 + joint] - state[4 + joint]) <= made.jerk[joint] * made.period * (1.0 + 1e-9));
    }
  }
}

TEST(a_sphere_on_a_turning_joint) {
  // One joint about z, a sphere of 0.1 m at 0.5 m from it, and one that stands still.
  const BodySpeeds speeds{{{1, {0.5, 0.0, 0.0}, 0.1, {0}}, {0, {0.0, 0.0, 0.0}, 0.2, {}}}, {0}, {1}, 1, 1, {1.0}, {0.9}};
  const double rotation[] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1}, translation[6] = {};
  const double jacobian[] = {0, 0, 0, 0, 0, 1}, lower[] = {1.8}, upper[] = {2.0};
  CHECK_NEAR(speeds.nearer(rotation, translation, jacobian, lower, upper)[0], 1.9 * 0.6 + 0.1 * 0.9, 1e-12);
}

TEST(a_planar_arm_is_singular_when_stretched) {
  const double bent = 1e-3, linear[] = {-std::sin(bent), 1.0 + std::cos(bent), 0, -std::sin(bent), std::cos(bent), 0};
  const double angular[] = {0, 0, 1, 0, 0, 1}, mimic[] = {1, 0, 0, 1};
  const Chain chain{Eigen::Map<const Vectors>(linear, 2, 3), Eigen::Map<const Vectors>(angular, 2, 3),
                    Eigen::Map<const Rows>(mimic, 2, 2), 0.0};
  const Singular found = singular_values(chain);
  CHECK_NEAR(found.values[0] * found.values[1], std::sin(bent), 1e-12);  // the determinant
  CHECK_NEAR(found.slopes(1, 0), 0.0, 1e-9);
  CHECK_NEAR(std::abs(found.slopes(1, 1)), 1.0 / std::sqrt(5.0), 1e-3);
}

TEST(the_program_of_one_joint) {
  const double one[] = {1.0}, fast[] = {2.0}, slow[] = {0.5}, nearing[] = {-1.0}, least[] = {-0.2};
  const Weights weights{1e-6, 1e4, 1e-9, 1e-10, 1e-9, 60};
  const LinearRows nothing{0, nullptr, nullptr};
  CHECK_NEAR((*settle({1, one, slow}, nothing, {-1.0}, {1.0}, {1.0}, weights))[0], 0.5, 1e-5);
  CHECK_NEAR((*settle({1, one, fast}, nothing, {-1.0}, {1.0}, {1.0}, weights))[0], 1.0, 1e-5);
  CHECK_NEAR((*settle({1, one, slow}, {1, nearing, least}, {-1.0}, {1.0}, {1.0}, weights))[0], 0.2, 1e-5);
}
