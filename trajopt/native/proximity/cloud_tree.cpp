#include "cloud_tree.hpp"

#include <algorithm>

namespace proximity {

CloudTree::CloudTree(std::vector<Vector3> points) : points_(std::move(points)) {
  nodes_.reserve(points_.size() / 2 + 1);
  build(0, static_cast<int>(points_.size()));
}

void CloudTree::build(int begin, int end) {
  Vector3 low = points_[begin], high = low;
  for (int index = begin + 1; index < end; ++index) {
    low = low.cwiseMin(points_[index]);
    high = high.cwiseMax(points_[index]);
  }
  const std::size_t number = nodes_.size();
  nodes_.push_back({(low + high) / 2.0, (high - low) / 2.0, begin, end, -1});
  if (end - begin <= kLeaf) return;
  Eigen::Index axis;
  (high - low).maxCoeff(&axis);
  const int middle = cut(begin, end, (low + high) / 2.0, static_cast<int>(axis));
  build(begin, middle);
  nodes_[number].second = static_cast<std::int32_t>(nodes_.size());
  build(middle, end);
}

// Put the points on the lower side of a place first, and return where those on the upper side begin.
int CloudTree::cut(int begin, int end, const Vector3& middle, int axis) {
  const auto first = points_.begin();
  const auto at = std::partition(first + begin, first + end, [&](const Vector3& point) { return point[axis] < middle[axis]; });
  const int found = static_cast<int>(at - first);
  if (std::min(found - begin, end - found) * kShare >= end - begin) return found;
  const int half = begin + (end - begin) / 2;
  std::nth_element(first + begin, first + half, first + end,
                   [axis](const Vector3& a, const Vector3& b) { return a[axis] < b[axis]; });
  return half;
}

}  // namespace proximity
