#include "motion.hpp"

#include <algorithm>

namespace checker {
namespace {

// The coefficients of a polynomial of Bernstein over the unit interval.
struct Polynomial {
  std::array<Ball, 6> coefficient;
  int degree = 0;
};

// A polynomial and its derivatives up to the fourth, in one piece of a curve.
using Orders = std::array<Polynomial, 5>;

// The length of a piece, and what all its coordinates take from it.
struct Piece {
  int number = -1;
  Ball length, inverse;
  Piece() = default;
  Piece(const Curve& curve, int number)
      : number(number), length(Ball{curve.times[number + 1]} - Ball{curve.times[number]}), inverse(Ball{1.0} / length) {}
};

void derive(const Polynomial& of, Ball inverse, Polynomial& found) {
  found.degree = std::max(of.degree - 1, 0);
  const Ball scale = Ball{static_cast<double>(of.degree)} * inverse;
  found.coefficient[0] = Ball{};
  for (int at = 0; at < of.degree; ++at)
    found.coefficient[at] = (of.coefficient[at + 1] - of.coefficient[at]) * scale;
}

void read_orders(const Curve& curve, const Piece& piece, int column, Orders& found) {
  const auto stated = [&](int order, int knot) { return Ball{curve.values[order][(piece.number + knot) * curve.count() + column]}; };
  const int degree = 2 * static_cast<int>(curve.values.size()) - 1;
  const Ball p = stated(0, 0), q = stated(0, 1), v = stated(1, 0), w = stated(1, 1), h = piece.length;
  const Ball slope = (q - p) * (Ball{static_cast<double>(degree)} * piece.inverse);
  auto& [position, velocity, acceleration, jerk, fourth] = found;
  velocity.degree = degree - 1;
  if (degree == 3) {
    velocity.coefficient = {v, slope - v - w, w};
  } else {
    const Ball quarter = h * Ball{0.25};
    const Ball after = v + stated(2, 0) * quarter, before = w - stated(2, 1) * quarter;
    // The mean of the velocity's coefficients is the mean velocity.
    velocity.coefficient = {v, after, slope - v - after - before - w, before, w};
  }
  position.degree = degree;
  const Ball step = h * (Ball{1.0} / Ball{static_cast<double>(degree)});
  position.coefficient[0] = p;
  for (int at = 1; at < degree; ++at)
    position.coefficient[at] = position.coefficient[at - 1] + velocity.coefficient[at - 1] * step;
  position.coefficient[degree] = q;
  derive(velocity, piece.inverse, acceleration);
  derive(acceleration, piece.inverse, jerk);
  derive(jerk, piece.inverse, fourth);
}

// The coefficients over a part of the unit interval, by de Casteljau's algorithm.
//
// It takes means with weights in [0, 1], so radii of coefficients do not grow. Each of at most 10 of them adds 3 U of
// the largest coefficient for its rounding, and 2 of that times the error of the weight, below 8 U.
Polynomial restricted(Polynomial of, double begin, double end) {
  double radius = 0.0, most = 0.0;
  for (int at = 0; at <= of.degree; ++at) {
    radius = larger(radius, of.coefficient[at].r);
    most = larger(most, of.coefficient[at].size());
  }
  const auto mean = [](double one, double other, double weight) { return (1.0 - weight) * one + weight * other; };
  for (int level = 1; level <= of.degree; ++level)
    for (int at = of.degree; at >= level; --at)
      of.coefficient[at].c = mean(of.coefficient[at - 1].c, of.coefficient[at].c, end);
  for (int level = 1; level <= of.degree; ++level)
    for (int at = 0; at <= of.degree - level; ++at)
      of.coefficient[at].c = mean(of.coefficient[at].c, of.coefficient[at + 1].c, begin / end);
  for (int at = 0; at <= of.degree; ++at) of.coefficient[at].r = grown(radius + 256.0 * U * most);
  return of;
}

void include(Motion& motion, const Orders& orders, int cell, int column, double begin, double end) {
  const int at = cell * motion.count + column, next = at + motion.count;
  for (int order = 0; order < 5; ++order) {
    const bool whole = begin == 0.0 && end == 1.0;
    Polynomial cut;
    if (!whole) cut = restricted(orders[order], begin, end);
    const Polynomial& part = whole ? orders[order] : cut;
    // A centre that is not a number has such a radius, which remains.
    auto [low, radius] = part.coefficient[0];
    double high = low;
    for (int place = 1; place <= part.degree; ++place) {
      const auto [c, r] = part.coefficient[place];
      low = std::min(low, c), high = std::max(high, c), radius = larger(radius, r);
    }
    motion.bounds[order][at] = {down(low - radius), up(high + radius)};
    const Ball first = part.coefficient[0], last = part.coefficient[part.degree];
    if (order == 2) motion.accelerations[0][at] = first, motion.accelerations[1][at] = last;
    if (order > 1) continue;
    // Drives may differ before and after a time.
    auto& values = order == 0 ? motion.positions : motion.velocities;
    Range both;
    both.include(first);
    if (cell) both.include(values[at]);
    values[at] = !cell || (first.c == values[at].c && first.r == values[at].r) ? first : both.ball();
    values[next] = last;
  }
}

}  // namespace

Motion motion_on(const Statement& statement, const std::vector<double>& grid) {
  Motion motion;
  std::vector<const Curve*> curves{&statement.curve};
  for (const Curve& drive : statement.drives) curves.push_back(&drive);
  for (const Curve* curve : curves) motion.count += curve->count();
  const std::size_t cells = grid.size() - 1, size = cells * motion.count;
  motion.positions.resize(size + motion.count), motion.velocities.resize(size + motion.count);
  for (auto& bounds : motion.bounds) bounds.resize(size);
  for (auto& side : motion.accelerations) side.resize(size);
  int first = 0;
  for (const Curve* curve : curves) {
    const auto& times = curve->times;
    std::vector<Orders> orders(curve->count());
    Piece piece;
    for (std::size_t cell = 0; cell < cells; ++cell) {
      const int here = static_cast<int>(std::upper_bound(times.begin(), times.end(), grid[cell]) - times.begin()) - 1;
      if (here != piece.number) {
        piece = Piece(*curve, here);
        for (int column = 0; column < curve->count(); ++column) read_orders(*curve, piece, column, orders[column]);
      }
      const double length = times[here + 1] - times[here];
      const double begin = (grid[cell] - times[here]) / length, end = (grid[cell + 1] - times[here]) / length;
      for (int column = 0; column < curve->count(); ++column)
        include(motion, orders[column], static_cast<int>(cell), first + column, begin, end);
    }
    first += curve->count();
  }
  return motion;
}

}  // namespace checker
