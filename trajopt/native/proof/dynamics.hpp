// The torques that motions of a tree of joints need, by the recursive Newton-Euler algorithm in the joints' own
// frames, for several moments at once: inner loops take four numbers together.
// Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 5. Compared in tests with Pinocchio's.
#pragma once

#include <vector>

#include "arm.hpp"

namespace proof {

// What a joint carries, in its own frame; the world's counts for nothing.
struct Mass {
  double mass;      // [kg]
  Vec centre;       // Of mass [m].
  Mat inertia;      // About the centre of mass [kg m^2].
  double armature;  // Inertia of what turns the joint, as the joint feels it [kg m^2 | kg].
};

class Dynamics {
 public:
  // The rotation of the joint's frame in its parent's is `at + cos turned + sin across`, its origin
  // `origin + q along`.
  struct Link {
    int parent;  // -1 for the world.
    bool revolute;
    Mat at, turned, across, inertia;
    Vec axis, origin, along, centre;
    double mass, armature;
  };

  Dynamics(const Arm& arm, const std::vector<Mass>& masses, const Vec& gravity);

  size_t joints() const { return links_.size(); }
  // Rows of positions, velocities and accelerations of all joints but the world to rows of torques.
  void torques(size_t rows, const double* q, const double* v, const double* a, double* found) const;

 private:
  std::vector<Link> links_;
  Vec gravity_;
};

}  // namespace proof
