#include "cloud_phase.hpp"

#include <algorithm>
#include <array>

namespace proximity {

namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr double kImpossible = 1e3;  // no depth that Coal found is so deep: where it fails it reports the largest float
// Each side of the body's box in four quarters: a number is 8 axis + the signs along all three axes.
constexpr int kSides = 24;
// Of so many the optimiser's steps are good enough, and each row is paid in every one of them.
constexpr std::size_t kMost = 6;
// What would be nearer by less is left out [m]: a twentieth of what the judge resolves.
constexpr double kNegligible = 5e-5;
constexpr unsigned kNegative[] = {0xaa, 0xcc, 0xf0};  // the octants on the negative side of each axis
constexpr std::size_t kPlanes = 8;
// Where nothing is within reach, it is found out by how much up to this [m]: so far a body moves before it is asked again.
constexpr double kBeyond = 0.1;

// Signed distance of a point to a box about the origin, by how far it is beyond each side: minus the way out inside.
double from_sides(const Vector3& apart) {
  const double most = apart.maxCoeff();
  return most > 0.0 ? apart.cwiseMax(0.0).norm() : most;
}

// The other body as the cloud sees it.
struct View {
  View(const Body& a, const coal::Transform3s& at_a, const Body& b, const coal::Transform3s& at_b, bool first_is_cloud)
      : cloud_first(first_is_cloud), cloud(first_is_cloud ? a : b), other(first_is_cloud ? b : a),
        at_cloud(first_is_cloud ? at_a : at_b), at_other(first_is_cloud ? at_b : at_a), tree(cloud.solid->tree()) {
    const Matrix3& rotation = at_cloud.getRotation();
    turn = at_other.getRotation().transpose() * rotation;
    spread = turn.cwiseAbs();
    shift = at_other.getRotation().transpose() * (at_cloud.getTranslation() - at_other.transform(other.middle));
    const bool ball = cloud.element->support.type == coal::GEOM_SPHERE;
    size = other.half;
    if (!ball) size += spread * cloud.element->half;
    radius = ball ? cloud.element->half[0] : 0.0;
  }

  bool cloud_first;
  const Body &cloud, &other;
  coal::Transform3s at_cloud, at_other;
  const CloudTree& tree;
  Matrix3 turn, spread;  // from the cloud's frame to the body's axes; its absolute values
  Vector3 shift;         // of the cloud's origin, along these, from the middle of the body's box
  Vector3 size;          // half the box, with that of a cube
  double radius;         // of a ball
};

// A part of the tree that may be near, and the quarters of sides of the body that it may lie on, a bit each.
struct Entry {
  int node;
  unsigned sides;
  double bound;
};

}  // namespace

class CloudPhase::Search {
 public:
  explicit Search(NarrowPhase& narrow) : narrow_(narrow) {}

  double beyond = kNone;
  Work work;
  std::vector<Nearest> rows;

  void find(const View& seen, double reach);
  bool kept(const View& seen, double reach, int& known);
  void between_clouds(const View& seen, double reach);
  void begin(double reach);
  void collect();
  bool found() const { return found_; }

 private:
  // Along a direction in the cloud's frame every ball or cube is at least at `offset + along . p`.
  struct Plane {
    Vector3 along;
    double offset;
  };
  struct Side {
    double limit;
    bool found;
    Nearest nearest;
  };

  Entry entry(const View& seen, int number) const;
  double limit(unsigned sides) const;
  void look(const View& seen, const CloudTree::Node& node);
  double along_planes(const Vector3& point) const;
  double along_planes(const CloudTree::Node& node) const;
  Nearest measure(const View& seen, int point, double reach, bool depth);
  // What is farther is of no interest: to the sides, or to how far beyond the reach everything is.
  bool dismissed(double bound, double limit) {
    if (bound <= limit) return false;
    if (found_ || bound >= std::min(beyond, farthest_)) {
      beyond = std::min(beyond, std::max(bound, reach_));
      return true;
    }
    return false;
  }

  NarrowPhase& narrow_;
  std::array<Side, kSides> sides_;
  std::array<double, kSides> limits_;  // what is nearer is of interest
  std::vector<Plane> planes_;
  std::size_t next_plane_ = 0;
  std::vector<Entry> open_;
  bool found_ = false;
  double reach_ = 0.0, farthest_ = 0.0;
};

void CloudPhase::Search::begin(double reach) {
  for (Side& side : sides_) side.limit = reach, side.found = false;
  limits_.fill(reach);
  planes_.clear();
  next_plane_ = 0;
  found_ = false;
  reach_ = reach;
  farthest_ = reach + kBeyond;
}

