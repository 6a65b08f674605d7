#include "point_tree.hpp"

namespace covers {

namespace {
constexpr int kFewPoints = 8;
}

PointTree::PointTree(Points& points) {
  build(points, 0, static_cast<int>(points.size()));
  points_ = points;
}

void PointTree::build(Points& points, int begin, int end) {
  const size_t here = nodes_.size();
  nodes_.emplace_back();
  Box box;
  for (int index = begin; index < end; ++index) box.add(points[index]);
  nodes_[here].box = box;
  nodes_[here].begin = begin, nodes_[here].end = end;
  if (end - begin <= kFewPoints) return;
  const Vec extent = box.extent();
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const int half = begin + (end - begin) / 2;
  std::nth_element(points.begin() + begin, points.begin() + half, points.begin() + end, [axis](const Vec& a, const Vec& b) {
    for (const int other : {axis, (axis + 1) % 3, (axis + 2) % 3})
      if (a[other] != b[other]) return a[other] < b[other];
    return false;
  });
  build(points, begin, half);
  nodes_[here].right = static_cast<int>(nodes_.size());
  build(points, half, end);
}

void PointTree::fill(const std::vector<double>& radius) {
  radius_ = radius;
  for (size_t count = nodes_.size(); count-- > 0;) {  // Children come after their parents.
    Node& node = nodes_[count];
    node.left_over = 0, node.largest = 0.0;
    if (node.right < 0) {
      for (int point = node.begin; point < node.end; ++point)
        if (radius[point] > 0.0) ++node.left_over, node.largest = std::max(node.largest, radius[point]);
      continue;
    }
    const Node &left = nodes_[count + 1], &right = nodes_[node.right];
    node.left_over = left.left_over + right.left_over;
    node.largest = std::max(left.largest, right.largest);
  }
}

void PointTree::take_from(int index, const Vec& place, double radius, std::vector<int>& taken) {
  Node& node = nodes_[index];
  const double reach = std::max(radius, node.largest);
  if (node.left_over == 0 || node.box.squared_distance(place) > reach * reach) return;
  if (node.right >= 0) {
    take_from(index + 1, place, radius, taken);
    take_from(node.right, place, radius, taken);
    node.left_over = nodes_[index + 1].left_over + nodes_[node.right].left_over;
    node.largest = std::max(nodes_[index + 1].largest, nodes_[node.right].largest);
    return;
  }
  double largest = 0.0;
  for (int point = node.begin; point < node.end; ++point) {
    if (!(radius_[point] > 0.0)) continue;
    const double ball = std::max(radius, radius_[point]);
    if (squared(points_[point] - place) > ball * ball) {
      largest = std::max(largest, radius_[point]);
      continue;
    }
    radius_[point] = -1.0;
    --node.left_over;
    taken.push_back(point);
  }
  node.largest = largest;
}

}  // namespace covers
