// Points in a tree of boxes: the nearest one, and those that balls around them connect.
#pragma once

#include "vec.hpp"

namespace covers {

class PointTree {
 public:
  // Sorts the points so that neighbours lie side by side.
  explicit PointTree(Points& points);

  // The number of the point nearest to a place, of those for which `counts` holds, and its distance; -1 if none is
  // nearer than `within`.
  template <class Counts>
  std::pair<int, double> nearest(const Vec& place, double within, const Counts& counts) const;

  // Give every point the radius of a ball around it, and put those with a radius above 0 into the tree.
  void fill(const std::vector<double>& radius);
  // Take out of the tree, and add to a list, the points whose ball holds a place, or that lie in the place's ball.
  void take(const Vec& place, double radius, std::vector<int>& taken) { take_from(0, place, radius, taken); }

 private:
  struct Node {
    Box box;
    int begin = 0, end = 0, right = -1;  // The left child follows; right is -1 for a leaf.
    int left_over = 0;                   // Points not yet taken.
    double largest = 0.0;                // Radius of these, or of some that were taken.
  };

  void build(Points& points, int begin, int end);
  void take_from(int index, const Vec& place, double radius, std::vector<int>& taken);

  Points points_;
  std::vector<Node> nodes_;
  std::vector<double> radius_;  // Below 0 for points that are taken.
};

template <class Counts>
std::pair<int, double> PointTree::nearest(const Vec& place, double within, const Counts& counts) const {
  double best = within * within;
  int found = -1;
  std::array<std::pair<int, double>, 64> stack;
  int depth = 0;
  if (!points_.empty()) stack[depth++] = {0, nodes_[0].box.squared_distance(place)};
  while (depth > 0) {
    const auto [index, bound] = stack[--depth];
    if (bound >= best) continue;
    const Node& node = nodes_[index];
    if (node.right < 0) {
      for (int point = node.begin; point < node.end; ++point)
        if (const double here = squared(points_[point] - place); here < best && counts(point))
          best = here, found = point;
      continue;
    }
    const std::pair left{index + 1, nodes_[index + 1].box.squared_distance(place)};
    const std::pair right{node.right, nodes_[node.right].box.squared_distance(place)};
    stack[depth++] = left.second <= right.second ? right : left;
    stack[depth++] = left.second <= right.second ? left : right;
  }
  return {found, std::sqrt(best)};
}

}  // namespace covers
