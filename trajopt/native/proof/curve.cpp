#include "curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace proof {

namespace {

constexpr int most_rows = Curve::highest_degree + 1;
constexpr int most_halvings = 50;

struct Stretch {
  std::array<double, most_rows> control;
  double begin, width;
  int halvings;
};

// De Casteljau: both halves.
std::pair<Stretch, Stretch> halves(const Stretch& s, int degree) {
  Stretch left = s, right = s;
  std::array<double, most_rows> rows = s.control;
  for (int level = 0; level <= degree; ++level) {
    left.control[level] = rows[0], right.control[degree - level] = rows[degree - level];
    for (int i = 0; i < degree - level; ++i) rows[i] = (rows[i] + rows[i + 1]) / 2.0;
  }
  left.width = right.width = s.width / 2.0;
  right.begin = s.begin + left.width;
  left.halvings = right.halvings = s.halvings + 1;
  return {left, right};
}

// binomials[n][k]: n over k.
constexpr auto binomials = [] {
  std::array<std::array<double, most_rows>, most_rows> rows{};
  for (int n = 0; n < most_rows; ++n) {
    rows[n][0] = 1.0;
    for (int k = 1; k <= n; ++k) rows[n][k] = rows[n - 1][k - 1] + (k < n ? rows[n - 1][k] : 0.0);
  }
  return rows;
}();

}  // namespace

Curve Curve::derivative() const {
  Curve result;
  result.times = times;
  result.functions = functions;
  result.degree = std::max(degree - 1, 0);
  const size_t row = size_t(pieces()) * functions;
  result.coefficients.assign(row * (result.degree + 1), 0.0);
  for (int power = degree; power > 0; --power) {
    const size_t from = row * (degree - power);
    for (size_t i = 0; i < row; ++i) result.coefficients[from + i] = power * coefficients[from + i];
  }
  return result;
}

int Curve::piece_at(double time) const {
  const auto after = std::upper_bound(times.begin(), times.end(), time);
  return std::clamp(int(after - times.begin()) - 1, 0, pieces() - 1);
}

void Curve::evaluate(double time, double* values) const {
  const int piece = piece_at(time);
  const double t = time - times[piece];
  for (int f = 0; f < functions; ++f) {
    double value = coefficient(0, piece, f);
    for (int row = 1; row <= degree; ++row) value = value * t + coefficient(row, piece, f);
    values[f] = value;
  }
}

void Curve::control(int piece, int function, double left, double width, double* values) const {
  std::array<double, most_rows> taylor;
  for (int row = 0; row <= degree; ++row) taylor[row] = coefficient(row, piece, function);
  for (int done = 0; done < degree && left > 0.0; ++done) {
    for (int power = 1; power <= degree - done; ++power) taylor[power] += left * taylor[power - 1];
  }
  // taylor[degree - k] belongs to power k; a control value is the sum of scaled powers up to its own number.
  double scale = 1.0;
  for (int k = 0; k <= degree; ++k, scale *= width) taylor[degree - k] *= scale / binomials[degree][k];
  for (int row = 0; row <= degree; ++row) {
    double sum = 0.0;
    for (int k = 0; k <= row; ++k) sum += binomials[row][k] * taylor[degree - k];
    values[row] = sum;
  }
}

void Curve::range(double begin, double end, double* low, double* high) const {
  std::fill(low, low + functions, std::numeric_limits<double>::infinity());
  std::fill(high, high + functions, -std::numeric_limits<double>::infinity());
  std::array<double, most_rows> values;
  for (int piece = piece_at(begin); piece < pieces() && (times[piece] < end || piece == piece_at(begin)); ++piece) {
    const double left = std::max(begin, times[piece]) - times[piece];
    const double width = std::max(std::min(end, times[piece + 1]) - times[piece] - left, 0.0);
    for (int f = 0; f < functions; ++f) {
      control(piece, f, left, width, values.data());
      for (int row = 0; row <= degree; ++row) {
        low[f] = std::min(low[f], values[row]), high[f] = std::max(high[f], values[row]);
      }
    }
  }
}

void Curve::largest(int function, double sign, double slack, double& value, double& time) const {
  value = -std::numeric_limits<double>::infinity();
  time = 0.0;
  std::vector<Stretch> open;
  auto take = [&](const Stretch& s) {
    if (s.control[0] > value) value = s.control[0], time = s.begin;
    if (s.control[degree] > value) value = s.control[degree], time = s.begin + s.width;
  };
  auto top = [&](const Stretch& s) {
    return *std::max_element(s.control.begin(), s.control.begin() + degree + 1);
  };
  for (int piece = 0; piece < pieces(); ++piece) {
    Stretch s{{}, times[piece], times[piece + 1] - times[piece], 0};
    control(piece, function, 0.0, s.width, s.control.data());
    for (int row = 0; row <= degree; ++row) s.control[row] *= sign;
    take(s);
    open.push_back(s);
  }
  double beyond = -std::numeric_limits<double>::infinity();
  while (!open.empty()) {
    const Stretch s = open.back();
    open.pop_back();
    if (top(s) <= value + slack * std::max(1.0, std::abs(value))) continue;
    if (s.halvings == most_halvings) {
      beyond = std::max(beyond, top(s));
      continue;
    }
    const auto [left, right] = halves(s, degree);
    take(left);
    take(right);
    open.push_back(left);
    open.push_back(right);
  }
  value = std::max(value, beyond);
}

bool Curve::within(const double* low, const double* high) const {
  std::vector<Stretch> open;
  for (int piece = 0; piece < pieces(); ++piece) {
    for (int f = 0; f < functions; ++f) {
      Stretch first{{}, times[piece], times[piece + 1] - times[piece], 0};
      // In a short piece no power of the time is far from nothing.
      double off = 0.0;
      for (int row = 0; row < degree; ++row) off = (off + std::abs(coefficient(row, piece, f))) * first.width;
      const double begin = coefficient(degree, piece, f);
      if (begin - off >= low[f] && begin + off <= high[f]) continue;
      control(piece, f, 0.0, first.width, first.control.data());
      open.assign(1, first);
      while (!open.empty()) {
        const Stretch s = open.back();
        open.pop_back();
        const auto [least, most] = std::minmax_element(s.control.begin(), s.control.begin() + degree + 1);
        if (*least >= low[f] && *most <= high[f]) continue;
        // A value at an end is taken, so no halving helps.
        const double ends[2] = {s.control[0], s.control[degree]};
        for (const double end : ends) {
          if (!(end >= low[f] && end <= high[f])) return false;
        }
        if (s.halvings == most_halvings) return false;
        const auto [left, right] = halves(s, degree);
        open.push_back(left);
        open.push_back(right);
      }
    }
  }
  return true;
}

bool Curve::jumps_within(const double* before, bool rests_after, const double* most) const {
  for (int f = 0; f < functions; ++f) {
    double reached = before[f];
    for (int piece = 0; piece < pieces(); ++piece) {
      if (!(std::abs(coefficient(degree, piece, f) - reached) <= most[f])) return false;
      const double width = times[piece + 1] - times[piece];
      reached = coefficient(0, piece, f);
      for (int row = 1; row <= degree; ++row) reached = reached * width + coefficient(row, piece, f);
    }
    if (rests_after && !(std::abs(reached) <= most[f])) return false;
  }
  return true;
}

bool Curve::breaks(double begin, double end) const {
  const auto after = std::upper_bound(times.begin(), times.end(), begin);
  return after != times.end() && *after < end;
}

}  // namespace proof
