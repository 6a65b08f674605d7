#include "bodies.hpp"

#include <algorithm>
#include <utility>

namespace proof {

Bodies::Bodies(Arm given, std::vector<Body> all, const int64_t* first, const int64_t* second, size_t count)
    : arm(std::move(given)), bodies(std::move(all)), numbers_(bodies.size() * arm.joints.size(), -1) {
  pairs.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    Pair pair{};
    pair.first = int(first[i]), pair.second = int(second[i]);
    const Body &one = bodies[pair.first], &other = bodies[pair.second];
    const bool first_plane = one.form->kind == Kind::Plane, second_plane = other.form->kind == Kind::Plane;
    pair.planar = first_plane || second_plane;
    pair.meshed = !pair.planar && (one.form->kind == Kind::Mesh || other.form->kind == Kind::Mesh);
    // A half-space has no bound of its own: the other body is moved as seen from it.
    pair.frame = first_plane ? one.joint : second_plane ? other.joint : arm.shared(one.joint, other.joint);
    pair.first_seen = traveller(pair.first, pair.frame);
    pair.second_seen = traveller(pair.second, pair.frame);
    pairs.push_back(pair);
  }
}

int Bodies::traveller(int body, int frame) {
  int& number = numbers_[key(body, frame)];
  if (number < 0) {
    number = int(travellers.size());
    travellers.push_back({body, frame, arm.relative_chain(bodies[body].joint, frame)});
  }
  return number;
}

Snapshot::Snapshot(const Bodies& bodies, double when, const double* positions)
    : time(when), bodies_(bodies), joints_(bodies.arm.joints.size()) {
  bodies.arm.place(positions, joints_.data());
  seen_.resize(bodies.travellers.size());
  seen_known_.assign(bodies.travellers.size(), 0);
  centres_.resize(bodies.bodies.size());
  centre_known_.assign(bodies.bodies.size(), 0);
}

Snapshot::Snapshot(const Bodies& bodies, std::vector<Pose> joints)
    : bodies_(bodies), joints_(std::move(joints)), seen_(bodies.travellers.size()),
      centres_(bodies.bodies.size()), seen_known_(bodies.travellers.size(), 0),
      centre_known_(bodies.bodies.size(), 0) {}

const Pose& Snapshot::seen(int number) {
  if (!seen_known_[number]) {
    const Traveller& traveller = bodies_.travellers[number];
    const Body& body = bodies_.bodies[traveller.body];
    if (body.joint == traveller.frame) {
      seen_[number] = body.in_joint;
    } else if (traveller.frame == 0) {
      seen_[number] = joints_[body.joint] * body.in_joint;
    } else {
      seen_[number] = joints_[traveller.frame].inverse() * joints_[body.joint] * body.in_joint;
    }
    seen_known_[number] = 1;
  }
  return seen_[number];
}

const Vec& Snapshot::centre(int number) {
  if (!centre_known_[number]) {
    const Body& body = bodies_.bodies[number];
    centres_[number] = joints_[body.joint] * (body.in_joint * body.form->centre);
    centre_known_[number] = 1;
  }
  return centres_[number];
}

double sphere_gap(const Bodies& bodies, Snapshot& at, const Pair& pair) {
  const double radii = bodies.form(pair.first).radius + bodies.form(pair.second).radius;
  return (at.centre(pair.first) - at.centre(pair.second)).norm() - radii;
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
