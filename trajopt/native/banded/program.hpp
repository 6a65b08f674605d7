// The quadratic program of one step: squared costs, and linear rows whose excess is penalised.
//
//   minimise  1/2 x'Hx + g'x + sum_i penalty_i max(0, row_i x - bound_i)   subject to  lower <= x <= upper
//
// Every row touches few neighbouring knots. Costs and excesses are taken in as they come; variables that cannot
// move are left out.
#pragma once

#include <cstdint>
#include <vector>

#include "band.hpp"

namespace banded {

// Rows as the terms write them: value, and derivatives by the knots of a stencil.
struct Stencils {
  int rows, knots, joints;
  const double* value;         // rows
  const double* jacobian;      // rows, knots, joints
  const std::int64_t* knot;    // rows, knots
};

class Program {
 public:
  // `moves` says for each variable, knot by knot, whether it may change.
  Program(int joints, std::vector<char> moves);

  // Add weight (value + J x)^2 for each row.
  void add_squared(const Stencils& rows, const double* weight);
  // Add penalty max(0, lower - value - J x) and penalty max(0, value + J x - upper); infinite bounds add nothing.
  void add_excess(const Stencils& rows, const double* lower, const double* upper, const double* penalty);
  // Put the squares together; rows may no longer be added.
  void assemble(double regularisation);

  int joints() const { return joints_; }
  int knots() const { return static_cast<int>(column_.size()) / joints_; }
  int size() const { return size_; }
  int bandwidth() const { return bandwidth_; }
  const std::vector<int>& columns() const { return column_; }

  // 1/2 x'Hx + g'x + the penalised excess; x has room for `hessian.room()` numbers.
  double objective(const double* x) const;

  Band hessian;
  std::vector<double> gradient;
  Runs rows;
  std::vector<double> bound, penalty;

 private:
  struct Square {
    double weight, value;
    int start, end;  // in square_entries_
  };
  struct Entry {
    int column;
    double value;
  };

  const std::vector<Entry>& entries_of(const Stencils& rows, int row);

  int joints_, size_ = 0, bandwidth_ = 0;
  std::vector<int> column_;  // of each variable among those that move; -1 for the others
  std::vector<Square> squares_;
  std::vector<Entry> square_entries_, scratch_;
};

}  // namespace banded
