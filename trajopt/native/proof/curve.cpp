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
constexpr int together = 4;  // Functions bounded at once.

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

Curve Curve::beside(const Curve& other) const {
  Curve result;
  result.times = times;
  for (const double time : other.times) {
    if (time > times.front() && time < times.back()) result.times.push_back(time);
  }
  std::sort(result.times.begin(), result.times.end());
  result.times.erase(std::unique(result.times.begin(), result.times.end()), result.times.end());
  result.degree = std::max(degree, other.degree);
  result.functions = functions + other.functions;
  result.coefficients.assign(size_t(result.degree + 1) * result.pieces() * result.functions, 0.0);
  refine(result, 0);
  other.refine(result, functions);
  return result;
}

void Curve::refine(Curve& finer, int column) const {
  std::array<double, most_rows> taylor;
  for (int place = 0; place < finer.pieces(); ++place) {
    const double begin = finer.times[place];
    const bool rests = begin < times.front() || begin >= times.back();
    const int piece = piece_at(begin), higher = finer.degree - degree;
    const double since = std::clamp(begin, times.front(), times.back()) - times[piece];
    for (int f = 0; f < functions; ++f) {
      for (int row = 0; row <= degree; ++row) taylor[row] = coefficient(row, piece, f);
      for (int done = 0; done < degree && since > 0.0; ++done) {
        for (int power = 1; power <= degree - done; ++power) taylor[power] += since * taylor[power - 1];
      }
      for (int row = rests ? degree : 0; row <= degree; ++row) {
        finer.coefficients[(size_t(higher + row) * finer.pieces() + place) * finer.functions + column + f] = taylor[row];
      }
    }
  }
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

template <int lanes>
Curve::Controls<lanes> Curve::controls(int piece, int function, double left, double width) const {
  Controls<lanes> taylor{}, values{};
  const int some = std::min(lanes, functions - function);
  for (int row = 0; row <= degree; ++row) {
    for (int lane = 0; lane < some; ++lane) taylor[row][lane] = coefficient(row, piece, function + lane);
  }
  for (int done = 0; done < degree && left > 0.0; ++done) {
    for (int power = 1; power <= degree - done; ++power) {
      for (int lane = 0; lane < lanes; ++lane) taylor[power][lane] += left * taylor[power - 1][lane];
    }
  }
  // taylor[degree - k] belongs to power k; a control value is the sum of scaled powers up to its own number.
  double scale = 1.0;
  for (int k = 0; k <= degree; ++k, scale *= width) {
    const double share = scale / binomials[degree][k];
    for (int lane = 0; lane < lanes; ++lane) taylor[degree - k][lane] *= share;
  }
  for (int row = 0; row <= degree; ++row) {
    for (int k = 0; k <= row; ++k) {
      for (int lane = 0; lane < lanes; ++lane) values[row][lane] += binomials[row][k] * taylor[degree - k][lane];
    }
  }
  return values;
}

void Curve::range(double begin, double end, double* low, double* high) const {
  std::fill(low, low + functions, std::numeric_limits<double>::infinity());
  std::fill(high, high + functions, -std::numeric_limits<double>::infinity());
  const int first = piece_at(begin);
  for (int piece = first; piece < pieces() && (times[piece] < end || piece == first); ++piece) {
    const double left = std::max(begin, times[piece]) - times[piece];
    const double width = std::max(std::min(end, times[piece + 1]) - times[piece] - left, 0.0);
    for (int f = 0; f < functions; f += together) {
      const auto values = controls<together>(piece, f, left, width);
      const int some = std::min(together, functions - f);
      for (int row = 0; row <= degree; ++row) {
        for (int lane = 0; lane < some; ++lane) {
          low[f + lane] = std::min(low[f + lane], values[row][lane]);
          high[f + lane] = std::max(high[f + lane], values[row][lane]);
        }
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
    const auto values = controls<1>(piece, function, 0.0, s.width);
    for (int row = 0; row <= degree; ++row) s.control[row] = sign * values[row][0];
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
      const auto values = controls<1>(piece, f, 0.0, first.width);
      for (int row = 0; row <= degree; ++row) first.control[row] = values[row][0];
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
