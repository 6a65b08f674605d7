#include "dynamics.hpp"

#include <algorithm>
#include <cmath>

namespace proof {

namespace {

constexpr size_t lanes = 4;

// Numbers of four moments.
struct Four {
  double lane[lanes];
};

inline Four operator+(const Four& a, const Four& b) {
  Four c;
  for (size_t i = 0; i < lanes; ++i) c.lane[i] = a.lane[i] + b.lane[i];
  return c;
}
inline Four operator-(const Four& a, const Four& b) {
  Four c;
  for (size_t i = 0; i < lanes; ++i) c.lane[i] = a.lane[i] - b.lane[i];
  return c;
}
inline Four operator*(const Four& a, const Four& b) {
  Four c;
  for (size_t i = 0; i < lanes; ++i) c.lane[i] = a.lane[i] * b.lane[i];
  return c;
}
inline Four operator*(double a, const Four& b) {
  Four c;
  for (size_t i = 0; i < lanes; ++i) c.lane[i] = a * b.lane[i];
  return c;
}
inline Four operator+(double a, const Four& b) {
  Four c;
  for (size_t i = 0; i < lanes; ++i) c.lane[i] = a + b.lane[i];
  return c;
}

struct Vector {
  Four x{}, y{}, z{};
};

inline Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector scaled(const Vec& a, const Four& b) { return {a[0] * b, a[1] * b, a[2] * b}; }
inline Vector scaled(double a, const Vector& b) { return {a * b.x, a * b.y, a * b.z}; }
inline Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vector cross(const Vector& a, const Vec& b) {
  return {b[2] * a.y - b[1] * a.z, b[0] * a.z - b[2] * a.x, b[1] * a.x - b[0] * a.y};
}
inline Vector cross(const Vec& a, const Vector& b) {
  return {a[1] * b.z - a[2] * b.y, a[2] * b.x - a[0] * b.z, a[0] * b.y - a[1] * b.x};
}
inline Four dot(const Vec& a, const Vector& b) { return a[0] * b.x + a[1] * b.y + a[2] * b.z; }
inline Vector operator*(const Mat& a, const Vector& b) {
  return {dot(a.row(0), b), dot(a.row(1), b), dot(a.row(2), b)};
}

struct Rotation {
  Four of[9];  // Row by row.

