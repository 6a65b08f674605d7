// What stands still in the world, in a tree of axis-aligned boxes: finds what is near a sphere.
#pragma once

#include <limits>

#include "bodies.hpp"

namespace proof {

class ObstacleTree {
 public:
  ObstacleTree() = default;
  ObstacleTree(const Bodies& bodies, const std::vector<int>& standing);

  // Call take(body) for every body whose box is within a distance of a point. Returns a lower bound of the distance
  // of the point from all others [m].
  template <typename Take>
  double visit(const Vec& point, double within, Take take) const {
    double beyond = std::numeric_limits<double>::infinity();
    if (nodes_.empty()) return beyond;
    int open[64], count = 0;
    open[count++] = 0;
    while (count > 0) {
      const Node& node = nodes_[open[--count]];
      const double distance = (node.low - point).cwiseMax(point - node.high).cwiseMax(0.0).norm();
      if (distance > within) {
        beyond = std::min(beyond, distance);
      } else if (node.left < 0) {
        take(node.body);
      } else {
        open[count++] = node.left;
        open[count++] = node.right;
      }
    }
    return beyond;
  }

 private:
  struct Node {
    Vec low, high;
    int left = -1, right = -1, body = -1;
  };
  std::vector<Node> nodes_;
  int build(std::vector<Node>& leaves, size_t begin, size_t end);
};

}  // namespace proof
