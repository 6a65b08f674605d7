// Rows of one cost or constraint at one point, and what they are for.
#pragma once

#include <cstdint>
#include <vector>

#include "../banded/program.hpp"

namespace descent {

enum class Kind { kSquared, kAbsolute, kHinge, kBounded };

// A cost with a loss and weights, or bounds to keep: one number for all rows, or one for each component.
struct Role {
  Kind kind;
  std::vector<double> weight;        // of costs
  std::vector<double> lower, upper;  // of constraints
  double tolerance = 0.0;            // violation up to which these count as held

  bool bounded() const { return kind == Kind::kBounded; }
};

// The number of a component, of which there may be one for all.
inline double of(const std::vector<double>& numbers, std::size_t component) {
  return numbers.size() == 1 ? numbers[0] : numbers[component];
}

// Rows whose stencils and limits may lie elsewhere, where they are the same at every point.
struct Rows {
  int stencil = 0;  // knots of each row
  std::vector<double> value;
  const double* jacobian = nullptr;    // row, knot of the stencil, joint
  const std::int64_t* knot = nullptr;  // row, knot of the stencil
  const double *weight = nullptr, *lower = nullptr, *upper = nullptr;

  // What is made anew at this point; `settle` lets the pointers above refer to it.
  std::vector<double> new_jacobian, new_weight, new_lower, new_upper, place;
  std::vector<std::int64_t> new_knot, component;

  Rows() = default;
  Rows(const Rows&) = delete;
  Rows(Rows&&) = default;
  Rows& operator=(Rows&&) = default;

  int count() const { return static_cast<int>(value.size()); }
  void settle(int knots_of_stencil) {
    stencil = knots_of_stencil;
    jacobian = new_jacobian.data();
    knot = new_knot.data();
    weight = new_weight.data();
    lower = new_lower.data();
    upper = new_upper.data();
  }
  banded::Stencils stencils(int joints) const { return {count(), stencil, joints, value.data(), jacobian, knot}; }

  // The cost of all rows.
  double cost(Kind kind) const;
  // How far a row is outside its bounds; not a number where its value is none.
  double violation(int row) const;
};

}  // namespace descent
