#include "polytope.hpp"

#include <algorithm>
#include <cmath>

namespace proximity {

Polytope::Polytope(const coal::ConvexBase& convex)
    : vertices_(convex.points->begin(), convex.points->begin() + convex.num_points) {
  if (vertices_.size() <= kFew || convex.neighbors == nullptr) return;
  first_.push_back(0);
  for (std::size_t vertex = 0; vertex < vertices_.size(); ++vertex) {
    const auto& around = (*convex.neighbors)[vertex];
    for (int edge = 0; edge < around.count(); ++edge) neighbours_.push_back(static_cast<std::int32_t>(around[edge]));
    first_.push_back(static_cast<std::int32_t>(neighbours_.size()));
  }
  squares_ = static_cast<int>(std::ceil(std::sqrt(kSquares * static_cast<double>(vertices_.size()) / 6.0)));
  fill_squares();
}

const Polytope::Vector3& Polytope::farthest(const Vector3& direction) const {
  if (squares_ > 0) return vertices_[climb(starts_[square(direction)], direction)];
  std::size_t best = 0;
  double most = vertices_[0].dot(direction);
  for (std::size_t vertex = 1; vertex < vertices_.size(); ++vertex) {
    const double along = vertices_[vertex].dot(direction);
    best = along > most ? vertex : best;
    most = along > most ? along : most;
  }
  return vertices_[best];
}

// Go from a vertex to the farthest of its neighbours until none is farther.
std::int32_t Polytope::climb(std::int32_t vertex, const Vector3& direction) const {
  double most = vertices_[vertex].dot(direction);
  for (std::int32_t here = -1; here != vertex;) {
    here = vertex;
    for (std::int32_t edge = first_[here]; edge < first_[here + 1]; ++edge) {
      const std::int32_t other = neighbours_[edge];
      const double along = vertices_[other].dot(direction);
      vertex = along > most ? other : vertex;
      most = along > most ? along : most;
    }
  }
  return vertex;
}

// Which square of the cube a direction meets.
int Polytope::square(const Vector3& direction) const {
  const double x = std::abs(direction[0]), y = std::abs(direction[1]), z = std::abs(direction[2]);
  const int axis = x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
  constexpr int kNext[] = {1, 2, 0, 1};
  const double longest = std::abs(direction[axis]), middle = 0.5 * squares_;
  if (!(longest > 0.0)) return 0;
  const double scale = middle / longest;
  const int row = std::min(squares_ - 1, static_cast<int>(direction[kNext[axis]] * scale + middle));
  const int column = std::min(squares_ - 1, static_cast<int>(direction[kNext[axis + 1]] * scale + middle));
  return ((2 * axis + (direction[axis] < 0.0)) * squares_ + row) * squares_ + column;
}

void Polytope::fill_squares() {
  starts_.assign(6 * static_cast<std::size_t>(squares_) * squares_, 0);
  // A vertex of some face: a point that no face uses leads nowhere. Each square starts where the one before it ended.
  std::int32_t vertex = 0;
  while (first_[vertex] == first_[vertex + 1] && vertex + 1 < static_cast<std::int32_t>(vertices_.size())) ++vertex;
  Vector3 middle;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    for (int row = 0; row < squares_; ++row) {
      for (int column = 0; column < squares_; ++column) {
        middle[axis] = face % 2 ? -1.0 : 1.0;
        middle[(axis + 1) % 3] = (2.0 * row + 1.0) / squares_ - 1.0;
        middle[(axis + 2) % 3] = (2.0 * column + 1.0) / squares_ - 1.0;
        starts_[square(middle)] = vertex = climb(vertex, middle);
      }
    }
  }
}

}  // namespace proximity
