#include "cloud_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace proof {

namespace {

constexpr int bits_along = 10, digits = 1 << bits_along;

struct Around {
  Vec low, high;
};

Around around(const std::vector<Vec>& points, int begin, int end) {
  Around box{points[begin], points[begin]};
  for (int i = begin + 1; i < end; ++i) box.low = box.low.cwiseMin(points[i]), box.high = box.high.cwiseMax(points[i]);
  return box;
}

// Ten bits, two places between each.
std::uint32_t spread_bits(std::uint32_t bits) {
  bits = (bits | bits << 16) & 0x030000ff;
  bits = (bits | bits << 8) & 0x0300f00f;
  bits = (bits | bits << 4) & 0x030c30c3;
  return (bits | bits << 2) & 0x09249249;
}

int highest_bit(std::uint32_t bits) {
  int bit = 0;
  while (bits >>= 1) ++bit;
  return bit;
}

// A point's place in Morton's order, in which each half of the numbers is one half of a box, and so on.
struct Placed {
  std::uint32_t place;
  int point;
};

// Places of all points, in order.
std::vector<Placed> in_order(const std::vector<Vec>& points) {
  const Around box = around(points, 0, int(points.size()));
  const double edge = (box.high - box.low).maxCoeff() * (1.0 + 1e-9) / digits;
  const double scale = edge > 0.0 ? 1.0 / edge : 0.0;
  std::vector<Placed> placed(points.size()), sorted(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    std::uint32_t place = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int cell = std::min(int((points[i][axis] - box.low[axis]) * scale), digits - 1);
      place |= spread_bits(std::uint32_t(cell)) << axis;
    }
    placed[i] = {place, int(i)};
  }
  for (int shift = 0; shift < 3 * bits_along; shift += bits_along) {
    std::vector<int> next(digits + 1, 0);
    for (const Placed& each : placed) ++next[(each.place >> shift & (digits - 1)) + 1];
    for (int digit = 0; digit < digits; ++digit) next[digit + 1] += next[digit];
    for (const Placed& each : placed) sorted[next[each.place >> shift & (digits - 1)]++] = each;
    placed.swap(sorted);
  }
  return placed;
}

}  // namespace

PointTree::PointTree(std::vector<Vec> points) : points_(points.size()) {
  nodes_.reserve(points.size() / 4 + 1);
  const std::vector<Placed> placed = in_order(points);
  for (size_t i = 0; i < placed.size(); ++i) points_[i] = points[placed[i].point];
  const auto grow = [&](const auto& self, int begin, int end) -> Around {
    const size_t number = nodes_.size();
    nodes_.push_back({Vec::Zero(), Vec::Zero(), begin, end, -1});
    Around box;
    if (end - begin <= most_in_leaf) {
      box = around(points_, begin, end);
    } else {
      // The highest bit in which two places differ halves the box; where none does, any half will do.
      int split = begin + (end - begin) / 2;
      const std::uint32_t apart = placed[begin].place ^ placed[end - 1].place;
      if (apart != 0) {
        const std::uint32_t upper = placed[end - 1].place & ~((std::uint32_t{1} << highest_bit(apart)) - 1);
        split = int(std::lower_bound(placed.begin() + begin, placed.begin() + end, upper,
                                     [](const Placed& each, std::uint32_t place) { return each.place < place; }) -
                    placed.begin());
      }
      const Around one = self(self, begin, split);
      nodes_[number].second = int(nodes_.size());
      const Around other = self(self, split, end);
      box = {one.low.cwiseMin(other.low), one.high.cwiseMax(other.high)};
    }
    // Half a box is rounded up, so that no rounding leaves a point outside.
    Node& node = nodes_[number];
    node.middle = (box.low + box.high) / 2.0;
    node.half = (box.high - node.middle).cwiseMax(node.middle - box.low);
    return box;
  };
  grow(grow, 0, int(points_.size()));
}

Vec PointTree::corner(int part, const Vec& d) const {
  if (part >= int(nodes_.size())) return points_[part - nodes_.size()];
  const Node& node = nodes_[part];
  return {node.middle.x() + std::copysign(node.half.x(), d.x()), node.middle.y() + std::copysign(node.half.y(), d.y()),
          node.middle.z() + std::copysign(node.half.z(), d.z())};
}

Vec PointTree::farthest(const Vec& d) const {
  double best = -std::numeric_limits<double>::infinity();
  int found = 0;
  std::vector<int> left{0};
  while (!left.empty()) {
    const Node& node = nodes_[left.back()];
    const int number = left.back();
    left.pop_back();
    if (d.dot(node.middle) + d.cwiseAbs().dot(node.half) <= best) continue;
    if (node.second >= 0) {
      left.push_back(number + 1);
      left.push_back(node.second);
      continue;
    }
    for (int i = node.begin; i < node.end; ++i) {
      if (d.dot(points_[i]) > best) best = d.dot(points_[i]), found = i;
    }
  }
  return points_[found];
}

}  // namespace proof
