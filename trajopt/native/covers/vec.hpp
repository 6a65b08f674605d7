// Points, planes and triangles in space, in plain doubles: the core needs no library.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace covers {

struct Vec {
  double x = 0.0, y = 0.0, z = 0.0;

  double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  Vec& operator+=(const Vec& b) {
    x += b.x, y += b.y, z += b.z;
    return *this;
  }
  bool operator==(const Vec& b) const { return x == b.x && y == b.y && z == b.z; }
};

inline Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(double s, const Vec& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double squared(const Vec& a) { return dot(a, a); }
inline double norm(const Vec& a) { return std::sqrt(dot(a, a)); }
inline Vec least(const Vec& a, const Vec& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
inline Vec most(const Vec& a, const Vec& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

// All x with dot(normal, x) = offset; behind it where that is smaller.
struct Plane {
  Vec normal;
  double offset = 0.0;

  double height(const Vec& point) const { return dot(normal, point) - offset; }
};

using Triangle = std::array<Vec, 3>;
using Points = std::vector<Vec>;
using Triangles = std::vector<Triangle>;

// Corners, each once, and which of them each triangle has.
struct Indexed {
  Points corners;
  std::vector<std::array<int, 3>> faces;

  Triangles triangles() const {
    Triangles all;
    for (const auto& face : faces) all.push_back({corners[face[0]], corners[face[1]], corners[face[2]]});
    return all;
  }
};

struct Box {
  Vec low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  void add(const Vec& point) { low = least(low, point), high = most(high, point); }
  Vec extent() const { return high - low; }
  bool holds(const Vec& p) const {
    return p.x > low.x && p.y > low.y && p.z > low.z && p.x < high.x && p.y < high.y && p.z < high.z;
  }
  // Squared distance of a point to the box; 0 inside.
  double squared_distance(const Vec& p) const {
    const Vec out = most(most(low - p, p - high), {});
    return squared(out);
  }
};

inline Box box_around(const Points& points) {
  Box box;
  for (const Vec& point : points) box.add(point);
  return box;
}

// Three directions at right angles along which points lie, the rows of a rotation: eigenvectors of their scatter.
std::array<Vec, 3> principal_axes(const Points& points);

}  // namespace covers