  Vector times(const Vector& a) const {
    return {of[0] * a.x + of[1] * a.y + of[2] * a.z, of[3] * a.x + of[4] * a.y + of[5] * a.z,
            of[6] * a.x + of[7] * a.y + of[8] * a.z};
  }
  Vector back(const Vector& a) const {
    return {of[0] * a.x + of[3] * a.y + of[6] * a.z, of[1] * a.x + of[4] * a.y + of[7] * a.z,
            of[2] * a.x + of[5] * a.y + of[8] * a.z};
  }
};

struct State {
  Rotation rotation;
  Vector origin, turning, turned, moved, force, moment;
};

using Links = std::vector<Dynamics::Link>;

Four constant(double value) {
  Four found;
  for (double& lane : found.lane) lane = value;
  return found;
}
Vector constant(const Vec& value) { return {constant(value[0]), constant(value[1]), constant(value[2])}; }

// Place a joint's frame in its parent's.
void place(const Dynamics::Link& link, const Four& q, State& here) {
  if (!link.revolute) {
    for (int k = 0; k < 9; ++k) here.rotation.of[k] = constant(link.at(k / 3, k % 3));
    here.origin = constant(link.origin) + scaled(link.along, q);
    return;
  }
  Four cosine, sine;
  for (size_t i = 0; i < lanes; ++i) cosine.lane[i] = std::cos(q.lane[i]), sine.lane[i] = std::sin(q.lane[i]);
  for (int k = 0; k < 9; ++k) {
    const int row = k / 3, column = k % 3;
    here.rotation.of[k] = link.at(row, column) + (link.turned(row, column) * cosine + link.across(row, column) * sine);
  }
  here.origin = constant(link.origin);
}

// From the world outwards: how each link moves, and what that needs; the acceleration of gravity counts as one up.
void move(const Links& links, const Vec& gravity, const Four* q, const Four* v, const Four* a, State* states) {
  const Vector resting, up = constant(Vec(-gravity));
  for (size_t j = 0; j < links.size(); ++j) {
    const Dynamics::Link& link = links[j];
    State& here = states[j];
    place(link, q[j], here);
    const State* parent = link.parent < 0 ? nullptr : states + link.parent;
    const Vector& w = parent ? parent->turning : resting;
    const Vector& dw = parent ? parent->turned : resting;
    const Vector carried = (parent ? parent->moved : up) + cross(dw, here.origin) + cross(w, cross(w, here.origin));
    here.turning = here.rotation.back(w), here.turned = here.rotation.back(dw), here.moved = here.rotation.back(carried);
    const Vector rate = scaled(link.axis, v[j]), increase = scaled(link.axis, a[j]);
    if (link.revolute) {
      here.turned = here.turned + increase + cross(here.turning, rate);
      here.turning = here.turning + rate;
    } else {
      here.moved = here.moved + increase + scaled(2.0, cross(here.turning, rate));
    }
    const Vector lever = cross(here.turning, link.centre);
    here.force = scaled(link.mass, here.moved + cross(here.turned, link.centre) + cross(here.turning, lever));
    const Vector spin = link.inertia * here.turning;
    here.moment = link.inertia * here.turned + cross(here.turning, spin) + cross(link.centre, here.force);
  }
}

// From the outermost links inwards: what each joint has to bear.
void bear(const Links& links, const Four* a, State* states, Four* torque) {
  for (size_t j = links.size(); j-- > 0;) {
    const Dynamics::Link& link = links[j];
    const State& here = states[j];
    torque[j] = dot(link.axis, link.revolute ? here.moment : here.force) + link.armature * a[j];
    if (link.parent < 0) continue;
    State& parent = states[link.parent];
    const Vector force = here.rotation.times(here.force);
    parent.moment = parent.moment + here.rotation.times(here.moment) + cross(here.origin, force);
    parent.force = parent.force + force;
  }
}

}  // namespace

Dynamics::Dynamics(const Arm& arm, const std::vector<Mass>& masses, const Vec& gravity) : gravity_(gravity) {
  for (size_t number = 1; number < arm.joints.size(); ++number) {
    const Joint& joint = arm.joints[number];
    const Mass& mass = masses[number];
    const Vec& n = joint.axis;
    const Mat& R = joint.in_parent.R;
    Mat cross;
    cross << 0.0, -n.z(), n.y(), n.z(), 0.0, -n.x(), -n.y(), n.x(), 0.0;
    // Rodrigues' formula.
    const Mat along = n * n.transpose();
    Link link{joint.parent - 1, joint.revolute, R, Mat::Zero(), Mat::Zero(), mass.inertia, n, joint.in_parent.p,
              Vec::Zero(), mass.centre, mass.mass, mass.armature};
    if (joint.revolute) {
      link.at = R * along, link.turned = R * (Mat::Identity() - along), link.across = R * cross;
    } else {
      link.along = R * n;
    }
    links_.push_back(link);
  }
}

void Dynamics::torques(size_t rows, const double* q, const double* v, const double* a, double* found) const {
  const size_t count = links_.size();
  std::vector<Four> states(4 * count);
  std::vector<State> links(count);
  Four *position = states.data(), *speed = position + count, *increase = speed + count, *torque = increase + count;
  for (size_t first = 0; first < rows; first += lanes) {
    for (size_t j = 0; j < count; ++j) {
      for (size_t i = 0; i < lanes; ++i) {
        // Where rows end, the last is computed again.
        const size_t at = std::min(first + i, rows - 1) * count + j;
        position[j].lane[i] = q[at], speed[j].lane[i] = v[at], increase[j].lane[i] = a[at];
      }
    }
    move(links_, gravity_, position, speed, increase, links.data());
    bear(links_, increase, links.data(), torque);
    for (size_t i = 0; i < lanes && first + i < rows; ++i) {
      for (size_t j = 0; j < count; ++j) found[(first + i) * count + j] = torque[j].lane[i];
    }
  }
}

}  // namespace proof
