// The triangles of an exact mesh in a tree of oriented boxes, and whether the surface winds around a point.
//
// Source of the tree: Gottschalk, Lin, Manocha, OBBTree, SIGGRAPH 1996. Source of the far field of the solid angle:
// Barill et al., Fast winding numbers for soups and clouds, ACM Trans. Graphics 2018 (first order).
#pragma once

#include <array>

#include "form.hpp"

namespace proof {

struct SurfaceTree {
  struct Node {
    Vec centre, half;  // Box about the centre, edges along the columns of `axes`.
    Mat axes;
    int left = -1, right = -1;  // Children; -1 for a leaf, which is one triangle.
    std::array<Vec, 3> corners;
    Vec area = Vec::Zero(), middle = Vec::Zero();  // Sum of normals times areas, and where it acts.
    double radius = 0.0;                           // Of all triangles about the middle.

    bool leaf() const { return left < 0; }
  };

  std::vector<Node> nodes;  // The first is the root.

  using Triangles = std::vector<std::array<Vec, 3>>;
  explicit SurfaceTree(Triangles triangles);

  Vec support(int node, const Vec& direction) const;
  // Whether a closed surface winds around a point, seen counter-clockwise from outside; small gaps do no harm.
  bool encloses(const Vec& point) const;

 private:
  int build(Triangles& triangles, size_t begin, size_t end);
  double solid_angle(const Vec& point, double far_factor) const;
};

}  // namespace proof
