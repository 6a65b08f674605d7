// Symmetric matrices whose entries lie near the diagonal, and their Cholesky factorisation.
//
// Column by column, the lower triangle only: entry (i, j), i >= j, is at column j, place i - j. All columns have
// the same length; what would lie below the matrix is kept zero. Source: Golub and Van Loan, Matrix Computations
// (4th ed.), section 4.3.5.
#pragma once

#include <cstddef>
#include <vector>

#include "lanes.hpp"

namespace banded {

// Rows that are zero but for a run of entries each, every run followed by zeros.
struct Runs {
  std::vector<int> first, start, length;  // column of the first entry, where the entries begin, how many
  std::vector<double> values;

  int count() const { return static_cast<int>(first.size()); }
  const double* run(int row) const { return values.data() + start[row]; }
};

class Band {
 public:
  Band() = default;
  Band(int size, int bandwidth)
      : size_(size),
        width_(bandwidth + 1),
        stride_(padded(width_) + kLanes),
        values_(static_cast<std::size_t>(size + width_ + 1) * stride_) {}

  int size() const { return size_; }
  double* column(int j) { return values_.data() + static_cast<std::size_t>(j) * stride_; }
  const double* column(int j) const { return values_.data() + static_cast<std::size_t>(j) * stride_; }
  // Numbers that vectors of this matrix must have room for.
  int room() const { return size_ + padded(width_) + kLanes; }

  // Add the sum of weight_i row_i row_i'.
  void add_outers(const Runs& rows, const double* weight);
  // y = A x.
  void multiply(const double* x, double* y) const;
  // Factorise in place, A = L L', for A that is positive definite but for rounding: a pivot that is nothing beside
  // its diagonal entry is taken to be that entry, so that its variable stays where it is (as good as).
  void factorise();
  // Solve L L' x = b in place; only after factorise().
  void solve(double* b) const;

 private:
  int size_ = 0, width_ = 1, stride_ = 2 * kLanes;
  std::vector<double> values_;
};

}  // namespace banded
