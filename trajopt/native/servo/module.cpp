// Binding of the servo's tick: bounds of velocities, speeds of bodies, singularities, and the program.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <memory>
#include <optional>

#include "../arrays.hpp"
#include "../leaks.hpp"
#include "body_speeds.hpp"
#include "settling.hpp"
#include "singular.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace servo;
using arrays::Block, arrays::expect, arrays::hand_over, arrays::Matrix, arrays::Numpy, arrays::Vector;
using Array = Numpy<double>;

namespace {

template <typename Given>
Numbers copied(const Given& values) {
  return Numbers(values.data(), values.data() + values.size());
}

Array handed(const Rows& rows) {
  return hand_over(Numbers(rows.data(), rows.data() + rows.size()), {std::size_t(rows.rows()), std::size_t(rows.cols())});
}

Array handed(const Column& values) {
  return hand_over(Numbers(values.data(), values.data() + values.size()), {std::size_t(values.size())});
}

Braking* make_braking(const Matrix<double>& limits, const Vector<double>& delay, double period, double cycle, double excess,
                      double inset) {
  const std::size_t joints = limits.shape(1);
  expect(limits.shape(0) == 5 && delay.size() == joints, "five limits and a delay for each joint");
  const auto row = [&](std::size_t number) {
    return Numbers(limits.data() + number * joints, limits.data() + (number + 1) * joints);
  };
  return new Braking{row(0), row(1), row(2), row(3), row(4), copied(delay), period, cycle, excess, inset};
}

void expect_state(const Braking& braking, const Matrix<double>& state) {
  expect(state.shape(0) == 3 && state.shape(1) == braking.joints(), "positions, velocities and accelerations");
}

BodySpeeds* make_speeds(const Vector<std::int64_t>& joint, const Matrix<double>& centre, const Vector<double>& radius,
                        const Matrix<double>& carried, const Vector<std::int64_t>& first,
                        const Vector<std::int64_t>& second, const Matrix<double>& mimic, const Matrix<double>& levers) {
  const std::size_t bodies = joint.size(), moving = carried.shape(0), joints = carried.shape(1);
  expect(centre.shape(0) == bodies && centre.shape(1) == 3 && radius.size() == bodies, "a sphere for each body");
  expect(mimic.shape(0) == moving && levers.shape(1) == mimic.shape(1), "speeds of the same joints");
  expect(first.size() == second.size() && first.size() == levers.shape(0), "levers of each pair");
  auto speeds = std::make_unique<BodySpeeds>();
  for (std::size_t number = 0; number < bodies; ++number) {
    expect(joint(number) >= 0 && std::size_t(joint(number)) < joints, "known joints");
    Body body{std::size_t(joint(number)), {centre(number, 0), centre(number, 1), centre(number, 2)}, radius(number), {}};
    for (std::size_t each = 0; each < moving; ++each)
      if (carried(each, body.joint) != 0.0) body.carriers.push_back(each);
    speeds->bodies.push_back(std::move(body));
  }
  for (std::size_t pair = 0; pair < first.size(); ++pair)
    for (const std::int64_t body : {first(pair), second(pair)})
      expect(body >= 0 && std::size_t(body) < bodies, "known bodies");
  speeds->first.assign(first.data(), first.data() + first.size());
  speeds->second.assign(second.data(), second.data() + second.size());
  speeds->group = mimic.shape(1), speeds->moving = moving;
  speeds->mimic = copied(mimic), speeds->levers = copied(levers);
  return speeds.release();
}

Array nearer(const BodySpeeds& speeds, const Block<double>& rotation, const Matrix<double>& translation,
             const Matrix<double>& jacobian, const Vector<double>& lower, const Vector<double>& upper) {
  for (const Body& body : speeds.bodies)
    expect(body.joint < rotation.shape(0) && body.joint < translation.shape(0), "placements of the model's joints");
  expect(rotation.shape(1) == 3 && rotation.shape(2) == 3 && translation.shape(1) == 3, "placements of the model's joints");
  expect(jacobian.shape(0) == 6 && jacobian.shape(1) == speeds.moving, "a Jacobian of the model's joints");
  expect(lower.size() == speeds.group && upper.size() == speeds.group, "two bounds for each joint");
  Numbers found = speeds.nearer(rotation.data(), translation.data(), jacobian.data(), lower.data(), upper.data());
  const std::size_t pairs = found.size();
  return hand_over(std::move(found), {pairs});
}

Chain chain_of(const Matrix<double>& linear, const Matrix<double>& angular, const Matrix<double>& mimic, double length) {
  const auto joints = Eigen::Index(linear.shape(0));
  expect(linear.shape(1) == 3 && angular.shape(1) == 3, "velocities of three components");
  expect(angular.shape(0) == linear.shape(0) && mimic.shape(0) == linear.shape(0), "velocities by the same joints");
  return {Eigen::Map<const Vectors>(linear.data(), joints, 3), Eigen::Map<const Vectors>(angular.data(), joints, 3),
          Eigen::Map<const Rows>(mimic.data(), joints, Eigen::Index(mimic.shape(1))), length};
}

auto singular(const Matrix<double>& linear, const Matrix<double>& angular, const Matrix<double>& mimic, double length) {
  const Singular found = singular_values(chain_of(linear, angular, mimic, length));
  return nb::make_tuple(handed(found.left), handed(found.values), handed(found.right), handed(found.slopes));
}

auto approach(const Matrix<double>& linear, const Matrix<double>& angular, const Matrix<double>& mimic, double length,
              const Vector<double>& twist, const Vector<double>& velocity, double ending) {
  expect(twist.size() == 6 && velocity.size() == mimic.shape(1), "a twist, and a limit for each joint");
  const Singular found = singular_values(chain_of(linear, angular, mimic, length));
  const Column asked = Eigen::Map<const Column>(twist.data(), 6);
  const Column limits = Eigen::Map<const Column>(velocity.data(), Eigen::Index(velocity.size()));
  return nb::make_tuple(handed(found.slopes), handed(room(found, asked, limits, ending)));
}

std::optional<Array> settled(const Matrix<double>& task, const Vector<double>& target, const Matrix<double>& approach,
                             const Vector<double>& least, const Vector<double>& lower, const Vector<double>& upper,
                             const Vector<double>& velocity,
                             const std::tuple<double, double, double, double, double>& weights, int max_iterations) {
  const auto [damping, penalty, still, accuracy, regularisation] = weights;
  const std::size_t joints = lower.size();
  expect(upper.size() == joints && velocity.size() == joints, "two bounds and a limit for each joint");
  expect(task.shape(1) == joints && task.shape(0) == target.size(), "a target for each row of the task");
  expect(approach.shape(1) == joints && approach.shape(0) == least.size(), "a bound for each row of the approach");
  std::optional<Numbers> found =
      settle({task.shape(0), task.data(), target.data()}, {approach.shape(0), approach.data(), least.data()},
             copied(lower), copied(upper), copied(velocity),
             {damping, penalty, still, accuracy, regularisation, max_iterations});
  if (!found) return std::nullopt;
  return hand_over(std::move(*found), {joints});
}

}  // namespace

