#include "swept.hpp"

#include <algorithm>

namespace checker {

SweptParts::SweptParts(const Statement& statement, std::vector<double> times, const Frames& frames) : trees_(statement.parts.size()) {
  const double end = statement.curve.times.back();
  const auto add = [&](const Curve& curve) { times.insert(times.end(), curve.times.begin(), curve.times.end()); };
  add(statement.curve);
  for (const Curve& drive : statement.drives) add(drive);
  times.erase(std::remove_if(times.begin(), times.end(), [&](double time) { return !(0.0 <= time && time <= end); }), times.end());
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  const Arm arm(statement, times);
  std::map<int, Watched> found;
  for (const Pair& pair : statement.pairs)
    for (const auto& [mine, other] : {std::pair{pair.one, pair.other}, std::pair{pair.other, pair.one}}) {
      const Part& part = statement.parts[mine];
      const auto frame = frames.find(part.owner);
      if (frame == frames.end() || part.place.joint) continue;
      const auto here = found.try_emplace(mine, watched(part, frame->second)).first;
      here->second.others.push_back({other, pair.clearance});
      if (trees_[other].empty()) trees_[other] = tree_of(arm, statement.parts[other]);
    }
  for (const auto& [name, frame] : frames) objects_[name];
  for (auto& [mine, item] : found) objects_[statement.parts[mine].owner].push_back(std::move(item));
}

// Points of a part leave the chords between their places at the ends by at most u h^2 / 8, and the middle of the chord of
// its centre by half of that chord more.
SweptParts::Tree SweptParts::tree_of(const Arm& arm, const Part& part) {
  Travel travel(arm, part.place.joint, part.centre, part.radius);
  Tree tree(1);
  for (int cell = 0; cell + 1 < static_cast<int>(arm.grid.size()); ++cell) {
    const Vec begin = arm.point(cell, part.place.joint, part.centre), end = arm.point(cell + 1, part.place.joint, part.centre);
    const Vec middle = (begin + end) * Ball{0.5};
    const double length = up(arm.grid[cell + 1] - arm.grid[cell]);
    const double off = travel.bounds(cell, cell + 1, 0).acceleration * length * length / 8.0;
    tree[0].push_back({middle.x, middle.y, middle.z, ((end - begin).length() / 2.0 + middle.r + part.radius + off) * SAFE});
  }
  while (tree.back().size() > 1) {
    const auto& below = tree.back();
    std::vector<Sphere> above;
    for (std::size_t at = 0; at < below.size(); at += 2) {
      const Sphere &one = below[at], &other = below[std::min(at + 1, below.size() - 1)];
      const Vec first{one.x, one.y, one.z}, second{other.x, other.y, other.z}, middle = (first + second) * Ball{0.5};
      const double radius = larger((first - middle).length() + one.radius, (second - middle).length() + other.radius);
      above.push_back({middle.x, middle.y, middle.z, (radius + middle.r) * SAFE});
    }
    tree.push_back(std::move(above));
  }
  return tree;
}

SweptParts::Watched SweptParts::watched(const Part& part, const Place& frame) {
  Watched found{part.shape, {}, 0.0, {}, {}, {}};
  const Turn back = transposed(frame.rotation);
  found.local = {0, back * part.place.rotation, turned(back, part.place.translation - frame.translation)};
  const Shape& shape = part.shape;
  if (shape.kind == Shape::FRUSTUM) {
    const double wide = larger(shape.bottom, shape.top), half = shape.length / 2.0;
    found.low = {-wide, -wide, -half}, found.high = {wide, wide, half};
    found.around = Vec{wide, half}.length();
  } else if (shape.kind == Shape::HULL) {
    const std::vector<double>* sides[] = {&shape.x, &shape.y, &shape.z};
    for (int at = 0; at < 3; ++at) {
      const auto [low, high] = std::minmax_element(sides[at]->begin(), sides[at]->end());
      found.low[at] = *low, found.high[at] = *high;
    }
    found.around = up(shape.farthest + shape.radius);
  }
  return found;
}

// The direction is that from the nearest point of the box: any direction along which there is a gap is good.
bool SweptParts::clear(const Watched& item, const Place& place, const Sphere& ball, double clearance) {
  const double needed = up(ball.radius + clearance);
  const Vec away = Vec{ball.x, ball.y, ball.z} - place.translation;
  const double reach = up(needed + item.around), low = away.middle() * (1.0 - 64.0 * U) - away.r;
  if (low > reach * SAFE) return true;
  if (item.shape.kind == Shape::HALF_SPACE) return false;
  const Vec centre = turned_back(place.rotation, away);
  const Vec direction{centre.x - std::clamp(centre.x, item.low[0], item.high[0]), centre.y - std::clamp(centre.y, item.low[1], item.high[1]),
                      centre.z - std::clamp(centre.z, item.low[2], item.high[2])};
  const double gap = down(dot(direction, centre).low() - item.shape.support(direction));
  return gap > up(needed * direction.length());
}

bool SweptParts::clear(const Watched& item, const Place& place, const Other& other, std::size_t level, std::size_t number) const {
  const auto& balls = trees_[other.part][level];
  if (number >= balls.size() || clear(item, place, balls[number], other.clearance)) return true;
  return level && clear(item, place, other, level - 1, 2 * number) && clear(item, place, other, level - 1, 2 * number + 1);
}

bool SweptParts::keep_apart(const std::string& owner, const Place& frame) const {
  for (const Watched& item : objects_.at(owner)) {
    const Place place{0, frame.rotation * item.local.rotation, frame.translation + turned(frame.rotation, item.local.translation)};
    for (const Other& other : item.others)
      if (!clear(item, place, other, trees_[other.part].size() - 1, 0)) return false;
  }
  return true;
}

}  // namespace checker
