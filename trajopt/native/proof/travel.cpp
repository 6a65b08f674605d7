#include "travel.hpp"

#include <cmath>

namespace proof {

Travel travel(const Bodies& bodies, const Traveller& traveller, Snapshot& middle, const JointBounds& bounds) {
  Travel result;
  // A half-space is only ever seen from its own frame, in which it rests.
  if (traveller.rests()) return result;
  const Vec centre = middle.centre(traveller.body);
  const double radius = bodies.form(traveller.body).radius;
  double velocity = 0.0;
  for (const int number : traveller.chain) {
    const Joint& joint = bodies.arm.joints[number];
    const double w = bounds.speed[number], a = bounds.increase[number];
    if (!joint.revolute) {
      result.from_middle += bounds.moved[number];
      result.acceleration += a;
      velocity += w;
      continue;
    }
    const Pose& at = middle.joints()[number];
    const double lever = (centre - at.p).cross(at.R * joint.axis).norm() + radius + result.from_middle;
    result.from_middle += bounds.moved[number] * lever;
    result.acceleration += 2.0 * w * velocity + (w * w + a) * lever;
    velocity += w * lever;
  }
  return result;
}

}  // namespace proof
