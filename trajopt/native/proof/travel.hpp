// How far the points of a body get while joints move by bounded amounts, and how far off the chords between its
// places at both ends of an interval.
//
// Travel: Schwarzer, Saha, Latombe, Adaptive dynamic collision checking for single and multiple robots in motion,
// IEEE T-RO 2005. With r the largest distance of the body from the axis of a joint that turns at a rate up to w and
// accelerates by up to a, the speed v and acceleration u of its points as seen from behind the joint are at most
// v + w r and u + 2 w v + w^2 r + a r. A path with an acceleration up to u is off its chord by at most u h^2 / 8.
#pragma once

#include "bodies.hpp"

namespace proof {

// Bounds over an interval, one for each joint; the world's is zero.
struct JointBounds {
  std::vector<double> moved;     // From the middle [rad | m].
  std::vector<double> speed;     // [rad/s | m/s]
  std::vector<double> increase;  // Acceleration [rad/s^2 | m/s^2].
};

struct Travel {
  double from_middle = 0.0;   // Of any point of the body from its place in the middle of the interval [m].
  double acceleration = 0.0;  // Of any point, as seen from the traveller's frame [m/s^2].
};

Travel travel(const Bodies& bodies, const Traveller& traveller, Snapshot& middle, const JointBounds& bounds);

}  // namespace proof
