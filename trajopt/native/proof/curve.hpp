// Piecewise polynomials of time, with bounds that hold at every time.
//
// In Bernstein form a polynomial lies between its smallest and its largest control value. Source: Farouki, The
// Bernstein polynomial basis: a centennial retrospective, CAGD 2012.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace proof {

struct Curve {
  static constexpr int highest_degree = 7;

  std::vector<double> times;         // Breakpoints, increasing.
  std::vector<double> coefficients;  // (degree + 1, pieces, functions), highest power first.
  int degree = 0, functions = 0;

  int pieces() const { return int(times.size()) - 1; }
  double coefficient(int row, int piece, int function) const {
    return coefficients[(std::size_t(row) * pieces() + piece) * functions + function];
  }
  Curve derivative() const;
  // These functions and others over the times of these; the others rest outside of their own.
  Curve beside(const Curve& other) const;
  // Values of all functions.
  void evaluate(double time, double* values) const;
  // Smallest and largest control value of every function over an interval.
  void range(double begin, double end, double* low, double* high) const;
  // Largest value of one function to within `slack`, relative to the larger of it and one, and its time.
  void largest(int function, double sign, double slack, double& value, double& time) const;
  // Whether every function is proven to stay within its bounds at all times.
  bool within(const double* low, const double* high) const;
  // Whether no function jumps where pieces meet by more than is allowed, from what it is before the first piece, nor to
  // zero after the last where it has to rest.
  bool jumps_within(const double* before, bool rests_after, const double* most) const;
  // Whether a breakpoint lies inside an interval.
  bool breaks(double begin, double end) const;

 private:
  template <int lanes>
  using Controls = std::array<std::array<double, lanes>, highest_degree + 1>;

  int piece_at(double time) const;
  // Put the functions into the pieces of a finer curve, by Taylor's formula, from a column on.
  void refine(Curve& finer, int column) const;
  // Control values of some functions from one on, in a part of a piece.
  template <int lanes>
  Controls<lanes> controls(int piece, int function, double left, double width) const;
};

}  // namespace proof
