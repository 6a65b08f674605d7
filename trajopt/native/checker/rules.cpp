#include "rules.hpp"

#include <algorithm>

#include "arm.hpp"
#include "torque.hpp"
#include "values.hpp"

namespace checker {
namespace {

using Cells = std::function<bool(int)>;

// The first cell that does not hold, of all or of the last one before a time of the grid.
int first_not(int end, bool always, const Cells& holds) {
  const int last = end - 1;
  for (int cell = always ? 0 : last; cell <= last; ++cell)
    if (!holds(cell)) return cell;
  return SHOWN;
}

std::string span(bool always) { return always ? "at all times " : "at the end "; }

// A frame as seen from a joint that carries it, or the world.
struct FrameView {
  Place place;
  int reference = 0;

  Turn turn(const Arm& arm, int time) const {
    return transposed(arm.rotation[arm.at(time, reference)]) * (arm.rotation[arm.at(time, place.joint)] * place.rotation);
  }
  Vec origin(const Arm& arm, int time) const {
    const Vec away = arm.point(time, place.joint, place.translation) - arm.translation[arm.at(time, reference)];
    return turned_back(arm.rotation[arm.at(time, reference)], away);
  }
  Travel travel(const Arm& arm) const { return {arm, place.joint, place.translation, 0.0}; }
};

FrameView seen_from(const Place& place, int reference, const Statement& statement) {
  int joint = place.joint;
  while (joint > reference) joint = statement.joints[joint - 1].place.joint;
  demand(joint == reference, "the reference of a requirement must carry its frame, or be the world");
  return {place, reference};
}

// Bound how far a function is from its chord in a cell, given a bound of its second derivative.
double off_chord(const Arm& arm, int cell, double second) {
  const double length = up(arm.grid[cell + 1] - arm.grid[cell]);
  return up(second * up(up(length * length) / 8.0));
}

Rule joint_ranges(nb::handle value, const Statement& statement) {
  struct Bounds {
    Joint joint;
    double least, most;
  };
  const Fields fields("joint positions", value, {"kind", "always", "ranges"});
  const bool always = flag("always", fields["always"]);
  std::vector<Bounds> rows;
  for (nb::handle each : items("ranges", fields["ranges"])) {
    const nb::list entries = row("a range", each, 3);
    const int joint = below("the joint of a range", entries[0], static_cast<long>(statement.joints.size()) + 1);
    demand(joint > 0, "the joint of a range must be a joint, and not the world");
    rows.push_back({statement.joints[joint - 1], unless_null("a bound", entries[1], -INFINITY), unless_null("a bound", entries[2], INFINITY)});
  }
  return {span(always) + "joints are in their ranges", [=](const Arm& arm, int end) {
            const Ball excess{arm.statement.excess};
            return first_not(end, always, [&](int cell) {
              for (const auto& [joint, least, most] : rows) {
                const int at = cell * arm.motion.count + joint.coordinate;
                const Ball taken = always ? arm.motion.bounds[0][at].ball() : arm.motion.positions[at + arm.motion.count];
                const Ball position = taken * Ball{joint.factor} + Ball{joint.offset};
                if (std::isfinite(least) && !(position.low() >= (Ball{least} - excess).high())) return false;
                if (std::isfinite(most) && !(position.high() <= (Ball{most} + excess).low())) return false;
                if (!std::isfinite(position.high())) return false;
              }
              return true;
            });
          }};
}

// Bound the accelerations of unit vectors: points at distance 1 from the joints' axes at most.
double unit_acceleration(const Arm& arm, const FrameView& seen, int cell) {
  double v = 0.0, u = 0.0;
  for (int joint = seen.place.joint; joint != seen.reference; joint = arm.parent(joint)) {
    if (!arm.statement.joints[joint - 1].turns) continue;
    const double w = arm.rates[0][arm.at(cell, joint)], a = arm.rates[1][arm.at(cell, joint)];
    u += 2.0 * w * v + w * w + a;
    v += w;
  }
  return u * SAFE;
}

Rule alignment(nb::handle value, const Statement& statement) {
  const Fields fields("axis alignment", value, {"kind", "frame", "joint", "axis", "reference", "direction", "tolerance", "always"});
  const long joints = static_cast<long>(statement.joints.size()) + 1;
  const std::string name = text("a frame", fields["frame"]);
  Place place;
  place.joint = below("the joint of an axis", fields["joint"], joints);
  const FrameView seen = seen_from(place, below("a reference", fields["reference"], joints), statement);
  const Vec axis = normalised(direction<3>("an axis", fields["axis"])), along = normalised(direction<3>("a direction", fields["direction"]));
  const double angle = larger(down(size("a tolerance", fields["tolerance"]) + statement.excess), 0.0);
  const bool always = flag("always", fields["always"]);
  demand(angle <= 3.14, "an axis must be aligned to within 3.14 rad");
  const double least = up(sine_and_cosine(angle).cosine + WAVE_ERROR);
  return {span(always) + "an axis of " + name + " is within its cone", [=](const Arm& arm, int end) {
            const auto inner = [&](int time) { return dot(turned(seen.turn(arm, time), axis), along).low(); };
            return first_not(end, always, [&](int cell) {
              if (!always) return inner(cell + 1) >= least;
              const double off = off_chord(arm, cell, unit_acceleration(arm, seen, cell));
              return down(smaller(inner(cell), inner(cell + 1)) - off) >= least;
            });
          }};
}

// A member of a region: a box of edges, a sphere, a cylinder of radius and length, or z <= 0.
struct Member {
  enum Kind { BOX, SPHERE, CYLINDER, HALF_SPACE } kind;
  std::vector<double> sizes;
  Place place;

