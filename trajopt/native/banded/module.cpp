// Binding of the structured quadratic program.
#include <algorithm>

#include "../arrays.hpp"
#include "../gil.hpp"
#include "../leaks.hpp"
#include "step.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace banded;
using arrays::Block, arrays::expect, arrays::hand_over, arrays::Matrix, arrays::Vector;

namespace {

Stencils stencils(const Program& program, const Vector<double>& value, const Block<double>& jacobian,
                  const Matrix<std::int64_t>& knots) {
  const size_t rows = jacobian.shape(0);
  expect(value.shape(0) == rows && knots.shape(0) == rows && knots.shape(1) == jacobian.shape(1),
         "as many values and stencils as rows");
  expect(static_cast<int>(jacobian.shape(2)) == program.joints(), "one derivative for each joint");
  const auto* first = knots.data();
  const auto* end = first + rows * knots.shape(1);
  expect(std::all_of(first, end, [&](auto knot) { return 0 <= knot && knot < program.knots(); }), "known knots");
  return {static_cast<int>(jacobian.shape(0)), static_cast<int>(jacobian.shape(1)),
          static_cast<int>(jacobian.shape(2)), value.data(), jacobian.data(), knots.data()};
}

Program* make_program(int joints, const Vector<bool>& moves) {
  return new Program(joints, std::vector<char>(moves.data(), moves.data() + moves.shape(0)));
}

// Step, predicted reduction, outcome, iterations.
auto solve(Program& program, const Vector<double>& lower, const Vector<double>& upper, double regularisation,
           double accuracy, int max_iterations) {
  const std::size_t variables = program.lanes().size();
  expect(lower.shape(0) == variables && upper.shape(0) == variables, "two bounds for each variable");
  Options options;
  options.accuracy = accuracy;
  options.max_iterations = max_iterations;
  Step step;
  {
    gil::Released released;
    step = best_step(program, lower.data(), upper.data(), regularisation, options);
  }
  return nb::make_tuple(hand_over(std::move(step.change), {variables}), step.reduction, static_cast<int>(step.outcome),
                        step.iterations);
}

}  // namespace

NB_MODULE(banded, m) {
  leaks::settle();
  nb::class_<Program>(m, "Program")
      .def(nb::new_(&make_program), "joints"_a, "moves"_a)
      .def("add_squared",
           [](Program& program, const Vector<double>& value, const Block<double>& jacobian,
              const Matrix<std::int64_t>& knots, const Vector<double>& weight) {
             expect(weight.shape(0) == value.shape(0), "one weight for each row");
             program.add_squared(stencils(program, value, jacobian, knots), weight.data());
           },
           "value"_a, "jacobian"_a, "knots"_a, "weight"_a)
      .def("add_excess",
           [](Program& program, const Vector<double>& value, const Block<double>& jacobian,
              const Matrix<std::int64_t>& knots, const Vector<double>& lower, const Vector<double>& upper,
              const Vector<double>& penalty) {
             expect(lower.shape(0) == value.shape(0) && upper.shape(0) == value.shape(0) &&
                        penalty.shape(0) == value.shape(0),
                    "two bounds and a penalty for each row");
             program.add_excess(stencils(program, value, jacobian, knots), lower.data(), upper.data(), penalty.data());
           },
           "value"_a, "jacobian"_a, "knots"_a, "lower"_a, "upper"_a, "penalty"_a)
      .def("solve", &solve, "lower"_a, "upper"_a, "regularisation"_a, "accuracy"_a, "max_iterations"_a)
      .def_prop_ro("rows", &Program::row_count);
}
