// The judge's own forward kinematics: a tree of joints that turn about or slide along one axis.
#pragma once

#include <vector>

#include "pose.hpp"

namespace proof {

struct Joint {
  int parent;
  bool revolute;
  Vec axis;     // Unit axis in the joint's own frame.
  Pose in_parent;  // Of the joint at position zero in its parent's frame.
};

struct Arm {
  std::vector<Joint> joints;  // The first is the world; parents come before children.

  // Poses of all joint frames in the world, for one position of each joint but the world.
  void place(const double* positions, Pose* poses) const;
  // A joint and those it hangs on, outermost first, without the world.
  std::vector<int> chain(int joint) const;
  // Joints by which one frame moves as seen from another: the first one's own, outermost first, then the other's,
  // innermost first.
  std::vector<int> relative_chain(int joint, int reference) const;
  // Innermost frame that carries both.
  int shared(int one, int other) const;
};

}  // namespace proof
