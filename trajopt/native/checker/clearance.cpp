#include "clearance.hpp"

#include <algorithm>
#include <cstring>
#include <set>

namespace checker {
namespace {

typedef double Two __attribute__((vector_size(16)));

Two two(const std::vector<double>& of, std::size_t at) {
  Two found;
  std::memcpy(&found, &of[at], sizeof found);
  return found;
}

// The largest inner product with a vertex.
double farthest_along(const Shape& shape, const Vec& direction) {
  Two best{-INFINITY, -INFINITY}, other = best;
  const auto along = [&](std::size_t at) {
    return two(shape.x, at) * direction.x + two(shape.y, at) * direction.y + two(shape.z, at) * direction.z;
  };
  for (std::size_t at = 0; at < shape.x.size(); at += 4) {
    const Two one = along(at), next = along(at + 2);
    best = one > best ? one : best;
    other = next > other ? next : other;
  }
  return std::max(std::max(best[0], best[1]), std::max(other[0], other[1]));
}

// The largest inner product of a part with a direction at times of the grid, both as seen from a joint that carries it.
class Support {
 public:
  Support(const Arm& arm, const Part& part, int seen, const Vec& direction)
      : arm_(arm), part_(part), seen_(seen), direction_(direction), rests_(part.place.joint == seen) {
    if (rests_) resting_ = along(direction, Ball{});
  }
  double at(int time) const {
    if (rests_) return resting_;
    const int there = arm_.at(time, seen_), here = arm_.at(time, part_.place.joint);
    if (!seen_) return along(turned_back(arm_.rotation[here], direction_), dot(direction_, arm_.translation[here]));
    const Vec world = turned(arm_.rotation[there], direction_);
    return along(turned_back(arm_.rotation[here], world), dot(world, arm_.translation[here] - arm_.translation[there]));
  }