NB_MODULE(servo, m) {
  leaks::settle();
  nb::class_<Braking>(m, "Braking")
      .def(nb::new_(&make_braking), "limits"_a, "delay"_a, "period"_a, "cycle"_a, "excess"_a, "inset"_a)
      .def(
          "time",
          [](const Braking& braking, const Vector<double>& velocities) {
            expect(velocities.size() == braking.joints(), "a velocity of each joint");
            return braking.time(velocities.data());
          },
          "velocities"_a)
      .def(
          "bounds",
          [](const Braking& braking, const Matrix<double>& state) {
            expect_state(braking, state);
            Numbers least(braking.joints()), greatest(braking.joints());
            braking.bounds(state.data(), least.data(), greatest.data());
            return nb::make_tuple(hand_over(std::move(least), {braking.joints()}),
                                  hand_over(std::move(greatest), {braking.joints()}));
          },
          "state"_a)
      .def(
          "after",
          [](const Braking& braking, const Matrix<double>& state, const Vector<double>& settled) {
            expect_state(braking, state);
            expect(settled.size() == braking.joints(), "a velocity of each joint");
            Numbers then(3 * braking.joints());
            braking.after(state.data(), settled.data(), then.data());
            return hand_over(std::move(then), {3, braking.joints()});
          },
          "state"_a, "settled"_a);
  nb::class_<BodySpeeds>(m, "BodySpeeds")
      .def(nb::new_(&make_speeds), "joint"_a, "centre"_a, "radius"_a, "carried"_a, "first"_a, "second"_a, "mimic"_a,
           "levers"_a)
      .def("nearer", &nearer, "rotation"_a, "translation"_a, "jacobian"_a, "lower"_a, "upper"_a);
  m.def("singular_values", &singular, "linear"_a, "angular"_a, "mimic"_a, "length"_a);
  m.def("approach", &approach, "linear"_a, "angular"_a, "mimic"_a, "length"_a, "twist"_a, "velocity"_a, "ending"_a);
  m.def("settle", &settled, "task"_a, "target"_a, "approach"_a, "least"_a, "lower"_a, "upper"_a, "velocity"_a, "weights"_a,
        "max_iterations"_a);
}
