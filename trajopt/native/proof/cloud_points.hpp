// The centres of a cloud's balls or cubes in a tree of axis-aligned boxes, in the cloud's frame.
//
// Parts of it have numbers: those of nodes first, then those of single points.
#pragma once

#include <vector>

#include "pose.hpp"

namespace proof {

class PointTree {
 public:
  explicit PointTree(std::vector<Vec> points);

  size_t size() const { return points_.size(); }
  const Vec& point(size_t index) const { return points_[index]; }
  int part_of(size_t index) const { return int(nodes_.size() + index); }

  // Call take(part) for the parts that make up a node; false for a single point, which has none.
  template <typename Take>
  bool open(int part, Take take) const {
    if (part >= int(nodes_.size())) return false;
    const Node& node = nodes_[part];
    if (node.second >= 0) {
      take(part + 1);
      take(node.second);
    } else {
      for (int index = node.begin; index < node.end; ++index) take(part_of(size_t(index)));
    }
    return true;
  }

  // Middle and half edges of the box around a part's points.
  const Vec& middle(int part) const { return part < int(nodes_.size()) ? nodes_[part].middle : points_[part - nodes_.size()]; }
  Vec half(int part) const { return part < int(nodes_.size()) ? nodes_[part].half : Vec(Vec::Zero()); }

  // Farthest corner of that box along a direction.
  Vec corner(int part, const Vec& direction) const;
  // Farthest of all points along a direction.
  Vec farthest(const Vec& direction) const;

 private:
  struct Node {
    Vec middle, half;
    int begin, end, second = -1;  // The first child follows its node; without children it holds points.
  };
  static constexpr int most_in_leaf = 16;

  std::vector<Vec> points_;  // In the order of the leaves.
  std::vector<Node> nodes_;
};

}  // namespace proof