 private:
  // For a direction in the frame of the part's joint, and its inner product with the origin of that.
  double along(const Vec& inward, Ball base) const {
    const Place& place = part_.place;
    return up((base + dot(inward, place.translation)).high() + part_.shape.support(turned_back(place.rotation, inward)));
  }
  const Arm& arm_;
  const Part& part_;
  int seen_;
  Vec direction_;
  bool rests_;
  double resting_ = 0.0;
};

// Whether both parts of a pair are there and must keep apart, and the largest error of their places.
struct Presence {
  std::vector<const Change*> changes;
  double since = -INFINITY, until = INFINITY;
  bool there(double begin, double end) const {
    return end > since && begin < until &&
           std::all_of(changes.begin(), changes.end(),
                       [&](const Change* each) { return end > each->appears && begin < each->expires; });
  }
  double error(double end) const {
    double found = 0.0;
    for (const Change* each : changes) {
      const auto [r, v, a] = each->error;
      found = up(found + up(up(r + up(v * end)) + up(a / 2.0 * up(end * end))));
    }
    return found;
  }
};

Presence presence(const Statement& statement, const Part& one, const Part& other) {
  Presence found;
  for (const Change& change : statement.changes)
    for (const Part* part : {&one, &other})
      if (part->owner == change.owner) found.changes.push_back(&change);
  for (const Contact& contact : statement.contacts)
    if (std::minmax(one.owner, other.owner) == std::minmax(contact.one, contact.other))
      found.since = std::max(found.since, contact.since), found.until = std::min(found.until, contact.until);
  return found;
}

Vec normal(const Part& part) { return turned(part.place.rotation, Vec{0.0, 0.0, 1.0}); }

// Whether there is a knot of a drive within an interval, where velocities may jump.
bool across_knots(const Statement& statement, double begin, double end) {
  for (const Curve& drive : statement.drives) {
    const auto next = std::upper_bound(drive.times.begin(), drive.times.end(), begin);
    if (next != drive.times.end() && *next < end) return true;
  }
  return false;
}

std::string left_out(const Statement& statement, const Arm& arm) {
  std::set<std::pair<int, int>> listed;
  for (const Pair& pair : statement.pairs) listed.insert(std::minmax(pair.one, pair.other));
  std::set<std::pair<std::string, std::string>> excused;
  for (const auto& owners : statement.excused) excused.insert(std::minmax(owners.first, owners.second));
  const int count = static_cast<int>(statement.parts.size());
  for (int one = 0; one < count; ++one)
    for (int other = one + 1; other < count; ++other) {
      const Part &first = statement.parts[one], &second = statement.parts[other];
      const int joint = first.place.joint, next = second.place.joint;
      if (joint == next || !(arm.moved[joint] || arm.moved[next]) || first.owner == second.owner) continue;
      if (listed.count({one, other})) continue;
      if (!excused.count(std::minmax(first.owner, second.owner)))
        return first.owner + " and " + second.owner + " are neither a pair nor excused";
    }
  return "";
}

}  // namespace

// The rounding of an inner product with a vertex is below 4 U of the product of the lengths.
double Shape::support(const Vec& direction) const {
  switch (kind) {
    case HALF_SPACE: return 0.0;  // along its normal, the only direction
    case HULL: {
      const double size = direction.middle(), along = farthest_along(*this, direction);
      return up(along + grown(farthest * (direction.r + 4.0 * U * size) + radius * (size + direction.r)));
    }
    default: {
      const double across = grown(std::sqrt(direction.x * direction.x + direction.y * direction.y) * GROWN + direction.r);
      const double least = up(larger(up(across * bottom) - direction.z * (length / 2.0),
                                     up(across * top) + direction.z * (length / 2.0)));
      return up(least + grown(length / 2.0 * (direction.r + 4.0 * U * direction.middle())));
    }
  }
}

std::string pairs_fault(const Statement& statement, const Witness& witness, const Arm& arm) {
  const std::string fault = left_out(statement, arm);
  if (!fault.empty()) return fault;
  for (std::size_t pair = 0; pair < statement.pairs.size(); ++pair) {
    const Part &one = statement.parts[statement.pairs[pair].one], &other = statement.parts[statement.pairs[pair].other];
    const int seen = arm.shared(one.place.joint, other.place.joint);
    int planes = 0;
    for (const Part* part : {&one, &other}) {
      if (part->shape.kind != Shape::HALF_SPACE) continue;
      ++planes;
      if (part->place.joint != seen) return "a half-space moves, as seen from the other part of its pair";
    }
    if (planes == 2) return "two half-spaces are a pair, which no direction separates";
    if (!arm.driven[one.place.joint] && !arm.driven[other.place.joint]) continue;
    for (int leaf = witness.first[pair]; leaf < witness.first[pair + 1]; ++leaf)
      if (across_knots(statement, witness.grid[witness.begin[leaf]], witness.grid[witness.end(static_cast<int>(pair), leaf)]))
        return "a leaf of a part that follows time reaches across a knot of its motion";
  }
  return "";
}

std::vector<bool> leaves_hold(const Statement& statement, const Witness& witness, const Arm& arm) {
  std::vector<bool> found(witness.begin.size());
  std::vector<Travel> travels;
  for (const Part& part : statement.parts) travels.emplace_back(arm, part.place.joint, part.centre, part.radius);
  for (std::size_t pair = 0; pair < statement.pairs.size(); ++pair) {
    const auto [one, other, clearance] = statement.pairs[pair];
    const Part &first = statement.parts[one], &second = statement.parts[other];
    const int seen = arm.shared(first.place.joint, second.place.joint);
    const Presence present = presence(statement, first, second);
    const bool below = first.shape.kind == Shape::HALF_SPACE, above = second.shape.kind == Shape::HALF_SPACE;
    for (int leaf = witness.first[pair]; leaf < witness.first[pair + 1]; ++leaf) {
      const int begin = witness.begin[leaf], end = witness.end(static_cast<int>(pair), leaf);
      const double from = witness.grid[begin], to = witness.grid[end], length = up(to - from);
      if (!present.there(from, to)) {
        found[leaf] = true;
        continue;
      }
      const auto& stated = witness.direction[leaf];
      const Vec direction = below ? normal(first) : above ? -normal(second) : Vec{stated[0], stated[1], stated[2]};
      const double off = up(travels[one].bounds(begin, end, seen).acceleration + travels[other].bounds(begin, end, seen).acceleration);
      const double needed = up(up(clearance + present.error(to)) + up(off * up(up(length * length) / 8.0)));
      const double least = up(needed * direction.length());
      const Support from_first(arm, first, seen, direction), from_second(arm, second, seen, -direction);
      const auto apart = [&](int time) { return -up(from_first.at(time) + from_second.at(time)) > least; };
      found[leaf] = apart(begin) && apart(end);
    }
  }
  return found;
}

}  // namespace checker
