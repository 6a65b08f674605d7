#include "stand_out.hpp"

#include <queue>

namespace covers {

namespace {

struct Patch {
  double bound;  // Nothing of it is farther from the mesh [m].
  int number;    // Of two alike the older comes first.
  int guess;     // A triangle of the mesh near it.
  Triangle corners;

  bool operator<(const Patch& other) const {
    return bound != other.bound ? bound < other.bound : number > other.number;
  }
};

}  // namespace

StandOut stand_out(const Hull& hull, const Surface& surface, const Room* room, const Question& question) {
  StandOut result;
  std::priority_queue<Patch> patches;
  int count = 0;
  const auto found = [&](const Vec& point, double distance) {
    result.found = std::max(result.found, distance);
    if (distance > question.too_far) result.beyond.add(point, distance);
  };
  const auto look = [&](const Triangle& corners, double bound, int guess) {
    const Vec centre = 1.0 / 3.0 * (corners[0] + corners[1] + corners[2]);
    const Near near = surface.nearest(centre, guess);
    double radius = 0.0, plain = 0.0;  // The distance to one triangle is largest at a corner.
    for (const Vec& corner : corners) {
      radius = std::max(radius, norm(corner - centre));
      plain = std::max(plain, surface.distance(corner, near.triangle));
    }
    ++count;
    if (room != nullptr && near.distance > std::min(radius, question.enough)) {
      const Place place = room->place(centre, near.distance);
      if (place == Place::solid || place == Place::shut) {
        if (near.distance >= radius) return;
      } else {
        found(centre, near.distance);
      }
    } else if (room == nullptr) {
      found(centre, near.distance);
    }
    patches.push({std::min({bound, plain, near.distance + radius}), count, near.triangle, corners});
  };
  for (size_t face = 0; face < hull.faces.size(); ++face) look(hull.corners(face), HUGE_VAL, -1);
  while (!patches.empty()) {
    const Patch patch = patches.top();
    const double settled = std::max(question.enough, result.found + question.accuracy);
    if (patch.bound <= settled || result.beyond.points.size() >= question.wanted || count >= question.most_points) break;
    patches.pop();
    const Triangle& t = patch.corners;
    int side = 0;
    for (int other = 1; other < 3; ++other)
      if (squared(t[(other + 1) % 3] - t[other]) > squared(t[(side + 1) % 3] - t[side])) side = other;
    const Vec &a = t[side], &b = t[(side + 1) % 3], &c = t[(side + 2) % 3], middle = 0.5 * (a + b);
    look({a, middle, c}, patch.bound, patch.guess);
    look({middle, b, c}, patch.bound, patch.guess);
  }
  result.bound = patches.empty() ? result.found : std::max(result.found, patches.top().bound);
  return result;
}

}  // namespace covers
