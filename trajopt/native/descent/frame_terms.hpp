// Terms of one frame as it is seen from another: components, and their derivatives by a sample's configuration.
//
// The formulas are those of trajopt/optimise/terms, which these are tested against; what each is for is said there.
#pragma once

#include <memory>
#include <vector>

#include "../robot_query.hpp"

namespace descent {

using robot::Matrix3, robot::Rates, robot::Seen, robot::Vector3;
using Rate = Eigen::RowVectorXd;

// The components of a term at one sample; a term may have only some of them there.
class Components {
 public:
  struct Component {
    int number;
    double value;
    Rate rate;
  };

  void clear() { all_.clear(); }
  void add(int number, double value, Rate rate) { all_.push_back({number, value, std::move(rate)}); }
  auto begin() const { return all_.begin(); }
  auto end() const { return all_.end(); }

 private:
  std::vector<Component> all_;
};

class FrameTerm {
 public:
  virtual ~FrameTerm() = default;
  virtual int components() const = 0;  // at most
  virtual void evaluate(const Seen& seen, Components& found) const = 0;
};

// The angle between an axis of the frame and a direction; `across` is a unit vector across the direction.
struct AxisAngle : FrameTerm {
  Vector3 axis, direction, across;

  int components() const override { return 1; }
  void evaluate(const Seen& seen, Components& found) const override;
};

// Position along the axes of a placement, and rotation from it as a vector or as intrinsic x-y-z angles.
struct FramePlacement : FrameTerm {
  Matrix3 rotation;
  Vector3 translation;
  bool euler;

  int components() const override { return 6; }
  void evaluate(const Seen& seen, Components& found) const override;
};

// The point from another one of the reference, and the distance.
struct PointDistance : FrameTerm {
  Vector3 from;

  int components() const override { return 4; }
  void evaluate(const Seen& seen, Components& found) const override;
};

// The angle of the point off an axis through an origin; `across` is a unit vector across the axis.
struct ViewAngle : FrameTerm {
  Vector3 origin, axis, across;

  int components() const override { return 1; }
  void evaluate(const Seen& seen, Components& found) const override;
};

// The distance of the point from an origin.
struct ViewDistance : FrameTerm {
  Vector3 origin;

  int components() const override { return 1; }
  void evaluate(const Seen& seen, Components& found) const override;
};

enum class Shape { kBox, kSphere, kCylinder, kHalfSpace };

// Coordinates of the point in the nearest of several shapes, four numbers for each.
struct PointInRegion : FrameTerm {
  struct Member {
    Shape shape;
    Vector3 size;  // half the edges; radius; radius, radius and half the length; nothing
    Matrix3 rotation;
    Vector3 translation;

    double outside(const Vector3& point) const;
  };
  std::vector<Member> members;

  int components() const override { return 4 * static_cast<int>(members.size()); }
  void evaluate(const Seen& seen, Components& found) const override;
};

}  // namespace descent
