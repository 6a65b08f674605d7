// Splines as polynomials between their knots.
#pragma once

#include "table.hpp"

namespace timing {

class Polynomials {
 public:
  Polynomials() = default;

  // A B-spline whose end knots are repeated `degree` times more: `knots` increasing, knots + degree - 1 control rows.
  // Source: de Boor, A Practical Guide to Splines, 2001, chapters IX and X.
  Polynomials(Numbers knots, const Table& control, std::size_t degree)
      : knots_(std::move(knots)), columns_(control.columns), powers_(degree + 1) {
    const std::size_t pieces = knots_.size() - 1;
    coefficients_.resize(pieces * powers_ * columns_);
    const auto knot = [&](std::size_t i) {  // with the repeated ones
      return knots_[i < degree ? 0 : std::min(i - degree, pieces)];
    };
    Numbers local(powers_), value(powers_);
    for (std::size_t piece = 0; piece < pieces; ++piece) {
      const std::size_t last = piece + degree;  // place of the piece's first knot among all, and of its last control
      for (std::size_t column = 0; column < columns_; ++column) {
        for (std::size_t i = 0; i <= degree; ++i) local[i] = control[piece + i][column];
        double factorial = 1.0;
        for (std::size_t order = 0; order <= degree; ++order) {
          const std::size_t left = degree - order;
          // The derivative's value at the first knot, by de Boor's triangle.
          std::copy(local.begin() + order, local.end(), value.begin() + order);
          for (std::size_t level = 1; level <= left; ++level) {
            for (std::size_t i = degree; i >= order + level; --i) {
              const double begin = knot(piece + i), end = knot(piece + i + left - level + 1);
              const double part = (knot(last) - begin) / (end - begin);
              value[i] += (1.0 - part) * (value[i - 1] - value[i]);
            }
          }
          factorial *= order > 1 ? static_cast<double>(order) : 1.0;
          at(piece, order, column) = value[degree] / factorial;
          // Control values of the next derivative.
          for (std::size_t i = degree; i > order; --i) {
            const double width = knot(piece + i + left) - knot(piece + i);
            local[i] = static_cast<double>(left) * (local[i] - local[i - 1]) / width;
          }
        }
      }
    }
  }

  // A cubic through points with slopes.
  static Polynomials hermite(const Numbers& knots, const Numbers& value, const Numbers& slope) {
    Polynomials made;
    made.knots_ = knots, made.columns_ = 1, made.powers_ = 4;
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
      const double width = knots[i + 1] - knots[i], mean = (value[i + 1] - value[i]) / width;
      const double bend = (slope[i] + slope[i + 1] - 2.0 * mean) / width;
      made.coefficients_.insert(made.coefficients_.end(),
                                {value[i], slope[i], (mean - slope[i]) / width - bend, bend / width});
    }
    return made;
  }

  // The integral from the first knot.
  Polynomials integral() const {
    Polynomials made;
    made.knots_ = knots_, made.columns_ = columns_, made.powers_ = powers_ + 1;
    const std::size_t pieces = knots_.size() - 1;
    made.coefficients_.resize(pieces * made.powers_ * columns_);
    Numbers until(columns_, 0.0);
    for (std::size_t piece = 0; piece < pieces; ++piece) {
      for (std::size_t column = 0; column < columns_; ++column) {
        made.at(piece, 0, column) = until[column];
        for (std::size_t power = 0; power < powers_; ++power)
          made.at(piece, power + 1, column) =
              coefficients_[(piece * powers_ + power) * columns_ + column] / static_cast<double>(power + 1);
      }
      made.of_piece(piece, knots_[piece + 1] - knots_[piece], 0, until.data());
    }
    return made;
  }

  // The value and the first derivatives at an argument, a row for each order; beyond the ends by the first or the last
  // polynomial.
  void operator()(double argument, std::size_t orders, double* values) const {
    const auto inner = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, argument);
    const std::size_t piece = inner - knots_.begin() - 1;
    of_piece(piece, argument - knots_[piece], orders, values);
  }

  double operator()(double argument) const {
    double value;
    (*this)(argument, 0, &value);
    return value;
  }

 private:
  double& at(std::size_t piece, std::size_t power, std::size_t column) {
    return coefficients_[(piece * powers_ + power) * columns_ + column];
  }

  // Horner's rule, for all derivatives at once.
  void of_piece(std::size_t piece, double since, std::size_t orders, double* values) const {
    std::fill(values, values + (orders + 1) * columns_, 0.0);
    for (std::size_t power = powers_; power-- > 0;) {
      const double* coefficient = coefficients_.data() + (piece * powers_ + power) * columns_;
      for (std::size_t order = orders; order > 0; --order) {
        double *here = values + order * columns_, *below = here - columns_;
        for (std::size_t column = 0; column < columns_; ++column) here[column] = here[column] * since + below[column];
      }
      for (std::size_t column = 0; column < columns_; ++column)
        values[column] = values[column] * since + coefficient[column];
    }
    double factorial = 1.0;
    for (std::size_t order = 2; order <= orders; ++order) {
      factorial *= static_cast<double>(order);
      for (std::size_t column = 0; column < columns_; ++column) values[order * columns_ + column] *= factorial;
    }
  }

  Numbers knots_;
  std::size_t columns_ = 0, powers_ = 0;
  Numbers coefficients_;  // of the argument since the first knot of each piece, (pieces, powers, columns)
};

}  // namespace timing
