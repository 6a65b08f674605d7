// Torques by Newton's and Euler's equations: within their second derivative times h^2/8 of their chord in each cell.
//
// All vectors are along the axes of their own joint's frame. Source: Luh, Walker and Paul, On-line computational scheme
// for mechanical manipulators, 1980.
#pragma once

#include "arm.hpp"

namespace checker {

// A rigid body that a joint carries: moments of inertia about its centre of mass, along the joint's axes.
struct Load {
  int joint = 0;
  double mass = 0.0;
  Vec centre;
  std::array<double, 6> moments{};  // xx, xy, xz, yy, yz, zz
};

struct Masses {
  Vec gravity;
  std::vector<Load> loads;
  std::vector<double> rotors;                 // inertia of the motor of each joint
  std::vector<std::pair<int, double>> limits;  // of coordinates
};

// The first cell in which a limit is not shown, or SHOWN.
int torque_unshown(const Statement& statement, const Masses& masses, const Arm& arm);

}  // namespace checker
