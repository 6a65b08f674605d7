// The best step of a program, against closed forms and its own optimality.
#include "banded/step.hpp"
#include "check.hpp"

using namespace banded;
using check::uniform, check::whole;

namespace {

// Rows of a program, kept to say what they cost without it.
struct Rows {
  int knots, joints;
  bool squared;
  std::vector<double> value, jacobian, weight, low, high;
  std::vector<std::int64_t> knot;

  Stencils stencils() const {
    return {static_cast<int>(value.size()), knots, joints, value.data(), jacobian.data(), knot.data()};
  }

  void add_to(Program& program) const {
    if (squared) {
      program.add_squared(stencils(), weight.data());
    } else {
      program.add_excess(stencils(), low.data(), high.data(), weight.data());
    }
  }

  double cost(const std::vector<double>& x) const {
    double sum = 0.0;
    for (std::size_t row = 0; row < value.size(); ++row) {
      double there = value[row];
      for (int k = 0; k < knots; ++k) {
        for (int j = 0; j < joints; ++j) {
          there += jacobian[(row * knots + k) * joints + j] * x[knot[row * knots + k] * joints + j];
        }
      }
      const double over = std::max(0.0, there - high[row]) + std::max(0.0, low[row] - there);
      sum += weight[row] * (squared ? there * there : over);
    }
    return sum;
  }
};

// The x in [-box, box] with the least (x - wish)^2 + penalty max(0, x - upper).
double solve_one(double wish, double upper, double penalty, double box) {
  Program program(1, {1});
  Rows{1, 1, true, {-wish}, {1.0}, {1.0}, {0.0}, {0.0}, {0}}.add_to(program);
  if (std::isfinite(upper)) Rows{1, 1, false, {0.0}, {1.0}, {penalty}, {-INFINITY}, {upper}, {0}}.add_to(program);
  const double low = -box, high = box;
  const Step found = best_step(program, &low, &high, 0.0, {});
  CHECK(found.outcome == Outcome::kSolved);
  return found.change[0];
}

}  // namespace

TEST(a_single_variable_stops_at_its_bound_at_its_limit_or_where_the_penalty_is_outweighed) {
  CHECK_NEAR(solve_one(0.4, INFINITY, 0.0, 1.0), 0.4, 1e-3);
  CHECK_NEAR(solve_one(3.0, INFINITY, 0.0, 1.0), 1.0, 1e-3);
  CHECK_NEAR(solve_one(2.0, 1.0, 100.0, 5.0), 1.0, 1e-3);
  CHECK_NEAR(solve_one(2.0, 1.0, 1.0, 5.0), 1.5, 1e-3);
}

TEST(a_program_without_anything_that_moves_is_solved) {
  Program program(2, {0, 0, 0, 0});
  const std::vector<double> none(4, 0.0);
  const Step found = best_step(program, none.data(), none.data(), 1e-6, {});
  CHECK(found.outcome != Outcome::kFailed);
  for (const double each : found.change) CHECK(each == 0.0);
}

TEST(no_step_within_the_bounds_is_better_than_the_solution) {
  std::mt19937 rng(2);
  for (int trial = 0; trial < 20; ++trial) {
    const int joints = whole(rng, 1, 4), knots = whole(rng, 2, 12), count = 3 * knots;
    const int size = joints * knots;
    std::vector<char> moves(size);
    for (char& each : moves) each = uniform(rng, 0.0, 1.0) < 0.9;
    moves[0] = 1;
    Program program(joints, moves);
    std::vector<Rows> all;
    for (const bool squared : {true, false}) {
      Rows rows{2, joints, squared, {}, {}, {}, {}, {}, {}};
      for (int row = 0; row < count; ++row) {
        rows.value.push_back(uniform(rng, -1.0, 1.0));
        rows.weight.push_back(uniform(rng, 0.1, 2.0));
        rows.low.push_back(uniform(rng, 0.0, 1.0) < 0.5 ? -INFINITY : -0.5);
        rows.high.push_back(uniform(rng, 0.0, 0.5));
        rows.knot.push_back(whole(rng, 0, knots - 2));
        rows.knot.push_back(rows.knot.back() + 1);
        for (int k = 0; k < 2 * joints; ++k) rows.jacobian.push_back(uniform(rng, -1.0, 1.0));
      }
      all.push_back(rows);
      rows.add_to(program);
    }
    const auto cost = [&all](const std::vector<double>& x) { return all[0].cost(x) + all[1].cost(x); };
    const std::vector<double> low(size, -0.3), high(size, 0.3);
    const Step found = best_step(program, low.data(), high.data(), 1e-6, {});
    CHECK(found.outcome == Outcome::kSolved);
    for (int j = 0; j < size; ++j) {
      CHECK(-0.3 <= found.change[j] && found.change[j] <= 0.3);
      if (!moves[j]) CHECK(found.change[j] == 0.0);
    }
    const double least = cost(found.change);
    CHECK_NEAR(cost(std::vector<double>(size, 0.0)) - least, found.reduction, 1e-4 * (1.0 + std::abs(least)));
    std::vector<double> other(size, 0.0);
    for (int probe = 0; probe < 200; ++probe) {
      const double reach = std::pow(10.0, uniform(rng, -4.0, 0.0));
      for (int j = 0; j < size; ++j) {
        if (moves[j]) other[j] = std::min(0.3, std::max(-0.3, found.change[j] + reach * uniform(rng, -1.0, 1.0)));
      }
      CHECK(cost(other) >= least - 1e-5 * (1.0 + std::abs(least)));
    }
  }
}
