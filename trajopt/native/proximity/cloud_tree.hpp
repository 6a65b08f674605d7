// The balls or cubes of a cloud in a tree of axis-aligned boxes, in the cloud's own frame.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <vector>

namespace proximity {

class CloudTree {
 public:
  using Vector3 = Eigen::Vector3d;

  // About the centres of the points `begin` to `end`; the first child of an inner node follows it.
  struct Node {
    Vector3 middle, half;
    std::int32_t begin, end, second;
    bool leaf() const { return second < 0; }
  };

  explicit CloudTree(std::vector<Vector3> points);

  const std::vector<Node>& nodes() const { return nodes_; }
  const Vector3& point(int index) const { return points_[index]; }

 private:
  // Fewer make a tree of more nodes than points, of more a box says little.
  static constexpr int kLeaf = 8;
  // A box is cut in the middle, which takes no sorting, unless one half would hold less than this share of the points.
  static constexpr int kShare = 16;

  void build(int begin, int end);
  int cut(int begin, int end, const Vector3& middle, int axis);

  std::vector<Vector3> points_;  // in the order of the leaves
  std::vector<Node> nodes_;      // the first is the root
};

}  // namespace proximity
