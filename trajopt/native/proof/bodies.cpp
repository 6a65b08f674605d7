#include "bodies.hpp"

#include <algorithm>
#include <utility>

namespace proof {

namespace {

std::vector<Pose> frames(const Arm& arm, const double* positions) {
  std::vector<Pose> joints(arm.joints.size());
  arm.place(positions, joints.data());
  return joints;
}

}  // namespace

Bodies::Bodies(Arm given, std::vector<Body> all, const int64_t* first, const int64_t* second, const double* required,
               size_t count)
    : arm(std::move(given)), bodies(std::move(all)), levels(required, required + count),
      numbers_(bodies.size() * arm.joints.size(), -1) {
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  pairs.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    Pair pair{};
    pair.first = int(first[i]), pair.second = int(second[i]);
    const Body &one = bodies[pair.first], &other = bodies[pair.second];
    const bool first_plane = one.form->kind == Kind::Plane, second_plane = other.form->kind == Kind::Plane;
    pair.planar = first_plane || second_plane;
    pair.meshed = !pair.planar && (one.form->kind == Kind::Mesh || other.form->kind == Kind::Mesh);
    pair.clouded = !pair.planar && (one.form->points != nullptr || other.form->points != nullptr);
    // A half-space has no bound of its own: the other body is moved as seen from it.
    pair.frame = first_plane ? one.joint : second_plane ? other.joint : arm.shared(one.joint, other.joint);
    pair.first_seen = traveller(pair.first, pair.frame);
    pair.second_seen = traveller(pair.second, pair.frame);
    pair.radii = one.form->radius + other.form->radius;
    pair.required = required[i];
    pair.level = int(std::lower_bound(levels.begin(), levels.end(), required[i]) - levels.begin());
    pairs.push_back(pair);
  }
}

int Bodies::traveller(int body, int frame) {
  int& number = numbers_[key(body, frame)];
  if (number < 0) {
    number = int(travellers.size());
    std::vector<int> chain = arm.relative_chain(bodies[body].joint, frame);
    const int slot = chain.empty() ? -1 : int(moving++);
    travellers.push_back({body, frame, std::move(chain), slot});
  }
  return number;
}

Snapshot::Snapshot(const Bodies& bodies, double when, const double* positions)
    : Snapshot(bodies, when, frames(bodies.arm, positions)) {}

Snapshot::Snapshot(const Bodies& bodies, double when, std::vector<Pose> joints)
    : time(when), bodies_(bodies), joints_(std::move(joints)), seen_(bodies.moving), known_(bodies.moving, 0) {
  centres_.reserve(bodies.bodies.size());
  for (const Body& body : bodies.bodies) {
    centres_.push_back(body.joint == 0 ? body.centre : joints_[body.joint] * body.centre);
  }
}

const Pose& Snapshot::seen(int number) {
  const Traveller& traveller = bodies_.travellers[number];
  const Body& body = bodies_.bodies[traveller.body];
  if (traveller.rests()) return body.in_joint;
  if (!known_[traveller.slot]) {
    Pose& seen = seen_[traveller.slot];
    if (traveller.frame == 0) {
      seen = joints_[body.joint] * body.in_joint;
    } else {
      seen = joints_[traveller.frame].inverse() * joints_[body.joint] * body.in_joint;
    }
    known_[traveller.slot] = 1;
  }
  return seen_[traveller.slot];
}

double sphere_gap(Snapshot& at, const Pair& pair) {
  return (at.centre(pair.first) - at.centre(pair.second)).norm() - pair.radii - pair.error.at(at.time);
}

double sphere_gap(const Bodies& bodies, Snapshot& early, Snapshot& late, const Pair& pair) {
  const Form &first = bodies.form(pair.first), &second = bodies.form(pair.second);
  auto between = [&](Snapshot& at) -> Vec {
    return at.seen(pair.second_seen) * second.centre - at.seen(pair.first_seen) * first.centre;
  };
  const Vec start = between(early), way = between(late) - start;
  const double length = way.squaredNorm();
  const double share = length > 0.0 ? std::clamp(-start.dot(way) / length, 0.0, 1.0) : 0.0;
  return (start + share * way).norm() - first.radius - second.radius;
}

}  // namespace proof
