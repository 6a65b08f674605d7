#include "obstacle_tree.hpp"

#include <algorithm>

namespace proof {

ObstacleTree::ObstacleTree(const Bodies& bodies, const std::vector<int>& standing) {
  std::vector<Node> leaves;
  leaves.reserve(standing.size());
  for (const int number : standing) {
    const Body& body = bodies.bodies[number];
    const Vec middle = body.in_joint * Vec((body.form->low + body.form->high) / 2.0);
    const Vec half = body.in_joint.R.cwiseAbs() * ((body.form->high - body.form->low) / 2.0);
    Node leaf;
    leaf.low = middle - half, leaf.high = middle + half, leaf.body = number;
    leaves.push_back(leaf);
  }
  if (leaves.empty()) return;
  nodes_.reserve(2 * leaves.size());
  build(leaves, 0, leaves.size());
}

int ObstacleTree::build(std::vector<Node>& leaves, size_t begin, size_t end) {
  const int number = int(nodes_.size());
  if (end - begin == 1) {
    nodes_.push_back(leaves[begin]);
    return number;
  }
  Node node = leaves[begin];
  node.body = -1;
  for (size_t i = begin + 1; i < end; ++i) {
    node.low = node.low.cwiseMin(leaves[i].low), node.high = node.high.cwiseMax(leaves[i].high);
  }
  nodes_.push_back(node);
  Eigen::Index axis;
  (node.high - node.low).maxCoeff(&axis);
  const size_t middle = begin + (end - begin) / 2;
  std::nth_element(leaves.begin() + begin, leaves.begin() + middle, leaves.begin() + end,
                   [axis](const Node& a, const Node& b) { return (a.low + a.high)[axis] < (b.low + b.high)[axis]; });
  const int left = build(leaves, begin, middle), right = build(leaves, middle, end);
  nodes_[number].left = left, nodes_[number].right = right;
  return number;
}

}  // namespace proof