// What was found, the nearest first.
void CloudPhase::Search::collect() {
  rows.clear();
  for (const Side& side : sides_) {
    if (side.found) rows.push_back(side.nearest);
  }
  std::sort(rows.begin(), rows.end(), [](const Nearest& one, const Nearest& other) { return one.distance < other.distance; });
  if (rows.size() > kMost) rows.resize(kMost);
}

Entry CloudPhase::Search::entry(const View& seen, int number) const {
  const CloudTree::Node& node = seen.tree.nodes()[number];
  const Vector3 at = seen.turn * node.middle + seen.shift, wide = seen.spread * node.half;
  const Vector3 apart = at.cwiseAbs() - seen.size, least = apart - wide;
  const double farthest = least.maxCoeff();
  unsigned octants = 0xff, sides = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (at[axis] + wide[axis] < 0.0) octants &= kNegative[axis];
    if (at[axis] - wide[axis] >= 0.0) octants &= ~kNegative[axis];
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (apart[axis] + wide[axis] >= farthest) sides |= octants << (8 * axis);
  }
  return {number, sides, from_sides(least) - seen.radius};
}

double CloudPhase::Search::limit(unsigned sides) const {
  if (!found_) return reach_;
  double most = -kNone;
  for (int side = 0; side < kSides; ++side) {
    if (sides >> side & 1u) most = std::max(most, limits_[side]);
  }
  return most;
}

double CloudPhase::Search::along_planes(const Vector3& point) const {
  double most = -kNone;
  for (const Plane& plane : planes_) most = std::max(most, plane.offset + plane.along.dot(point));
  return most;
}

double CloudPhase::Search::along_planes(const CloudTree::Node& node) const {
  double most = -kNone;
  for (const Plane& plane : planes_) {
    most = std::max(most, plane.offset + plane.along.dot(node.middle) - plane.along.cwiseAbs().dot(node.half));
  }
  return most;
}

void CloudPhase::Search::find(const View& seen, double reach) {
  begin(reach);
  const auto& nodes = seen.tree.nodes();
  open_.assign(1, entry(seen, 0));
  while (!open_.empty()) {
    const Entry at = open_.back();
    open_.pop_back();
    ++work.bounds;
    const double most = limit(at.sides);
    if (dismissed(at.bound, most)) continue;
    const CloudTree::Node& node = nodes[at.node];
    if (!planes_.empty() && dismissed(std::max(at.bound, along_planes(node)), most)) continue;
    if (node.leaf()) {
      look(seen, node);
      continue;
    }
    // The nearer of both is looked at first.
    const Entry one = entry(seen, at.node + 1), other = entry(seen, node.second);
    const bool later = one.bound > other.bound;
    open_.push_back(later ? one : other);
    open_.push_back(later ? other : one);
  }
}

void CloudPhase::Search::look(const View& seen, const CloudTree::Node& node) {
  for (int index = node.begin; index < node.end; ++index) {
    const Vector3& point = seen.tree.point(index);
    const Vector3 at = seen.turn * point + seen.shift, apart = at.cwiseAbs() - seen.size;
    Eigen::Index axis;
    apart.maxCoeff(&axis);
    const int number = static_cast<int>(8 * axis) + (at[0] < 0.0) + 2 * (at[1] < 0.0) + 4 * (at[2] < 0.0);
    Side& side = sides_[number];
    const double most = limits_[number], bound = from_sides(apart) - seen.radius;
    if (dismissed(bound, most) || (!planes_.empty() && dismissed(std::max(bound, along_planes(point)), most))) continue;
    if (bound > most) {
      beyond = std::min(beyond, bound);
      continue;
    }
    const Nearest nearest = measure(seen, index, side.limit, true);
    if (!(std::abs(nearest.distance) < kImpossible)) continue;
    if (nearest.distance < side.limit) {
      side.limit = nearest.distance;
      limits_[number] = nearest.distance - kNegligible;
      side.nearest = nearest;
      side.found = found_ = true;
    } else if (nearest.distance >= reach_) {
      beyond = std::min(beyond, nearest.distance);
    }
  }
}

