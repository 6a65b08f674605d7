// Numbers, vectors and rotations with a bound of their distance from the exact ones.
//
// Each sum, product, quotient and square root of IEEE 754 is within U of itself, relatively, of the exact one: Higham,
// Accuracy and Stability of Numerical Algorithms, 2002, section 2.2. A radius is a sum of a few products of numbers
// that are not negative, so its own rounding is below the factor GROWN; TINY covers underflow. A number that is not
// finite fails every comparison that it reaches, and so refuses the proof.
#pragma once

#include <array>
#include <cmath>
#include <limits>

namespace checker {

// The optimiser leaves too many of these small functions uninlined.
#define CLOSE [[gnu::always_inline]] inline

constexpr double U = 0x1p-53, GROWN = 1.0 + 0x1p-47, TINY = 1e-300;
constexpr double NOT_A_NUMBER = std::numeric_limits<double>::quiet_NaN();

inline double grown(double radius) { return radius * GROWN + TINY; }
// Bounds of a number of which a result is the nearest double.
inline double up(double value) { return value + (std::abs(value) * (4.0 * U) + TINY); }
inline double down(double value) { return value - (std::abs(value) * (4.0 * U) + TINY); }
// The larger number; not a number if one of them is not.
inline double larger(double one, double other) { return one > other || one != one ? one : other; }
inline double smaller(double one, double other) { return one < other || one != one ? one : other; }

// All numbers within a radius of a centre.
struct Ball {
  double c = 0.0, r = 0.0;
  double high() const { return up(c + r); }
  double low() const { return down(c - r); }
  double size() const { return up(std::abs(c) + r); }
};

CLOSE Ball operator+(Ball a, Ball b) {
  const double c = a.c + b.c;
  return {c, grown(a.r + b.r + U * std::abs(c))};
}
CLOSE Ball operator-(Ball a) { return {-a.c, a.r}; }
CLOSE Ball operator-(Ball a, Ball b) { return a + -b; }
CLOSE Ball operator*(Ball a, Ball b) {
  const double c = a.c * b.c;
  return {c, grown(std::abs(a.c) * b.r + a.r * (std::abs(b.c) + b.r) + U * std::abs(c))};
}
// The divisor must be positive.
CLOSE Ball operator/(Ball a, Ball b) {
  const double c = a.c / b.c, least = b.c - b.r;
  if (!(least > 0.5 * b.c)) return {NOT_A_NUMBER, NOT_A_NUMBER};
  return {c, grown((a.r + std::abs(c) * b.r) / least + U * std::abs(c))};
}

// All numbers from low to high.
struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void include(Ball value) { include(value.low(), value.high()); }
  void include(double least, double most) { low = smaller(low, least), high = larger(high, most); }
  double size() const { return larger(-low, high); }
  Ball ball() const {
    const double c = low + (high - low) / 2.0;
    return {c, up(larger(up(high - c), up(c - low)))};
  }
};

// All vectors within a radius of a centre. WIDE: of a radius that is not only rounding.
template <bool WIDE>
struct Vectors {
  double x = 0.0, y = 0.0, z = 0.0, r = 0.0;
  // Upper bounds of the length of the centre, and of all vectors.
  double middle() const { return std::sqrt(x * x + y * y + z * z) * GROWN + TINY; }
  double length() const { return grown(middle() + r); }
  double sum() const { return std::abs(x) + std::abs(y) + std::abs(z); }
  // The factor of a radius in a product: where radii are rounding, twice as much is better than a root.
  double factor() const { return WIDE ? middle() : sum(); }
};
using Vec = Vectors<false>;
using WideVec = Vectors<true>;

template <bool W>
CLOSE Vectors<W> operator-(const Vectors<W>& a) { return {-a.x, -a.y, -a.z, a.r}; }
template <bool W>
CLOSE Vectors<W> operator+(const Vectors<W>& a, const Vectors<W>& b) {
  Vectors<W> found{a.x + b.x, a.y + b.y, a.z + b.z};
  found.r = grown(a.r + b.r + U * found.sum());
  return found;
}
template <bool W>
CLOSE Vectors<W> operator-(const Vectors<W>& a, const Vectors<W>& b) { return a + -b; }
template <bool W>
CLOSE Vectors<W> operator*(const Vectors<W>& a, Ball b) {
  const double length = a.factor();
  return {a.x * b.c, a.y * b.c, a.z * b.c, grown(std::abs(b.c) * (a.r + U * length) + b.r * (length + a.r))};
}
// A component is a difference of two products: its rounding is below 3 U of their sizes, whose vector is at most twice
// as long as the product of the lengths.
template <bool W>
CLOSE Vectors<W> cross(const Vectors<W>& a, const Vectors<W>& b) {
  const double one = a.factor(), other = b.factor();
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x,
          grown(one * (b.r + 6.0 * U * other) + a.r * (other + b.r))};
}
// The rounding of a sum of three products is below 4 U of the product of the lengths.
template <bool W>
CLOSE Ball dot(const Vectors<W>& a, const Vectors<W>& b) {
  const double one = a.factor(), other = b.factor();
  return {a.x * b.x + a.y * b.y + a.z * b.z, grown(one * (b.r + 4.0 * U * other) + a.r * (other + b.r))};
}

