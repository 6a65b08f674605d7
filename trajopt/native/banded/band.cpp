#include "band.hpp"

#include <algorithm>
#include <cmath>

#include "clones.hpp"

namespace banded {

FOR_SEVERAL_PROCESSORS
void Band::add_outers(const Runs& rows, const double* weight) {
  for (int row = 0; row < rows.count(); ++row) {
    const double* __restrict run = rows.run(row);
    const int first = rows.first[row], length = rows.length(row);
    for (int j = 0; j < length; ++j) {
      double* __restrict target = column(first + j);
      const double scaled = weight[row] * run[j];
      for (int i = j; i < length; ++i) target[i - j] += scaled * run[i];
    }
  }
}

FOR_SEVERAL_PROCESSORS
void Band::multiply(const double* x, double* y) const {
  for (int j = 0; j < size_; ++j) y[j] = 0.0;
  for (int j = 0; j < size_; ++j) {
    const double* __restrict entries = column(j);
    const int below = std::min(width_, size_ - j);
    const double here = x[j];
    double sum = entries[0] * here;
    for (int k = 1; k < below; ++k) {
      sum += entries[k] * x[j + k];
      y[j + k] += entries[k] * here;
    }
    y[j] += sum;
  }
}

FOR_SEVERAL_PROCESSORS
bool Band::factorise() {
  const int bandwidth = width_ - 1;
  for (int j = 0; j < size_; ++j) {
    double* __restrict entries = column(j);
    if (!(entries[0] > 0.0)) return false;
    const double inverse = 1.0 / std::sqrt(entries[0]);
    entries[0] = inverse;  // kept inverted: every solve divides by it twice
    for (int k = 1; k <= bandwidth; ++k) entries[k] *= inverse;
    for (int k = 1; k <= bandwidth; ++k) {
      double* __restrict target = column(j + k);
      const double factor = entries[k];
      for (int i = k; i <= bandwidth; ++i) target[i - k] -= factor * entries[i];
    }
  }
  return true;
}

FOR_SEVERAL_PROCESSORS
void Band::solve(double* b) const {
  for (int j = 0; j < size_; ++j) {
    const double* __restrict entries = column(j);
    const int below = std::min(width_, size_ - j);
    const double value = b[j] *= entries[0];
    for (int k = 1; k < below; ++k) b[j + k] -= entries[k] * value;
  }
  for (int j = size_ - 1; j >= 0; --j) {
    const double* __restrict entries = column(j);
    const int below = std::min(width_, size_ - j);
    double value = b[j];
    for (int k = 1; k < below; ++k) value -= entries[k] * b[j + k];
    b[j] = value * entries[0];
  }
}

}  // namespace banded
