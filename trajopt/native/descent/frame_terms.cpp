#include "frame_terms.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace descent {

namespace {

constexpr double kNoLength = 1e-12;     // a shorter vector has no direction
constexpr double kSmallAngle = 1e-4;    // with such a sine an axis is not read from the skew part of a rotation
constexpr double kTooNear = 1e-6;       // the direction of a point that is nearer means nothing [m]

// The rate of a vector's length; along its first axis where it has none, or nothing.
template <class Vector, class Rates>
Rate rate_of_length(const Vector& vector, const Rates& rates, double length, bool aside) {
  if (aside && length < kNoLength) return rates.row(0);
  return (vector / std::max(length, kNoLength)).transpose() * rates;
}

Matrix3 crossing(const Vector3& v) {
  Matrix3 matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

// log R where it turns by half a turn, nearly.
Vector3 half_turn(const Matrix3& rotation) {
  Eigen::Quaterniond turn(rotation);
  if (turn.w() < 0.0) turn.coeffs() *= -1.0;
  const double length = turn.vec().norm();
  return turn.vec() / length * (2.0 * std::atan2(length, turn.w()));
}

// log R, and its rate by the angular velocity in the frame.
Vector3 rotation_vector(const Matrix3& rotation, Matrix3& rate) {
  const Matrix3 difference = rotation - rotation.transpose();
  const double sine = 0.5 * std::sqrt(0.5 * difference.squaredNorm()), cosine = 0.5 * (rotation.trace() - 1.0);
  const double angle = std::atan2(sine, cosine);
  const double ratio = sine < kSmallAngle ? 1.0 : angle / sine;
  Matrix3 skew = 0.5 * ratio * difference;
  if (sine < kSmallAngle && cosine < 0.0) skew = crossing(half_turn(rotation));
  const double factor =
      angle < kSmallAngle ? 1.0 / 12.0 : (1.0 - 0.5 * angle / std::tan(0.5 * angle)) / (angle * angle);
  rate = Matrix3::Identity() + 0.5 * skew + factor * (skew * skew);
  return {skew(2, 1), skew(0, 2), skew(1, 0)};
}

// Angles of R = Rx(a) Ry(b) Rz(c), and their rate by the angular velocity in the frame.
Vector3 euler_angles(const Matrix3& rotation, Matrix3& rate) {
  const double a = std::atan2(-rotation(1, 2), rotation(2, 2));
  const double b = std::asin(std::clamp(rotation(0, 2), -1.0, 1.0));
  const double c = std::atan2(-rotation(0, 1), rotation(0, 0));
  const double cos_b = std::max(std::cos(b), 1e-6), tan_b = std::sin(b) / cos_b;
  const double cos_c = std::cos(c), sin_c = std::sin(c);
  rate << cos_c / cos_b, -sin_c / cos_b, 0.0, sin_c, cos_c, 0.0, -cos_c * tan_b, sin_c * tan_b, 1.0;
  return {a, b, c};
}

}  // namespace

void AxisAngle::evaluate(const Seen& seen, Components& found) const {
  const Vector3 turned = seen.rotation * axis, cross = turned.cross(direction);
  const double sine = cross.norm(), cosine = turned.dot(direction);
  const Vector3 about = sine < 1e-9 && cosine < 0.0 ? across : Vector3(cross / std::max(sine, 1e-9));
  found.add(0, std::atan2(sine, cosine), -about.transpose() * seen.spin);
}

void FramePlacement::evaluate(const Seen& seen, Components& found) const {
  const Matrix3 turned = rotation.transpose() * seen.rotation;
  Matrix3 by_spin;
  const Vector3 angles = euler ? euler_angles(turned, by_spin) : rotation_vector(turned, by_spin);
  const Vector3 off = rotation.transpose() * (seen.point - translation);
  const Rates moved = rotation.transpose() * seen.point_rate;
  const Rates rates = (by_spin * seen.rotation.transpose()) * seen.spin;
  for (int k = 0; k < 3; ++k) found.add(k, off[k], moved.row(k));
  for (int k = 0; k < 3; ++k) found.add(3 + k, angles[k], rates.row(k));
}

void PointDistance::evaluate(const Seen& seen, Components& found) const {
  const Vector3 apart = seen.point - from;
  const double distance = apart.norm();
  for (int k = 0; k < 3; ++k) found.add(k, apart[k], seen.point_rate.row(k));
  found.add(3, distance, rate_of_length(apart, seen.point_rate, distance, true));
}

void ViewAngle::evaluate(const Seen& seen, Components& found) const {
  const Vector3 point = seen.point - origin;
  const double ahead = point.dot(axis);
  const Vector3 aside = point - ahead * axis;
  const double sine = aside.norm(), angle = std::atan2(sine, ahead);
  const double distance = std::max(point.norm(), kTooNear);
  const bool behind = sine < 1e-9 * distance && ahead < 0.0;
  const Vector3 unit = behind ? across : Vector3(aside / std::max(sine, kNoLength));
  const Vector3 slope = (std::cos(angle) * unit - std::sin(angle) * axis) / distance;
  found.add(0, angle, slope.transpose() * seen.point_rate);
}

void ViewDistance::evaluate(const Seen& seen, Components& found) const {
  const Vector3 point = seen.point - origin;
  const double distance = point.norm();
  found.add(0, distance, rate_of_length(point, seen.point_rate, distance, true));
}

double PointInRegion::Member::outside(const Vector3& point) const {
  Vector3 over = point.cwiseAbs() - size;
  switch (shape) {
    case Shape::kSphere: return point.norm() - size.x();
    case Shape::kHalfSpace: return point.z();
    case Shape::kCylinder: over.head<2>().setConstant(std::hypot(point.x(), point.y()) - size.x()); break;
    case Shape::kBox: return over.cwiseMax(0.0).norm() + std::min(over.maxCoeff(), 0.0);
  }
  return Eigen::Vector2d(over.tail<2>()).cwiseMax(0.0).norm() + std::min(over.maxCoeff(), 0.0);
}

void PointInRegion::evaluate(const Seen& seen, Components& found) const {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t number = 0; number < members.size(); ++number) {
    const Member& member = members[number];
    const double outside = member.outside(member.rotation.transpose() * (seen.point - member.translation));
    if (outside < least) least = outside, nearest = number;
  }
  const Member& member = members[nearest];
  const Vector3 point = member.rotation.transpose() * (seen.point - member.translation);
  const Rates rate = member.rotation.transpose() * seen.point_rate;
  int number = 4 * static_cast<int>(nearest);
  const auto along = [&](int k) { found.add(number++, point[k], rate.row(k)); };
  switch (member.shape) {
    case Shape::kHalfSpace: along(2); return;
    case Shape::kCylinder: {
      along(0), along(1);
      const double radius = point.head<2>().norm();
      found.add(number++, radius, rate_of_length(point.head<2>(), rate.topRows<2>(), radius, false));
      along(2);
      return;
    }
    case Shape::kBox: along(0), along(1), along(2); return;
    case Shape::kSphere: {
      along(0), along(1), along(2);
      const double radius = point.norm();
      found.add(number, radius, rate_of_length(point, rate, radius, false));
    }
  }
}

}  // namespace descent
