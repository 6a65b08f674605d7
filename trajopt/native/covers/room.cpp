#include "room.hpp"

#include <limits>

namespace covers {

namespace {

// Points spread evenly in a hull: Kronecker's sequence chooses a tetrahedron from the centre to a face, and a place in
// it. Its steps are powers of the root of x^5 = x + 1, the fairest in four dimensions (Roberts 2018).
Points spread(const Hull& hull, int count) {
  constexpr double kGolden = 1.1673039782614187;
  Vec centre;
  for (const Vec& vertex : hull.vertices) centre += vertex;
  centre = 1.0 / static_cast<double>(hull.vertices.size()) * centre;
  std::vector<double> share;
  double total = 0.0;
  for (size_t face = 0; face < hull.faces.size(); ++face) {
    const Triangle t = hull.corners(face);
    total += std::abs(dot(t[0] - centre, cross(t[1] - centre, t[2] - centre)));
    share.push_back(total);
  }
  std::array<double, 4> step;
  double power = 1.0;
  for (double& each : step) power /= kGolden, each = power;
  Points points(count);
  for (int number = 0; number < count; ++number) {
    std::array<double, 4> u;
    for (int axis = 0; axis < 4; ++axis) {
      const double along = 0.5 + (number + 1) * step[axis];
      u[axis] = along - std::floor(along);
    }
    const auto face = std::lower_bound(share.begin(), share.end(), u[0] * total) - share.begin();
    const Triangle t = hull.corners(std::min<size_t>(face, share.size() - 1));
    std::sort(u.begin() + 1, u.end());
    points[number] =
        centre + u[1] * (t[0] - centre) + (u[2] - u[1]) * (t[1] - centre) + (u[3] - u[2]) * (t[2] - centre);
  }
  return points;
}

}  // namespace

Room::Room(const Surface& surface, const Hull& hull, int count, double tolerance)
    : tolerance_(tolerance), points_(spread(hull, count)), tree_(points_) {
  const std::vector<std::uint8_t> inside = surface.contains(points_);
  places_.resize(points_.size());
  for (size_t index = 0; index < points_.size(); ++index)
    places_[index] = inside[index] ? Place::solid : Place::narrow;
  measure(surface);
  flood(hull);
  shut_hollows();
  size_t free = 0;
  for (size_t index = 0; index < points_.size(); ++index) {
    if (places_[index] != Place::narrow && places_[index] != Place::reached) continue;
    ++free;
    reach = std::max(reach, depth_[index]);
    if (places_[index] == Place::reached) wrong.add(points_[index], depth_[index]);
  }
  excess = free < points_.size() ? static_cast<double>(free) / static_cast<double>(points_.size() - free) : HUGE_VAL;
}

void Room::measure(const Surface& surface) {
  depth_.assign(points_.size(), 0.0);
  int guess = -1;
  for (size_t index = 0; index < points_.size(); ++index) {
    if (places_[index] == Place::solid) continue;
    const Near near = surface.nearest(points_[index], guess);
    depth_[index] = near.distance, guess = near.triangle;
  }
}

// Each point farther than the tolerance is the centre of a ball free of the mesh. Those whose ball stands out of the
// hull are reached, and from one centre to the next, if one of the two balls holds both.
void Room::flood(const Hull& hull) {
  std::vector<double> radius(points_.size(), 0.0);
  std::vector<int> reached;
  for (size_t index = 0; index < points_.size(); ++index) {
    if (places_[index] != Place::narrow || depth_[index] <= tolerance_) continue;
    if (-hull.height(points_[index]) < depth_[index])
      reached.push_back(static_cast<int>(index));
    else
      radius[index] = depth_[index];
    places_[index] = Place::shut;
  }
  tree_.fill(radius);
  for (size_t count = 0; count < reached.size(); ++count) {
    const int point = reached[count];
    places_[point] = Place::reached;
    tree_.take(points_[point], depth_[point], reached);
  }
}

// Of a shut hollow, all up to its walls is shut: what its balls hold.
void Room::shut_hollows() {
  std::vector<double> radius(points_.size(), 0.0);
  for (size_t index = 0; index < points_.size(); ++index)
    if (places_[index] == Place::narrow) radius[index] = std::numeric_limits<double>::min();
  tree_.fill(radius);
  std::vector<int> held;
  for (size_t index = 0; index < points_.size(); ++index)
    if (places_[index] == Place::shut) tree_.take(points_[index], depth_[index], held);
  for (const int point : held) places_[point] = Place::shut;
}

Place Room::place(const Vec& point, double distance) const {
  const auto told = [this](int other) { return places_[other] != Place::narrow; };
  const int nearest = tree_.nearest(point, distance, told).first;
  return nearest < 0 ? Place::unknown : places_[nearest];
}

}  // namespace covers
