// Triangles on both sides of a plane, and the planes worth a cut.
#pragma once

#include "room.hpp"

namespace covers {

// Cut triangles at a plane: those behind it and those before it, which together cover the given ones. Corners at most
// `snap` from the plane count as in it, and stay where they are. A triangle in the plane is behind if it faces along
// the normal, as is the solid that it bounds; but where all others are on one side, those in the plane are on the
// other.
std::array<Triangles, 2> clipped(const Triangles& triangles, const Plane& plane, double snap);

// Planes of the largest faces, and planes through the wrong points along the axes, the principal axes and the largest
// faces' normals.
std::vector<Plane> planes_worth_a_cut(const Triangles& triangles, const Points& wrong);

// The corners of triangles, each once.
Indexed indexed(const Triangles& triangles);

// The corners and the area of what `clipped` returns, behind the plane and before it.
struct Side {
  Points corners;
  double area = 0.0;  // Twice [m^2].
};
std::array<Side, 2> clipped_corners(const Indexed& triangles, const Plane& plane, double snap);

// Fewer triangles in about the same place: corners in one cell of a grid become one of them. Cells grow until at most
// so many triangles are left, but not beyond a size [m].
Triangles coarser(const Triangles& triangles, size_t most, double largest_cell);

}  // namespace covers
