#include "arm.hpp"

#include <algorithm>
#include <cmath>

namespace proof {

void Arm::place(const double* positions, Pose* poses) const {
  poses[0] = Pose{};
  for (size_t number = 1; number < joints.size(); ++number) {
    const Joint& joint = joints[number];
    const Vec& n = joint.axis;
    const double q = positions[number - 1];
    Pose moved;
    if (joint.revolute) {
      // Rodrigues' formula.
      const double s = std::sin(q), c = std::cos(q);
      Mat cross;
      cross << 0.0, -n.z(), n.y(), n.z(), 0.0, -n.x(), -n.y(), n.x(), 0.0;
      moved.R = c * Mat::Identity() + s * cross + (1.0 - c) * n * n.transpose();
    } else {
      moved.p = q * n;
    }
    poses[number] = poses[joint.parent] * (joint.in_parent * moved);
  }
}

std::vector<int> Arm::chain(int joint) const {
  std::vector<int> found;
  for (; joint > 0; joint = joints[joint].parent) found.push_back(joint);
  return found;
}

std::vector<int> Arm::relative_chain(int joint, int reference) const {
  const int meet = shared(joint, reference);
  std::vector<int> mine, theirs;
  for (; joint != meet; joint = joints[joint].parent) mine.push_back(joint);
  for (; reference != meet; reference = joints[reference].parent) theirs.push_back(reference);
  mine.insert(mine.end(), theirs.rbegin(), theirs.rend());
  return mine;
}

int Arm::shared(int one, int other) const {
  // Parents come before children, so the larger of two different numbers cannot carry the other.
  while (one != other) (one > other ? one : other) = joints[std::max(one, other)].parent;
  return one;
}

}  // namespace proof
