// The triangles of a mesh: how far they are from a point, and which points lie in the closed parts that they make.
#pragma once

#include <cstdint>

#include "vec.hpp"

namespace covers {

struct Near {
  double distance = HUGE_VAL;  // [m]
  int triangle = -1;
};

class Surface {
 public:
  // parts: of each triangle the number of its part; below 0 for those that bound no solid.
  Surface(Triangles triangles, std::vector<int> parts);

  // The triangle nearest to a point. Where one is near by, naming it as the guess saves most of the work.
  Near nearest(const Vec& point, int guess = -1) const;
  double distance(const Vec& point, int triangle) const;

  // Which points lie in the solid, 1 or 0: in at least one closed part, by the even-odd rule, along two generic
  // directions, and a third where those differ.
  std::vector<std::uint8_t> contains(const Points& points) const;

  const Triangles& triangles() const { return triangles_; }

 private:
  struct Node {
    Box box;
    int begin = 0, end = 0;  // Triangles of a leaf.
    int right = -1;          // The left child follows; -1 for a leaf.
  };

  void build(std::vector<int>& order, const Points& centres, int begin, int end);
  std::vector<std::uint8_t> contains_along(int first, const Points& points) const;

  Triangles triangles_;  // In the order of the leaves.
  std::vector<int> parts_;
  std::vector<Node> nodes_;
};

}  // namespace covers
