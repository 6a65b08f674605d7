#include "rows.hpp"

#include <cmath>

namespace descent {

namespace {

// The larger of two numbers; unlike std::max not a number where either is none.
double larger(double a, double b) { return std::isnan(a) || a > b ? a : b; }

double loss(Kind kind, double value) {
  switch (kind) {
    case Kind::kSquared: return value * value;
    case Kind::kAbsolute: return std::abs(value);
    default: return larger(value, 0.0);
  }
}

}  // namespace

double Rows::cost(Kind kind) const {
  double sum = 0.0;
  for (int row = 0; row < count(); ++row) sum += weight[row] * loss(kind, value[row]);
  return sum;
}

double Rows::violation(int row) const {
  return larger(larger(lower[row] - value[row], value[row] - upper[row]), 0.0);
}

}  // namespace descent
