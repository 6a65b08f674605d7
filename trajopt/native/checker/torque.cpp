#include "torque.hpp"

namespace checker {
namespace {

// The largest size of numbers or lengths of vectors. Equations on sizes alone are wide, and fast.
struct Size {
  double v = 0.0;
};
Size operator+(Size a, Size b) { return {a.v + b.v}; }
Size operator*(Size a, Size b) { return {a.v * b.v}; }
Size cross(Size a, Size b) { return a * b; }
Size dot(Size a, Size b) { return a * b; }

template <class S>
S constant(double value) {
  if constexpr (std::is_same_v<S, Size>) return {std::abs(value)};
  else return {value};
}

using Moments = std::array<double, 6>;

double length_of(const Moments& m) {
  return std::sqrt(m[0] * m[0] + m[3] * m[3] + m[5] * m[5] + 2.0 * (m[1] * m[1] + m[2] * m[2] + m[4] * m[4])) * GROWN + TINY;
}
// The moments of inertia of a load, and the length of them as a vector, which bounds the largest singular value.
struct Inertia {
  Moments m{};
  double length = 0.0;
};
Size operator*(const Inertia& inertia, Size v) { return {inertia.length * v.v}; }
template <bool W>
Vectors<W> operator*(const Inertia& inertia, const Vectors<W>& v) {
  const Moments& m = inertia.m;
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[1] * v.x + m[3] * v.y + m[4] * v.z, m[2] * v.x + m[4] * v.y + m[5] * v.z,
          grown(inertia.length * (v.r + 8.0 * U * v.factor()))};
}

// A quantity with N - 1 derivatives: the quantity, its first derivative and half of its second one.
template <class V, int N>
using Series = std::array<V, N>;

template <class V, std::size_t N>
CLOSE std::array<V, N> operator+(const std::array<V, N>& a, const std::array<V, N>& b) {
  std::array<V, N> found;
  for (std::size_t order = 0; order < N; ++order) found[order] = a[order] + b[order];
  return found;
}
template <class V, std::size_t N, class Linear>
CLOSE auto each(const std::array<V, N>& of, Linear linear) {
  std::array<decltype(linear(of[0])), N> found;
  for (std::size_t order = 0; order < N; ++order) found[order] = linear(of[order]);
  return found;
}
// The product rule (Leibniz).
template <class V, std::size_t N>
CLOSE std::array<V, N> cross(const std::array<V, N>& a, const std::array<V, N>& b) {
  std::array<V, N> found;
  for (std::size_t order = 0; order < N; ++order) {
    found[order] = cross(a[0], b[order]);
    for (std::size_t at = 1; at <= order; ++at) found[order] = found[order] + cross(a[at], b[order - at]);
  }
  return found;
}

// Newton's and Euler's equations, on vectors V and numbers S.
template <class V, class S, int N>
class Equations {
 public:
  using Quantity = Series<V, N>;
  using Numbers = Series<S, N>;

  // The state of all joints, N numbers each, and their rotations in their parents.
  struct State {
    std::vector<Numbers> position, velocity, acceleration;
    std::vector<Turn> turn;
    explicit State(int joints) : position(joints), velocity(joints), acceleration(joints), turn(joints) {}
  };

  Equations(const Statement& statement, const Masses& masses)
      : statement_(statement), masses_(masses), axis_(1), slide_(1), origin_(1) {
    for (const Joint& joint : statement.joints) {
      axis_.push_back(taken(joint.axis));
      slide_.push_back(taken(slide(joint)));
      origin_.push_back(taken(joint.place.translation));
    }
    for (const Load& load : masses.loads) {
      centre_.push_back(taken(load.centre));
      inertia_.push_back({load.moments, length_of(load.moments)});
    }
    const std::size_t count = axis_.size();
    spin_.resize(count), swing_.resize(count), push_.resize(count), force_.resize(count), moment_.resize(count), shift_.resize(count);
  }

  // The torques or forces of coordinates, together with those of joints that follow.
  void torques(const State& state, std::vector<Numbers>& total) {
    outward(state);
    for (std::size_t joint = 0; joint < force_.size(); ++joint) force_[joint] = Quantity{}, moment_[joint] = Quantity{};
    for (std::size_t load = 0; load < masses_.loads.size(); ++load) add(masses_.loads[load], centre_[load], inertia_[load]);
    for (Numbers& each : total) each = Numbers{};
    for (int joint = static_cast<int>(axis_.size()) - 1; joint > 0; --joint) {
      const Joint& item = statement_.joints[joint - 1];
      const Quantity& borne = item.turns ? moment_[joint] : force_[joint];
      const V axis = axis_[joint];
      const S rotor = constant<S>(masses_.rotors[joint - 1]), factor = constant<S>(item.factor);
      const Numbers own = each(borne, [&](const V& v) { return dot(v, axis); });
      const Numbers whole = own + each(state.acceleration[joint], [&](const S& s) { return s * rotor; });
      total[item.coordinate] = total[item.coordinate] + each(whole, [&](const S& s) { return s * factor; });
      const Quantity force = outward(state, joint, force_[joint]), moment = outward(state, joint, moment_[joint]);
      const int parent = item.place.joint;
      force_[parent] = force_[parent] + force;
      moment_[parent] = moment_[parent] + moment + cross(shift_[joint], force);
    }
  }

