// The band against dense algebra, and the interior point method against closed forms and its own optimality.
#include "banded/interior_point.hpp"
#include "check.hpp"

using namespace banded;
using check::uniform, check::whole;

namespace {

// One row over one knot of one joint: value + x.
void add_cost(Program& program, std::int64_t knot, double value, double weight) {
  const double slope = 1.0;
  program.add_squared({1, 1, 1, &value, &slope, &knot}, &weight);
}

void add_upper(Program& program, std::int64_t knot, double upper, double penalty) {
  const double value = 0.0, slope = 1.0, lower = -INFINITY;
  program.add_excess({1, 1, 1, &value, &slope, &knot}, &lower, &upper, &penalty);
}

double solve_one(double wish, double upper, double penalty, double box) {
  Program program(1, {1});
  add_cost(program, 0, -wish, 1.0);
  if (std::isfinite(upper)) add_upper(program, 0, upper, penalty);
  program.assemble(0.0);
  const double low = -box, high = box;
  const Solution found = InteriorPoint(program, &low, &high, {}).solve();
  CHECK(found.outcome == Outcome::kSolved);
  return found.x[0];
}

}  // namespace

TEST(band_multiplies_factorises_and_solves_as_a_dense_matrix) {
  std::mt19937 rng(1);
  for (const int size : {1, 2, 7, 8, 9, 40}) {
    for (const int bandwidth : {0, 1, 5, 8, 17}) {
      std::vector<double> dense(size_t(size) * size, 0.0);
      Band band(size, bandwidth);
      for (int j = 0; j < size; ++j) {
        for (int i = j; i < std::min(size, j + bandwidth + 1); ++i) {
          const double value = i == j ? 4.0 + 2.0 * bandwidth : uniform(rng, -1.0, 1.0);
          band.column(j)[i - j] = dense[size_t(i) * size + j] = dense[size_t(j) * size + i] = value;
        }
      }
      std::vector<double> x(band.room(), 0.0), product(band.room());
      for (int j = 0; j < size; ++j) x[j] = uniform(rng, -1.0, 1.0);
      band.multiply(x.data(), product.data());
      for (int i = 0; i < size; ++i) {
        double expected = 0.0;
        for (int j = 0; j < size; ++j) expected += dense[size_t(i) * size + j] * x[j];
        CHECK_NEAR(product[i], expected, 1e-12 * (1.0 + std::abs(expected)));
      }
      band.factorise();
      band.solve(product.data());
      for (int j = 0; j < size; ++j) CHECK_NEAR(product[j], x[j], 1e-10);
    }
  }
}

TEST(a_single_variable_stops_at_its_bound_at_its_limit_or_where_the_penalty_is_outweighed) {
  CHECK_NEAR(solve_one(0.4, INFINITY, 0.0, 1.0), 0.4, 1e-3);
  CHECK_NEAR(solve_one(3.0, INFINITY, 0.0, 1.0), 1.0, 1e-3);
  CHECK_NEAR(solve_one(2.0, 1.0, 100.0, 5.0), 1.0, 1e-3);
  CHECK_NEAR(solve_one(2.0, 1.0, 1.0, 5.0), 1.5, 1e-3);
}

TEST(a_program_without_anything_that_moves_is_solved) {
  Program program(2, {0, 0, 0, 0});
  program.assemble(1e-6);
  const Solution found = InteriorPoint(program, nullptr, nullptr, {}).solve();
  CHECK(found.outcome != Outcome::kFailed);
}

TEST(no_step_within_the_bounds_is_better_than_the_solution) {
  std::mt19937 rng(2);
  for (int trial = 0; trial < 20; ++trial) {
    const int joints = whole(rng, 1, 4), knots = whole(rng, 2, 12), rows = 3 * knots;
    std::vector<char> moves(size_t(joints) * knots);
    for (char& each : moves) each = uniform(rng, 0.0, 1.0) < 0.9;
    moves[0] = 1;
    Program program(joints, moves);
    for (const bool squared : {true, false}) {
      std::vector<double> value(rows), jacobian(size_t(rows) * 2 * joints), weight(rows), low(rows), high(rows);
      std::vector<std::int64_t> knot(size_t(rows) * 2);
      for (int row = 0; row < rows; ++row) {
        value[row] = uniform(rng, -1.0, 1.0), weight[row] = uniform(rng, 0.1, 2.0);
        low[row] = uniform(rng, 0.0, 1.0) < 0.5 ? -INFINITY : -0.5, high[row] = uniform(rng, 0.0, 0.5);
        knot[2 * row] = whole(rng, 0, knots - 2), knot[2 * row + 1] = knot[2 * row] + 1;
        for (int k = 0; k < 2 * joints; ++k) jacobian[size_t(row) * 2 * joints + k] = uniform(rng, -1.0, 1.0);
      }
      const Stencils stencils{rows, 2, joints, value.data(), jacobian.data(), knot.data()};
      if (squared) {
        program.add_squared(stencils, weight.data());
      } else {
        program.add_excess(stencils, low.data(), high.data(), weight.data());
      }
    }
    program.assemble(1e-6);
    const std::vector<double> low(program.size(), -0.3), high(program.size(), 0.3);
    const Solution found = InteriorPoint(program, low.data(), high.data(), {}).solve();
    CHECK(found.outcome == Outcome::kSolved);
    std::vector<double> x(program.hessian.room(), 0.0), other(program.hessian.room(), 0.0);
    for (int j = 0; j < program.size(); ++j) {
      x[j] = found.x[j];
      CHECK(-0.3 <= x[j] && x[j] <= 0.3);
    }
    const double least = program.objective(x.data());
    for (int probe = 0; probe < 200; ++probe) {
      const double size = std::pow(10.0, uniform(rng, -4.0, 0.0));
      for (int j = 0; j < program.size(); ++j) {
        other[j] = std::min(0.3, std::max(-0.3, x[j] + size * uniform(rng, -1.0, 1.0)));
      }
      CHECK(program.objective(other.data()) >= least - 1e-5 * (1.0 + std::abs(least)));
    }
    for (const double multiplier : found.multiplier) CHECK(multiplier >= 0.0);
  }
}
