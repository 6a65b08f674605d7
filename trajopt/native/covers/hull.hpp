// The convex hull of points: quickhull (Barber, Dobkin, Huhdanpaa, ACM Trans. Math. Software 1996).
#pragma once

#include "vec.hpp"

namespace covers {

// Least thickness of a hull [m]: to flatter points as much is added, half on either side.
constexpr double kThickness = 1e-4;

// A share of the size of the points: those nearer to a face than that are taken as in it. Doubles carry 1e-16 of the
// size, of which the normals of slender faces lose some digits.
constexpr double kExact = 1e-12;

struct Hull {
  Points vertices;                        // Extreme points.
  std::vector<std::array<int, 3>> faces;  // Of vertices, counter-clockwise seen from outside.
  std::vector<Plane> planes;              // Of the faces, outward; those alike within the accuracy once.
  Box box;
  double volume = 0.0;

  // Whether a point lies strictly inside.
  bool holds(const Vec& point) const {
    if (!box.holds(point)) return false;
    for (const Plane& plane : planes)
      if (plane.height(point) > -1e-9) return false;
    return true;
  }
  // How far a point lies before the farthest plane [m]; negative inside.
  double height(const Vec& point) const {
    double highest = -HUGE_VAL;
    for (const Plane& plane : planes) highest = std::max(highest, plane.height(point));
    return highest;
  }
  Triangle corners(size_t face) const {
    const auto& f = faces[face];
    return {vertices[f[0]], vertices[f[1]], vertices[f[2]]};
  }
};

// The hull of at least one point. Points may be left out that stand out by less than `accuracy` [m].
Hull hull_of(Points points, double accuracy = 0.0);

}  // namespace covers
