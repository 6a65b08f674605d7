// Convex pieces whose union contains the surface of a mesh.
#pragma once

#include <cstdint>

#include "stand_out.hpp"

namespace covers {

// Pieces may stand out so much more than the tolerance between the points looked at: share of it. Less costs large
// meshes of few faces twice as many pieces.
constexpr double kBetween = 0.5;

// How far pieces stand out is known to such a share of the tolerance.
constexpr double kSettled = 0.05;

// Tolerances by which pieces stand out at most, where the work suffices that they may cost.
constexpr double kFarthest = 1.0 + kBetween + kSettled;

struct Options {
  double hull_excess = 0.05;  // Share of the mesh's volume that its hull may add.
  double tolerance = 0.01;    // Farthest that pieces may stand out of the mesh [m].
  int most_pieces = 64;
  int samples = 60000;        // Points looked at in the hull.
  double most_work = 1e9;     // Steps that cutting may cost, and merging as many again.
};

struct Cover {
  std::vector<Points> pieces;  // Extreme points of each.
  bool cut = false;            // Or one piece, the hull.
  double excess = 0.0;         // Of the hull, as a share of the mesh's volume; not a number where nobody asked.
  double reach = 0.0;          // No piece stands out farther [m].
};

// parts: of each face the number of the closed part it belongs to; below 0 for those that bound no solid.
Cover cover(const Indexed& mesh, const std::vector<int>& parts, const Options& options);

}  // namespace covers
