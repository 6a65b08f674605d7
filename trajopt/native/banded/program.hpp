// The quadratic program of one step: squared costs, and linear rows whose excess is penalised.
//
//   minimise  1/2 x'Hx + g'x + sum_i penalty_i max(0, row_i x - bound_i)   subject to  lower <= x <= upper
//
// Every row touches few neighbouring knots. Costs and excesses are taken in as they come, and put together by tiles:
// each knot that moves takes as many lanes of x as fill tiles. What does not move, and what is left of a tile, are
// lanes whose entries are zero, and one on the diagonal.
#pragma once

#include <cstdint>
#include <utility>
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
  Program(int joints, const std::vector<char>& moves);

  // Add weight (value + J x)^2 for each row.
  void add_squared(const Stencils& rows, const double* weight);
  // Add penalty max(0, lower - value - J x) and penalty max(0, value + J x - upper); infinite bounds add nothing.
  void add_excess(const Stencils& rows, const double* lower, const double* upper, const double* penalty);
  // Put squares and excesses together; none may be added any longer.
  void assemble(double regularisation);

  int joints() const { return joints_; }
  int knots() const { return static_cast<int>(lane_.size()) / joints_; }
  int size() const { return size_; }
  int row_count() const { return static_cast<int>(excesses_.size()); }
  // The lane of each variable; -1 for those that do not move.
  const std::vector<int>& lanes() const { return lane_; }
  // Groups of lanes of all variables, and of all rows.
  int variable_groups() const { return groups_; }
  int row_groups() const { return rows.groups; }

  // Good once it is put together. Vectors of rows have room for a group more than there are.
  Band hessian;
  Runs rows;
  Eights gradient, bound, penalty;
  Eights variable_there, row_there;  // one where a lane is taken, else zero

 private:
  struct Entry {
    int lane;
    double value;
  };
  // Entries from `start` to `end`.
  struct Square {
    double weight, value;
    std::size_t start, end;
  };
  struct Excess {
    double sign, bound, penalty;
    int tile, tiles;
    std::size_t start, end;
  };

  void take_entries(const Stencils& rows, int row);
  std::pair<int, int> tiles_between(std::size_t start, std::size_t end) const;
  int reach() const;
  void assemble_squares();
  void assemble_rows();
  int lane_of(const Excess& excess) const;
  void deal(const std::vector<int>& bucket, std::vector<int>& alone, std::vector<int>& places) const;
  void assemble_sets(const std::vector<int>& order);
  void assemble_beside(const std::vector<int>& places);
  void take_in(const Excess& excess, int row);

  int joints_, groups_ = 0, size_ = 0;
  std::vector<int> lane_;
  std::vector<Square> squares_;
  std::vector<Excess> excesses_;
  std::vector<Entry> entries_;
  bool assembled_ = false;
};

}  // namespace banded