  // How far a point is outside, negative inside, from above.
  double beyond(const Vec& point) const {
    const Vec local = turned_back(place.rotation, point - place.translation);
    const auto along = [&](double component) { return up(std::abs(component) + local.r); };
    switch (kind) {
      case HALF_SPACE: return up(local.z + local.r);
      case SPHERE: return up(local.length() - sizes[0]);
      case CYLINDER: {
        const double across = grown(std::sqrt(local.x * local.x + local.y * local.y) * GROWN + local.r);
        return larger(up(across - sizes[0]), up(along(local.z) - sizes[1] / 2.0));
      }
      default:
        return larger(up(along(local.x) - sizes[0] / 2.0), larger(up(along(local.y) - sizes[1] / 2.0), up(along(local.z) - sizes[2] / 2.0)));
    }
  }
};

Member read_member(nb::handle value, int joints) {
  static const char* const KINDS[] = {"box", "sphere", "cylinder", "half-space"};
  static const std::size_t COUNTS[] = {3, 1, 2, 0};
  const nb::list entries = row("a member of a region", value, 3);
  const std::string kind = text("the kind of a member", entries[0]);
  int at = 0;
  while (at < 4 && kind != KINDS[at]) ++at;
  demand(at < 4, "the kind of a member must be one of box, sphere, cylinder, half-space");
  Member found{static_cast<Member::Kind>(at), {}, place("the place of a member", entries[2], joints)};
  for (nb::handle each : row("the sizes of a member", entries[1], COUNTS[at])) found.sizes.push_back(size("a size", each));
  return found;
}

Rule region(nb::handle value, const Statement& statement) {
  const Fields fields("position in region", value, {"kind", "frame", "place", "members", "always"});
  const int joints = static_cast<int>(statement.joints.size());
  const std::string name = text("a frame", fields["frame"]);
  std::vector<Member> members;
  for (nb::handle each : items("members", fields["members"])) members.push_back(read_member(each, joints));
  demand(!members.empty(), "a region needs members");
  for (const Member& each : members) demand(each.place.joint == members[0].place.joint, "a region needs members of one joint");
  const FrameView seen = seen_from(place("the place of a frame", fields["place"], joints), members[0].place.joint, statement);
  const bool always = flag("always", fields["always"]);
  return {span(always) + name + " is in its region", [=](const Arm& arm, int end) {
            Travel travel = seen.travel(arm);
            return first_not(end, always, [&](int cell) {
              const Vec last = seen.origin(arm, cell + 1), first = always ? seen.origin(arm, cell) : last;
              // A convex shape that holds both ends of a chord, with room, holds what is near it.
              const double room = always ? off_chord(arm, cell, travel.bounds(cell, cell + 1, seen.reference).acceleration) : 0.0;
              for (const Member& each : members)
                if (up(larger(each.beyond(first), each.beyond(last)) + room) <= arm.statement.excess) return true;
              return false;
            });
          }};
}

// Bound angle / sine of a rotation from above, given its sine, not negative, and cosine.
//
// An angle from the library is only a guess: sine and cosine of its difference show that it is not too small.
double angle_by_sine(Ball sine, Ball cosine) {
  const double guess = std::atan2(sine.c, cosine.c) + 4.0 * (sine.r + cosine.r) + 64.0 * U;
  if (guess <= 0.03) {  // angle / sine <= 1 + angle^2 / 5
    if (!(cosine.low() > 0.9 && sine.high() <= down(sine_and_cosine(guess).sine - WAVE_ERROR))) return NOT_A_NUMBER;
    return up(1.0 + up(guess * guess) / 5.0);
  }
  const auto [s, c] = sine_and_cosine(guess);
  const Ball of_sine{s, WAVE_ERROR}, of_cosine{c, WAVE_ERROR};
  const bool above = (of_sine * cosine - of_cosine * sine).low() >= 0.0 && (of_cosine * cosine + of_sine * sine).low() > 0.0;
  return above && of_sine.low() > 0.0 ? (Ball{guess} / of_sine).high() : NOT_A_NUMBER;
}

Rule placement(nb::handle value, const Statement& statement) {
  const Fields fields("frame placement", value, {"kind", "frame", "place", "goal", "position", "rotation"});
  const int joints = static_cast<int>(statement.joints.size());
  const std::string name = text("a frame", fields["frame"]);
  const Place goal = place("a goal", fields["goal"], joints);
  const FrameView seen = seen_from(place("the place of a frame", fields["place"], joints), goal.joint, statement);
  const auto tolerances = [&](Where field) {
    std::array<double, 3> found;
    int at = 0;
    for (nb::handle each : row(field, fields[field], 3)) found[at++] = each.is_none() ? INFINITY : down(size(field, each) + statement.excess);
    return found;
  };
  const auto position = tolerances("position"), rotation = tolerances("rotation");
  return {"at the end " + name + " is at its placement", [=](const Arm& arm, int end) {
            const Vec off = turned_back(goal.rotation, seen.origin(arm, end) - goal.translation);
            const Turn turn = transposed(goal.rotation) * seen.turn(arm, end);
            const auto& m = turn.m;
            const double half = 0.5;
            // The skew part is the axis times the sine; its errors are those of the matrix and of a difference.
            const Vec axis{half * (m[7] - m[5]), half * (m[2] - m[6]), half * (m[3] - m[1]), grown(turn.r + 4.0 * U)};
            const Ball sine{axis.middle(), grown(axis.r + 4.0 * U)};
            const Ball cosine{half * (m[0] + m[4] + m[8] - 1.0), grown(1.5 * turn.r + 8.0 * U)};
            const bool free = std::isinf(rotation[0]) && std::isinf(rotation[1]) && std::isinf(rotation[2]);
            const double scale = free ? 0.0 : angle_by_sine(sine, cosine);
            const double distance[] = {off.x, off.y, off.z}, component[] = {axis.x, axis.y, axis.z};
            for (int at = 0; at < 3; ++at)
              if (!(up(std::abs(distance[at]) + off.r) <= position[at] &&
                    up(up(std::abs(component[at]) + axis.r) * scale) <= rotation[at]))
                return end - 1;
            return SHOWN;
          }};
}

Vec velocity(const Arm& arm, const Place& place, int time) {
  const Vec point = arm.point(time, place.joint, place.translation);
  Vec total;
  for (int joint = place.joint; joint > 0; joint = arm.parent(joint)) {
    const Joint& stated = arm.statement.joints[joint - 1];
    const Ball rate = arm.motion.velocities[time * arm.motion.count + stated.coordinate] * Ball{stated.factor};
    const Vec& axis = arm.axes[arm.at(time, joint)];
    total = total + (stated.turns ? cross(axis, point - arm.translation[arm.at(time, joint)]) : axis) * rate;
  }
  return total;
}

Rule tool_speed(nb::handle value, const Statement& statement) {
  const Fields fields("tool speed", value, {"kind", "frame", "place", "limit"});
  const std::string name = text("a frame", fields["frame"]);
  const FrameView seen = seen_from(place("the place of a frame", fields["place"], static_cast<int>(statement.joints.size())), 0, statement);
  const double limit = size("a limit", fields["limit"]);
  return {"at all times the speed of " + name + " is below its limit", [=](const Arm& arm, int end) {
            Travel travel = seen.travel(arm);
            const bool smooth = arm.statement.curve.values.size() == 3;
            return first_not(end, true, [&](int cell) {
              const double speed = larger(velocity(arm, seen.place, cell).length(), velocity(arm, seen.place, cell + 1).length());
              const PointTravel bounds = travel.bounds(cell, cell + 1, 0);
              // A cubic's acceleration jumps, so its velocity is only known to be near an end.
              const double off = smooth ? off_chord(arm, cell, bounds.jerk)
                                        : up(bounds.acceleration * up(arm.grid[cell + 1] - arm.grid[cell]) / 2.0);
              return up(speed + off) <= down(limit + arm.statement.excess);
            });
          }};
}

Rule torque(nb::handle value, const Statement& statement) {
  const Fields fields("torque", value, {"kind", "gravity", "loads", "rotors", "limits"});
  Masses masses;
  masses.gravity = point("gravity", fields["gravity"]);
  for (nb::handle each : items("loads", fields["loads"], MOST_JOINTS)) {
    const nb::list entries = row("a load", each, 4);
    masses.loads.push_back({below("the joint of a load", entries[0], static_cast<long>(statement.joints.size()) + 1),
                            size("a mass", entries[1]), point("a centre of mass", entries[2]), tuple<6>("moments", entries[3])});
  }
  for (nb::handle each : row("rotors", fields["rotors"], statement.joints.size())) masses.rotors.push_back(number("a rotor", each));
  for (nb::handle each : items("limits", fields["limits"])) {
    const nb::list entries = row("a limit", each, 2);
    masses.limits.emplace_back(below("a coordinate", entries[0], statement.curve.count()), size("a limit", entries[1]));
  }
  return {"at all times torques are below their limits",
          [=](const Arm& arm, int) { return torque_unshown(arm.statement, masses, arm); }};
}

using Reader = std::pair<const char*, Rule (*)(nb::handle, const Statement&)>;
const Reader OF_THE_END[] = {
    {"joint positions", joint_ranges}, {"frame placement", placement}, {"axis alignment", alignment}, {"position in region", region}};

Rule read_of_the_end(nb::handle value, const Statement& statement) {
  const std::string kind = text("kind of a requirement", mapping("a requirement", value).get("kind", nb::none()));
  for (const auto& [name, read] : OF_THE_END)
    if (kind == name) return read(value, statement);
  throw Malformed("kind of a requirement must be one of those of the format");
}

// A requirement of the end holds at some moment, which is a time of the grid.
Rule waypoint(nb::handle value, const Statement& statement) {
  const Fields fields("waypoint", value, {"kind", "name", "time", "requirement"});
  const std::string name = text("the name of a waypoint", fields["name"]);
  const double time = number("the time of a waypoint", fields["time"]);
  const nb::dict inner = mapping("the requirement of a waypoint", fields["requirement"]);
  const bool always = inner.contains("always") && nb::object(inner["always"]).is(nb::bool_(true));
  demand(!always, "the requirement of a waypoint must be one of the end");
  const Rule required = read_of_the_end(inner, statement);
  return {"at waypoint " + name + ": " + required.words, [=](const Arm& arm, int end) {
            const auto place = std::lower_bound(arm.grid.begin(), arm.grid.end(), time);
            if (place == arm.grid.end() || *place != time) return end - 1;
            return required.unshown(arm, static_cast<int>(place - arm.grid.begin()));
          }};
}

}  // namespace

Rule read_rule(nb::handle value, const Statement& statement) {
  const std::string kind = text("kind of a requirement", mapping("a requirement", value).get("kind", nb::none()));
  for (const auto& [name, read] : {Reader{"tool speed", tool_speed}, Reader{"torque", torque}, Reader{"waypoint", waypoint}})
    if (kind == name) return read(value, statement);
  return read_of_the_end(value, statement);
}

}  // namespace checker
