#include "band.hpp"

#include <algorithm>
#include <cmath>

namespace banded {

namespace {
constexpr double kNothing = 1e-14;
}

FOR_SEVERAL_PROCESSORS
void Band::add_outers(const Runs& rows, const double* weight) {
  for (int row = 0; row < rows.count(); ++row) {
    const double* run = rows.run(row);
    const int length = rows.length[row];
    for (int j = 0; j < length; ++j) {
      add_scaled(weight[row] * run[j], run + j, column(rows.first[row] + j), length - j);
    }
  }
}

FOR_SEVERAL_PROCESSORS
void Band::multiply(const double* x, double* y) const {
  std::fill(y, y + room(), 0.0);
  for (int j = 0; j < size_; ++j) {
    const double* entries = column(j);
    const double diagonal = entries[0] * x[j];
    y[j] += dot(entries, x + j, width_);
    add_scaled(x[j], entries, y + j, width_);
    y[j] -= diagonal;
  }
}

FOR_SEVERAL_PROCESSORS
void Band::factorise() {
  std::vector<double> diagonal(size_);
  for (int j = 0; j < size_; ++j) diagonal[j] = column(j)[0];
  for (int j = 0; j < size_; ++j) {
    double* entries = column(j);
    if (!(entries[0] > kNothing * diagonal[j])) entries[0] = diagonal[j];
    const double inverse = 1.0 / std::sqrt(entries[0]);
    for (int k = 0; k < width_; ++k) entries[k] *= inverse;
    for (int k = 1; k < width_; ++k) add_scaled(-entries[k], entries + k, column(j + k), width_ - k);
    entries[0] = inverse;  // kept inverted: every solve divides by it twice
  }
}

FOR_SEVERAL_PROCESSORS
void Band::solve(double* b) const {
  std::fill(b + size_, b + room(), 0.0);
  for (int j = 0; j < size_; ++j) {
    const double* entries = column(j);
    const double value = b[j] * entries[0];
    add_scaled(-value, entries, b + j, width_);
    b[j] = value;
  }
  for (int j = size_ - 1; j >= 0; --j) {
    const double* entries = column(j);
    const double value = b[j];
    b[j] = 0.0;
    b[j] = (value - dot(entries, b + j, width_)) * entries[0];
  }
}

}  // namespace banded
