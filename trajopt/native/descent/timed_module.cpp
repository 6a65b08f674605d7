// Binding of the constraints of motions whose samples have times.
#include "binding.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace descent;

namespace {

void add_distances_in_time(Program& program, const Role& role, const Matrix<std::int64_t>& knots,
                           const Matrix<double>& weight, const Vector<double>& place, const Vector<double>& when,
                           const Matrix<double>& driven, robot::RobotQuery& among, const Vector<double>& reach,
                           const Vector<double>& margin, const Matrix<double>& errors, const Vector<double>& appears,
                           const Vector<double>& expires) {
  const std::size_t pairs = among.pairs(), joints = program.variables().joints;
  for (const auto* each : {&reach, &margin, &appears, &expires}) expect(each->shape(0) == pairs, "numbers for each pair");
  expect(errors.shape(0) == 3 && errors.shape(1) == pairs, "radius, velocity and acceleration of the error of each pair");
  expect(role.bounded(), "bounds");
  expect_numbers(role, pairs, true);
  Samples along = samples_of(program, knots, weight, place);
  const std::size_t samples = along.count();
  expect(when.shape(0) == samples && driven.shape(0) == samples, "a time and places for each sample");
  expect(joints + driven.shape(1) == static_cast<std::size_t>(among.positions()), "places of the joints that time drives");
  const auto row = [&](std::size_t order) {
    return std::vector<double>(errors.data() + order * pairs, errors.data() + (order + 1) * pairs);
  };
  program.add({role, DistancesInTime{std::move(along), copied(when), copied(driven), &among, copied(reach),
                                     copied(margin), copied(appears), copied(expires), row(0), row(1), row(2)}});
}

void add_torques(Program& program, const Role& role, const Matrix<std::int64_t>& knots, const Matrix<double>& position,
                 const Matrix<double>& velocity, const Matrix<double>& acceleration, const Vector<double>& place,
                 robot::RobotDynamics& dynamics, const Vector<double>& effort, double listed) {
  const std::size_t joints = program.variables().joints;
  expect(effort.shape(0) == joints && static_cast<std::size_t>(dynamics.dofs()) == joints, "a limit for each joint");
  expect(role.bounded(), "bounds");
  expect_numbers(role, joints, true);
  for (const auto* each : {&velocity, &acceleration}) {
    expect(each->shape(0) == position.shape(0) && each->shape(1) == position.shape(1), "as many weights of each rate");
  }
  program.add({role, Torques{samples_of(program, knots, position, place), copied(velocity), copied(acceleration),
                             &dynamics, copied(effort), listed}});
}

}  // namespace

void bind_what_changes(nb::class_<Program>& program) {
  program
      .def("add_distances_in_time", &add_distances_in_time, "role"_a, "knots"_a, "weight"_a, "place"_a, "when"_a,
           "driven"_a, "among"_a, "reach"_a, "margin"_a, "errors"_a, "appears"_a, "expires"_a, nb::keep_alive<1, 8>())
      .def("add_torques", &add_torques, "role"_a, "knots"_a, "position"_a, "velocity"_a, "acceleration"_a, "place"_a,
           "dynamics"_a, "effort"_a, "listed"_a, nb::keep_alive<1, 8>());
}