// All rotations within a radius, by the largest singular value, of a matrix.
//
// That is itself within 1e-6 of a rotation: it is a product of at most 1,001 of them, each with the error TURN_ERROR at
// most. So the squares of its numbers add up to less than 3.1.
struct Turn {
  std::array<double, 9> m{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  double r = 0.0;
};
constexpr double TURN_ERROR = 512.0 * U;

// The exact rotation keeps lengths; rounding adds 4 U times 1.77 times the length.
template <bool W>
CLOSE Vectors<W> turned(const Turn& a, const Vectors<W>& v) {
  const auto& m = a.m;
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
          m[6] * v.x + m[7] * v.y + m[8] * v.z, grown(v.r + (a.r + 8.0 * U) * v.factor())};
}
template <bool W>
CLOSE Vectors<W> turned_back(const Turn& a, const Vectors<W>& v) {
  const auto& m = a.m;
  return {m[0] * v.x + m[3] * v.y + m[6] * v.z, m[1] * v.x + m[4] * v.y + m[7] * v.z,
          m[2] * v.x + m[5] * v.y + m[8] * v.z, grown(v.r + (a.r + 8.0 * U) * v.factor())};
}
// Rounding adds 4 U times 3.1.
inline Turn operator*(const Turn& a, const Turn& b) {
  Turn found;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      const double* of = &a.m[3 * row];
      found.m[3 * row + column] = of[0] * b.m[column] + of[1] * b.m[3 + column] + of[2] * b.m[6 + column];
    }
  found.r = grown(a.r * 1.00001 + b.r + 16.0 * U);
  return found;
}
inline Turn transposed(const Turn& a) {
  const auto& m = a.m;
  return {{m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]}, a.r};
}

// A vector divided by its length: the errors are below 8 U.
CLOSE Vec normalised(const std::array<double, 3>& v) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return {v[0] / length, v[1] / length, v[2] / length, 8.0 * U};
}

// The rotation matrix of a quaternion w, x, y, z of any length but zero (Rodrigues).
//
// The unit quaternion has an error below 8 U, the matrix one of 4 times that and below 40 U of its own rounding.
inline Turn rotation_of(const std::array<double, 4>& q) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double w = q[0] / length, x = q[1] / length, y = q[2] / length, z = q[3] / length;
  return {{1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),  //
           2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),  //
           2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)},
          128.0 * U};
}

struct SineCosine {
  double sine, cosine;
};
constexpr double WAVE_ERROR = 16.0 * U;

// Sine and cosine within WAVE_ERROR, of angles of at most 1e5 rad; not a number beyond.
//
// The multiple of pi/2 is subtracted in three parts, of which the first two have 33 bits, so that their products are
// exact: the rest, at most 0.79, has an error below 4 U. Taylor's series end with terms below U/100, and their rounding
// is below 4 U.
inline SineCosine sine_and_cosine(double angle) {
  constexpr double FIRST = 0x1.921fb544p+0, SECOND = 0x1.0b4611a6p-34, THIRD = 0x1.3198a2e037073p-69;
  if (!(std::abs(angle) <= 1e5)) return {NOT_A_NUMBER, NOT_A_NUMBER};
  const double turns = std::floor(angle * 0x1.45f306dc9c883p-1 + 0.5);
  const double x = ((angle - turns * FIRST) - turns * SECOND) - turns * THIRD, s = x * x;
  const double sine =
      x * (1.0 - s * (1.0 / 6 - s * (1.0 / 120 - s * (1.0 / 5040 - s * (1.0 / 362880 - s * (1.0 / 39916800 -
           s * (1.0 / 6227020800.0 - s * (1.0 / 1307674368000.0 - s / 355687428096000.0))))))));
  const double cosine =
      1.0 - s * (0.5 - s * (1.0 / 24 - s * (1.0 / 720 - s * (1.0 / 40320 - s * (1.0 / 3628800 - s * (1.0 / 479001600.0 -
            s * (1.0 / 87178291200.0 - s * (1.0 / 20922789888000.0 - s / 6402373705728000.0))))))));
  switch (static_cast<long>(turns) & 3) {
    case 0: return {sine, cosine};
    case 1: return {cosine, -sine};
    case 2: return {-sine, -cosine};
    default: return {-cosine, sine};
  }
}

}  // namespace checker