// A ball or cube and the body, in the order of the pair.
Nearest CloudPhase::Search::measure(const View& seen, int point, double reach, bool depth) {
  ++work.distances;
  const Body& element = *seen.cloud.element;
  const Vector3& centre = seen.tree.point(point);
  const coal::Transform3s at(seen.at_cloud.getRotation(), seen.at_cloud.transform(centre));
  const auto ask = [&](const Body& a, const coal::Transform3s& at_a, const Body& b, const coal::Transform3s& at_b) {
    return depth ? narrow_(a, at_a, b, at_b, reach) : narrow_.keeping(a, at_a, b, at_b, reach);
  };
  const Nearest found = seen.cloud_first ? ask(element, at, seen.other, seen.at_other) : ask(seen.other, seen.at_other, element, at);
  if (found.normal.squaredNorm() > 0.5 && !seen.other.is_mesh()) {
    const Vector3 along = seen.at_cloud.getRotation().transpose() * (seen.cloud_first ? -1.0 : 1.0) * found.normal;
    const Plane plane{along, found.distance - along.dot(centre)};
    if (planes_.size() < kPlanes) {
      planes_.push_back(plane);
    } else {
      planes_[next_plane_++ % kPlanes] = plane;
    }
  }
  return found;
}

// Of two clouds the nearest two: each ball or cube of the smaller one is a body that the other sees.
void CloudPhase::Search::between_clouds(const View& seen, double reach) {
  const CloudTree& others = seen.other.solid->tree();
  const bool fewer = others.nodes()[0].end < seen.tree.nodes()[0].end;
  const Body &many = fewer ? seen.cloud : seen.other, &few = fewer ? seen.other : seen.cloud;
  const coal::Transform3s &at_many = fewer ? seen.at_cloud : seen.at_other, &at_few = fewer ? seen.at_other : seen.at_cloud;
  const CloudTree& tree = fewer ? others : seen.tree;
  const bool many_first = fewer == seen.cloud_first;
  begin(reach);
  Side best = sides_[0];
  for (int index = 0; index < tree.nodes()[0].end; ++index) {
    const coal::Transform3s at(at_few.getRotation(), at_few.transform(tree.point(index)));
    const View each = many_first ? View(many, at_many, *few.element, at, true) : View(*few.element, at, many, at_many, false);
    find(each, best.limit);
    for (const Side& side : sides_) {
      if (side.found && side.limit < best.limit) best = side;
    }
  }
  begin(reach);
  sides_[0] = best;
  found_ = best.found;
}

bool CloudPhase::Search::kept(const View& seen, double reach, int& known) {
  begin(reach);
  if (known >= 0 && !(measure(seen, known, reach, false).distance >= reach)) return false;
  const auto& nodes = seen.tree.nodes();
  open_.assign(1, entry(seen, 0));
  while (!open_.empty()) {
    const Entry at = open_.back();
    open_.pop_back();
    ++work.bounds;
    const CloudTree::Node& node = nodes[at.node];
    if (at.bound > reach || (!planes_.empty() && along_planes(node) > reach)) continue;
    if (!node.leaf()) {
      const Entry one = entry(seen, at.node + 1), other = entry(seen, node.second);
      const bool later = one.bound > other.bound;
      if (!((later ? one : other).bound > reach)) open_.push_back(later ? one : other);
      if (!((later ? other : one).bound > reach)) open_.push_back(later ? other : one);
      continue;
    }
    for (int index = node.begin; index < node.end; ++index) {
      const Vector3& point = seen.tree.point(index);
      const Vector3 apart = (seen.turn * point + seen.shift).cwiseAbs() - seen.size;
      if (from_sides(apart) - seen.radius > reach || along_planes(point) > reach) continue;
      if (!(measure(seen, index, reach, false).distance >= reach)) {
        known = index;
        return false;
      }
    }
  }
  return true;
}

CloudPhase::CloudPhase(NarrowPhase& narrow) : search_(std::make_unique<Search>(narrow)) {}
CloudPhase::~CloudPhase() = default;

const std::vector<Nearest>& CloudPhase::rows(const Body& a, const coal::Transform3s& at_a, const Body& b,
                                             const coal::Transform3s& at_b, double reach) {
  const View seen(a, at_a, b, at_b, a.element != nullptr);
  search_->beyond = kNone;
  if (seen.other.element != nullptr) {
    search_->between_clouds(seen, reach);
  } else {
    search_->find(seen, reach);
  }
  search_->collect();
  return search_->rows;
}

double CloudPhase::beyond() const { return search_->beyond; }

bool CloudPhase::keeps(const Body& a, const coal::Transform3s& at_a, const Body& b, const coal::Transform3s& at_b, double reach,
                       int& known) {
  const View seen(a, at_a, b, at_b, a.element != nullptr);
  if (seen.other.element == nullptr) return search_->kept(seen, reach, known);
  search_->between_clouds(seen, reach);
  return !search_->found();
}

void CloudPhase::tell(Work& work) {
  work.bounds += search_->work.bounds;
  work.distances += search_->work.distances;
  search_->work = Work();
}

}  // namespace proximity