 private:
  static V taken(const Vec& vector) {
    if constexpr (std::is_same_v<V, Size>) return {vector.length()};
    else return {vector.x, vector.y, vector.z, vector.r};
  }
  static V turned_by(const Turn& turn, const V& v, bool back) {
    if constexpr (std::is_same_v<V, Size>) return v;
    else return back ? turned_back(turn, v) : turned(turn, v);
  }

  // A vector of the parent's frame in a joint's: with R' = -axis x R for the inverse of its rotation, times the rate.
  Quantity inward(const State& state, int joint, const Quantity& v) const {
    Quantity y = each(v, [&](const V& one) { return turned_by(state.turn[joint], one, true); });
    return statement_.joints[joint - 1].turns ? carried(state, joint, y, constant<S>(-1.0)) : y;
  }
  // And a vector of a joint's frame in its parent's.
  Quantity outward(const State& state, int joint, const Quantity& v) const {
    const Quantity y = statement_.joints[joint - 1].turns ? carried(state, joint, v, constant<S>(1.0)) : v;
    return each(y, [&](const V& one) { return turned_by(state.turn[joint], one, false); });
  }
  Quantity carried(const State& state, int joint, const Quantity& v, S sign) const {
    Quantity found = v;
    if constexpr (N > 1) {
      const V& axis = axis_[joint];
      const S rate = state.velocity[joint][0] * sign, increase = state.acceleration[joint][0] * sign;
      const V aside = cross(axis, v[0]);
      found[1] = v[1] + aside * rate;
      found[2] = v[2] + cross(axis, v[1]) * rate + (aside * increase + cross(axis, aside) * (rate * rate)) * constant<S>(0.5);
    }
    return found;
  }

  // The acceleration of the end of an arm against its begin.
  Quantity accelerated(int joint, const Quantity& arm) const {
    return cross(swing_[joint], arm) + cross(spin_[joint], cross(spin_[joint], arm));
  }

  void outward(const State& state) {
    spin_[0] = Quantity{}, swing_[0] = Quantity{}, push_[0] = Quantity{};
    push_[0][0] = taken(-masses_.gravity);
    for (std::size_t joint = 1; joint < axis_.size(); ++joint) {
      const Joint& item = statement_.joints[joint - 1];
      const int parent = item.place.joint, here = static_cast<int>(joint);
      const auto along = [&](const V& axis, const Numbers& size) { return each(size, [&](const S& s) { return axis * s; }); };
      shift_[joint] = item.turns ? Quantity{} : along(slide_[joint], state.position[joint]);
      shift_[joint][0] = shift_[joint][0] + origin_[joint];
      push_[joint] = inward(state, here, push_[parent] + accelerated(parent, shift_[joint]));
      spin_[joint] = inward(state, here, spin_[parent]);
      swing_[joint] = inward(state, here, swing_[parent]);
      const Quantity rate = along(axis_[joint], state.velocity[joint]), increase = along(axis_[joint], state.acceleration[joint]);
      const Quantity aside = cross(spin_[joint], rate);
      if (item.turns) {
        spin_[joint] = spin_[joint] + rate;
        swing_[joint] = swing_[joint] + aside + increase;
      } else {
        push_[joint] = push_[joint] + aside + aside + increase;
      }
    }
  }

  void add(const Load& load, const V& centre, const Inertia& inertia) {
    const int at = load.joint;
    const S mass = constant<S>(load.mass);
    Quantity arm{};
    arm[0] = centre;
    const Quantity inertial = each(push_[at] + accelerated(at, arm), [&](const V& v) { return v * mass; });
    const auto momentum = [&](const V& v) { return inertia * v; };
    force_[at] = force_[at] + inertial;
    moment_[at] = moment_[at] + each(swing_[at], momentum) + cross(spin_[at], each(spin_[at], momentum)) + cross(arm, inertial);
  }

  const Statement& statement_;
  const Masses& masses_;
  std::vector<V> axis_, slide_, origin_, centre_;
  std::vector<Inertia> inertia_;
  std::vector<Quantity> spin_, swing_, push_, force_, moment_, shift_;
};

using AtTime = Equations<Vec, Ball, 1>;
using OverCell = Equations<WideVec, Ball, 3>;
using Sizes = Equations<Size, Size, 3>;

class Torques {
 public:
  Torques(const Statement& statement, const Masses& masses, const Arm& arm)
      : statement_(statement), masses_(masses), arm_(arm), count_(arm.motion.count), at_time_(statement, masses), over_(statement, masses),
        sizes_(statement, masses), at_(arm.joints), wide_(arm.joints), size_(arm.joints), found_at_(count_), found_over_(count_),
        found_size_(count_) {
    for (const Joint& joint : statement.joints) turning_.push_back(turning(joint));
  }

