// The farthest vertex of a convex polytope along a direction, whatever was asked before.
//
// From a vertex that is farthest along a direction nearby, over edges to the neighbour that is farther, until none is:
// on a convex polytope that is the farthest of all. The first vertex is looked up on a cube around the polytope whose
// faces are cut into squares, so it is one or two edges away, and the answer does not hang on where the last search ended.
#pragma once

#include <coal/shape/geometric_shapes.h>

#include <cstdint>
#include <vector>

namespace proximity {

class Polytope {
 public:
  using Vector3 = Eigen::Vector3d;

  explicit Polytope(const coal::ConvexBase& convex);

  const Vector3& farthest(const Vector3& direction) const;

 private:
  // Up to so many vertices are all looked at: a climb looks at a vertex and its six neighbours about twice.
  static constexpr std::size_t kFew = 14;
  // Squares for each vertex: enough that most directions meet one that starts at their farthest vertex.
  static constexpr double kSquares = 4.0;

  std::int32_t climb(std::int32_t vertex, const Vector3& direction) const;
  int square(const Vector3& direction) const;
  void fill_squares();

  std::vector<Vector3> vertices_;
  std::vector<std::int32_t> first_, neighbours_;  // those of vertex v: neighbours_[first_[v]] to [first_[v + 1]]
  std::vector<std::int32_t> starts_;              // by square; none where all vertices are looked at
  int squares_ = 0;                               // along an edge of the cube
};

}  // namespace proximity
