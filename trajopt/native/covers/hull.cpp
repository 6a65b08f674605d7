#include "hull.hpp"

#include <utility>

namespace covers {

namespace {

struct Facet {
  std::array<int, 3> corners;
  std::array<int, 3> beside{-1, -1, -1};  // Facet across the edge from corner i to the next.
  Plane plane;
  int first = -1;     // Of the points before it, a list through `next`.
  int farthest = -1;  // Of these.
  double height = 0.0;
  bool alive = true, seen = false;
};

struct Edge {
  int from, to, facet;  // Seen from the facets that stay: `facet` lies behind it.
};

class Quickhull {
 public:
  Quickhull(const Points& points, double accuracy, double rounding)
      : points_(points), accuracy_(std::max(accuracy, rounding)), rounding_(rounding), next_(points.size(), -1), fan_(points.size(), -1) {
    if (!simplex()) return;
    for (size_t count = 0; count < facets_.size(); ++count)
      while (facets_[count].alive && facets_[count].height > accuracy_) extend(static_cast<int>(count));
  }

  Hull hull() const {
    Hull hull;
    std::vector<int> number(points_.size(), -1);
    std::vector<int> used;
    for (const Facet& facet : facets_)
      if (facet.alive)
        for (const int corner : facet.corners)
          if (number[corner] < 0) number[corner] = 0, used.push_back(corner);
    std::sort(used.begin(), used.end());  // In the order of the points.
    for (size_t index = 0; index < used.size(); ++index) {
      number[used[index]] = static_cast<int>(index);
      hull.vertices.push_back(points_[used[index]]);
      hull.box.add(points_[used[index]]);
    }
    for (const Facet& facet : facets_) {
      if (!facet.alive) continue;
      hull.faces.push_back({number[facet.corners[0]], number[facet.corners[1]], number[facet.corners[2]]});
      const auto alike = [&facet](const Plane& plane) {
        return squared(plane.normal - facet.plane.normal) < 1e-18 &&
               std::abs(plane.offset - facet.plane.offset) < 1e-12;
      };
      const size_t recent = std::min<size_t>(hull.planes.size(), 8);
      if (std::none_of(hull.planes.end() - static_cast<long>(recent), hull.planes.end(), alike))
        hull.planes.push_back(facet.plane);
    }
    if (!hull.vertices.empty()) {
      const Vec base = hull.vertices.front();
      for (size_t face = 0; face < hull.faces.size(); ++face) {
        const Triangle t = hull.corners(face);
        hull.volume += dot(t[0] - base, cross(t[1] - base, t[2] - base)) / 6.0;
      }
    }
    return hull;
  }

 private:
  // Start from a tetrahedron as large as is found at once; false if the points lie in a plane.
  bool simplex() {
    std::array<int, 6> extreme{};
    for (size_t index = 0; index < points_.size(); ++index)
      for (int axis = 0; axis < 3; ++axis) {
        if (points_[index][axis] < points_[extreme[2 * axis]][axis]) extreme[2 * axis] = static_cast<int>(index);
        if (points_[index][axis] > points_[extreme[2 * axis + 1]][axis])
          extreme[2 * axis + 1] = static_cast<int>(index);
      }
    int a = 0, b = 0;
    double widest = -1.0;
    for (const int i : extreme)
      for (const int j : extreme)
        if (const double width = squared(points_[i] - points_[j]); width > widest) widest = width, a = i, b = j;
    const Vec along = points_[b] - points_[a];
    int c = most([&](const Vec& p) { return squared(cross(along, p - points_[a])); });
    const Vec across = cross(along, points_[c] - points_[a]);
    const double length = norm(across);
    if (!(length > 0.0)) return false;
    const int d = most([&](const Vec& p) { return std::abs(dot(across, p - points_[a])); });
    const double height = dot(across, points_[d] - points_[a]) / length;
    if (!(std::abs(height) > rounding_)) return false;
    if (height > 0.0) std::swap(b, c);  // d is behind the first face.
    for (const std::array<int, 3>& corners : {std::array<int, 3>{a, b, c}, {a, d, b}, {b, d, c}, {c, d, a}})
      add(corners, {});
    // Facets 1, 2, 3 lie across the edges of the first, and beside each other around d.
    facets_[0].beside = {1, 2, 3};
    facets_[1].beside = {3, 2, 0};
    facets_[2].beside = {1, 3, 0};
    facets_[3].beside = {2, 1, 0};
    for (size_t index = 0; index < points_.size(); ++index) {
      const int i = static_cast<int>(index);
      if (i != a && i != b && i != c && i != d) assign(i, 0);
    }
    return true;
  }

  template <class Measure>
  int most(const Measure& measure) const {
    int best = 0;
    double value = -1.0;
    for (size_t index = 0; index < points_.size(); ++index)
      if (const double here = measure(points_[index]); here > value) value = here, best = static_cast<int>(index);
    return best;
  }

  // Add a facet. One without an area takes the plane of the facet that it continues.
  void add(const std::array<int, 3>& corners, const Plane& otherwise) {
    Facet facet;
    facet.corners = corners;
    const Vec &a = points_[corners[0]], &b = points_[corners[1]], &c = points_[corners[2]];
    const Vec normal = cross(b - a, c - a);
    const double length = norm(normal);
    const double size = std::max({squared(b - a), squared(c - a), squared(c - b)});
    facet.plane = otherwise;
    if (length > 1e-13 * size) {
      facet.plane.normal = 1.0 / length * normal;
      facet.plane.offset = dot(facet.plane.normal, 1.0 / 3.0 * (a + b + c));
    }
    facets_.push_back(facet);
  }

