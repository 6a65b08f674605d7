// Symmetric matrices whose entries lie near the diagonal, and their Cholesky factorisation.
//
// Column by column, the lower triangle only: entry (i, j), i >= j, is at column j, place i - j. All columns have
// the same length; what would lie below the matrix is kept zero. Source: Golub and Van Loan, Matrix Computations
// (4th ed.), section 4.3.5.
#pragma once

#include <cstddef>
#include <vector>

namespace banded {

// Rows that are zero but for a run of entries each.
struct Runs {
  std::vector<int> first, start;  // column of the first entry, and where the entries begin in `values`
  std::vector<double> values;

  int count() const { return static_cast<int>(first.size()); }
  int length(int row) const {
    const int end = row + 1 < count() ? start[row + 1] : static_cast<int>(values.size());
    return end - start[row];
  }
  const double* run(int row) const { return values.data() + start[row]; }
};

class Band {
 public:
  Band() = default;
  Band(int size, int bandwidth)
      : size_(size), width_(bandwidth + 1), values_(static_cast<std::size_t>(size + bandwidth) * width_, 0.0) {}

  int size() const { return size_; }
  int width() const { return width_; }
  double* column(int j) { return values_.data() + static_cast<std::size_t>(j) * width_; }
  const double* column(int j) const { return values_.data() + static_cast<std::size_t>(j) * width_; }

  // Add the sum of weight_i row_i row_i'.
  void add_outers(const Runs& rows, const double* weight);
  // y = A x.
  void multiply(const double* x, double* y) const;
  // Factorise in place, A = L L'; false if A is not positive definite.
  bool factorise();
  // Solve L L' x = b in place; only after factorise().
  void solve(double* b) const;

 private:
  int size_ = 0, width_ = 1;
  std::vector<double> values_;
};

}  // namespace banded
