// Clearance: every pair of parts that can move against each other keeps apart, but for those excused.
//
// Over a leaf of length h a direction n that rests with the last joint that carries both parts separates them if at both
// ends min n.y - max n.x > |n| (c + u h^2 / 8), for points x of the first part and y of the second, if c is the
// clearance, and u the sum of bounds of the accelerations of both as seen from that joint.
#pragma once

#include "arm.hpp"

namespace checker {

// A sentence if pairs are left out or a leaf cannot be one; empty if not.
std::string pairs_fault(const Statement& statement, const Witness& witness, const Arm& arm);

// Whether each leaf holds.
std::vector<bool> leaves_hold(const Statement& statement, const Witness& witness, const Arm& arm);

}  // namespace checker