  // Give a point to the facet, from one on, before which it lies farthest.
  void assign(int point, size_t from) {
    double highest = rounding_;
    Facet* best = nullptr;
    for (size_t index = from; index < facets_.size(); ++index)
      if (const double height = facets_[index].plane.height(points_[point]); height > highest)
        highest = height, best = &facets_[index];
    if (best == nullptr) return;
    next_[point] = best->first;
    best->first = point;
    if (highest > best->height) best->height = highest, best->farthest = point;
  }

  // Take in the farthest point of a facet.
  void extend(int start) {
    const int apex = facets_[start].farthest;
    find_visible(start, points_[apex]);
    for (const int index : visible_) facets_[index].seen = false;
    bool simple = true;
    for (const Edge& edge : horizon_) {
      simple = simple && fan_[edge.from] < 0;
      fan_[edge.from] = 0;
    }
    if (!simple) {
      for (const Edge& edge : horizon_) fan_[edge.from] = -1;
      return leave_out(start, apex);
    }
    const size_t first = facets_.size();
    for (const Edge& edge : horizon_) {
      fan_[edge.from] = static_cast<int>(facets_.size());
      add({edge.from, edge.to, apex}, facets_[edge.facet].plane);
      facets_.back().beside[0] = edge.facet;
      Facet& behind = facets_[edge.facet];
      for (int side = 0; side < 3; ++side)
        if (behind.corners[side] == edge.to && behind.corners[(side + 1) % 3] == edge.from)
          behind.beside[side] = static_cast<int>(facets_.size()) - 1;
    }
    for (size_t index = first; index < facets_.size(); ++index) {
      const int after = fan_[facets_[index].corners[1]];
      facets_[index].beside[1] = after;
      facets_[after].beside[2] = static_cast<int>(index);
    }
    for (const Edge& edge : horizon_) fan_[edge.from] = -1;
    for (const int index : visible_) {
      facets_[index].alive = false;
      for (int point = facets_[index].first; point >= 0;) {
        const int following = next_[point];
        if (point != apex) assign(point, first);
        point = following;
      }
    }
  }

  // The facets that see a point, joined to the start, and the edges around them.
  void find_visible(int start, const Vec& apex) {
    visible_.assign(1, start);
    horizon_.clear();
    facets_[start].seen = true;
    for (size_t count = 0; count < visible_.size(); ++count) {
      const Facet& facet = facets_[visible_[count]];
      for (int side = 0; side < 3; ++side) {
        Facet& other = facets_[facet.beside[side]];
        if (other.seen) continue;
        if (other.plane.height(apex) > rounding_) {
          other.seen = true;
          visible_.push_back(facet.beside[side]);
        }
      }
    }
    for (const int index : visible_) {
      const Facet& facet = facets_[index];
      for (int side = 0; side < 3; ++side)
        if (!facets_[facet.beside[side]].seen)
          horizon_.push_back({facet.corners[side], facet.corners[(side + 1) % 3], facet.beside[side]});
    }
  }

  // Rounding left the edges around a point no single loop: the point goes.
  void leave_out(int start, int apex) {
    Facet& facet = facets_[start];
    int* link = &facet.first;
    while (*link != apex) link = &next_[*link];
    *link = next_[apex];
    facet.farthest = -1, facet.height = 0.0;
    for (int point = facet.first; point >= 0; point = next_[point])
      if (const double height = facet.plane.height(points_[point]); height > facet.height)
        facet.height = height, facet.farthest = point;
  }

  const Points& points_;
  double accuracy_, rounding_;
  std::vector<int> next_;  // Of the points before the same facet; -1 at the end.
  std::vector<int> fan_;   // The new facet whose edge begins at a point; -1 for none.
  std::vector<int> visible_;
  std::vector<Edge> horizon_;
  std::vector<Facet> facets_;
};

}  // namespace

std::array<Vec, 3> principal_axes(const Points& points) {
  Vec mean;
  for (const Vec& point : points) mean += point;
  mean = 1.0 / static_cast<double>(points.size()) * mean;
  double a[3][3] = {}, v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const Vec& point : points)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) a[i][j] += (point - mean)[i] * (point - mean)[j];
  for (int sweep = 0; sweep < 12; ++sweep)  // Jacobi's rotations; they converge quadratically.
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (std::abs(a[p][q]) <= 1e-300) continue;
        const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
        const double t = (theta >= 0.0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double kp = a[k][p], kq = a[k][q];
          a[k][p] = c * kp - s * kq, a[k][q] = s * kp + c * kq;
        }
        for (int k = 0; k < 3; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = c * pk - s * qk, a[q][k] = s * pk + c * qk;
          const double vp = v[k][p], vq = v[k][q];
          v[k][p] = c * vp - s * vq, v[k][q] = s * vp + c * vq;
        }
      }
  return {Vec{v[0][0], v[1][0], v[2][0]}, Vec{v[0][1], v[1][1], v[2][1]}, Vec{v[0][2], v[1][2], v[2][2]}};
}

Hull hull_of(Points points, double accuracy) {
  for (const Vec& axis : principal_axes(points)) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Vec& point : points) {
      const double along = dot(axis, point);
      low = std::min(low, along), high = std::max(high, along);
    }
    if (high - low >= kThickness) continue;
    const Vec half = 0.5 * kThickness * axis;
    const size_t count = points.size();
    points.reserve(2 * count);
    for (size_t index = 0; index < count; ++index) {
      points.push_back(points[index] - half);
      points[index] += half;
    }
  }
  const double size = norm(box_around(points).extent());
  return Quickhull(points, accuracy, kExact * size).hull();
}

}  // namespace covers