  int unshown() {
    const int cells = static_cast<int>(arm_.grid.size()) - 1;
    bool starts_at_rest = true;
    for (const double each : statement_.ends.velocities) starts_at_rest = starts_at_rest && each == 0.0;
    // The acceleration of quintics is continuous: what is at the end of a cell is at the begin of the next one.
    const bool smooth = statement_.curve.values.size() == 3 && statement_.drives.empty();
    std::vector<double> before(count_), after(count_);
    for (int cell = 0; cell < cells; ++cell) {
      if (cell && smooth) before.swap(after);
      else before = at_end(cell, 0, true);
      after = at_end(cell, 1, true);
      if (!holds_over(cell, before, after)) return cell;
      if (cell == 0 && starts_at_rest && !within(at_end(cell, 0, false))) return cell;
      if (cell + 1 == cells && statement_.ends.rests && !within(at_end(cell, 1, false))) return cell;
    }
    return SHOWN;
  }

 private:
  double most(double limit) const { return down(down(1.0 + statement_.excess) * limit); }

  bool within(const std::vector<double>& sizes) const {
    for (const auto& [coordinate, limit] : masses_.limits)
      if (!(sizes[coordinate] <= most(limit))) return false;
    return true;
  }

  // Sizes of the torques at the begin or the end of a cell, in motion or at rest.
  const std::vector<double>& at_end(int cell, int side, bool moving) {
    const Motion& motion = arm_.motion;
    for (int joint = 1; joint < arm_.joints; ++joint) {
      const Joint& item = statement_.joints[joint - 1];
      const int at = (cell + side) * count_ + item.coordinate;
      const Ball factor{item.factor};
      at_.position[joint][0] = motion.positions[at] * factor + Ball{item.offset};
      at_.velocity[joint][0] = moving ? motion.velocities[at] * factor : Ball{};
      at_.acceleration[joint][0] = moving ? motion.accelerations[side][cell * count_ + item.coordinate] * factor : Ball{};
      at_.turn[joint] = arm_.own[arm_.at(cell + side, joint)];
    }
    at_time_.torques(at_, found_at_);
    sizes_at_.resize(count_);
    for (int at = 0; at < count_; ++at) sizes_at_[at] = found_at_[at][0].size();
    return sizes_at_;
  }

  bool holds_over(int cell, const std::vector<double>& before, const std::vector<double>& after) {
    const double length = up(arm_.grid[cell + 1] - arm_.grid[cell]), share = up(up(length * length) / 8.0);
    const auto kept = [&](auto second) {
      for (const auto& [coordinate, limit] : masses_.limits) {
        const double off = up(up(2.0 * second(coordinate)) * share);
        if (!(up(larger(before[coordinate], after[coordinate]) + off) <= most(limit))) return false;
      }
      return true;
    };
    states_over<Size, Size>(cell, size_);
    sizes_.torques(size_, found_size_);
    if (kept([&](int at) { return found_size_[at][2].v * SAFE; })) return true;
    states_over<WideVec, Ball>(cell, wide_);
    for (int joint = 1; joint < arm_.joints; ++joint)
      wide_.turn[joint] = turning_[joint - 1].at(statement_.joints[joint - 1].turns ? wide_.position[joint][0] : Ball{});
    over_.torques(wide_, found_over_);
    return kept([&](int at) { return found_over_[at][2].size(); });
  }

  template <class V, class S>
  void states_over(int cell, typename Equations<V, S, 3>::State& state) const {
    for (int joint = 1; joint < arm_.joints; ++joint) {
      const Joint& item = statement_.joints[joint - 1];
      const S factor = constant<S>(item.factor), half = constant<S>(0.5);
      const auto order = [&](int which) {
        const Range& range = arm_.motion.bounds[which][cell * count_ + item.coordinate];
        if constexpr (std::is_same_v<S, Size>) return Size{range.size()} * factor;
        else return range.ball() * factor;
      };
      const S q = order(0) + constant<S>(item.offset), v = order(1), a = order(2), j = order(3), s = order(4);
      state.position[joint] = {q, v, a * half};
      state.velocity[joint] = {v, a, j * half};
      state.acceleration[joint] = {a, j, s * half};
    }
  }

  const Statement& statement_;
  const Masses& masses_;
  const Arm& arm_;
  int count_;
  AtTime at_time_;
  OverCell over_;
  Sizes sizes_;
  AtTime::State at_;
  OverCell::State wide_;
  Sizes::State size_;
  std::vector<AtTime::Numbers> found_at_;
  std::vector<OverCell::Numbers> found_over_;
  std::vector<Sizes::Numbers> found_size_;
  std::vector<double> sizes_at_;
  std::vector<Turning> turning_;
};

}  // namespace

int torque_unshown(const Statement& statement, const Masses& masses, const Arm& arm) {
  return Torques(statement, masses, arm).unshown();
}

}  // namespace checker
