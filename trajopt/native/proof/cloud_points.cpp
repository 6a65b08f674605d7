#include "cloud_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proof {

PointTree::PointTree(std::vector<Vec> points) : points_(std::move(points)) {
  nodes_.reserve(points_.size() / 2 + 1);
  build(0, int(points_.size()));
}

void PointTree::build(int begin, int end) {
  Vec low = points_[begin], high = low;
  for (int i = begin + 1; i < end; ++i) low = low.cwiseMin(points_[i]), high = high.cwiseMax(points_[i]);
  const size_t number = nodes_.size();
  // Half a box is rounded up, so that no rounding leaves a point outside.
  const Vec middle = (low + high) / 2.0;
  const Vec half = (high - middle).cwiseMax(middle - low);
  nodes_.push_back({middle, half, begin, end, -1});
  if (end - begin <= most_in_leaf) return;
  Eigen::Index axis;
  half.maxCoeff(&axis);
  int split = begin;
  for (int i = begin; i < end; ++i) {
    if (points_[i][axis] <= middle[axis]) std::swap(points_[i], points_[split++]);
  }
  // Unless one half holds nearly all: then the tree would grow deep.
  if (std::min(split - begin, end - split) < (end - begin) / least_share) {
    split = begin + (end - begin) / 2;
    std::nth_element(points_.begin() + begin, points_.begin() + split, points_.begin() + end,
                     [axis](const Vec& a, const Vec& b) { return a[axis] < b[axis]; });
  }
  build(begin, split);
  nodes_[number].second = int(nodes_.size());
  build(split, end);
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
