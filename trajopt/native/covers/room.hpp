// The room around a mesh within its hull: where something can get to from outside, and how far that is from the mesh.
#pragma once

#include <cstdint>

#include "hull.hpp"
#include "point_tree.hpp"
#include "surface.hpp"

namespace covers {

// What is at a place.
enum class Place : std::uint8_t {
  solid,    // Inside the mesh.
  shut,     // A hollow that a ball of the tolerance's radius cannot enter.
  narrow,   // Outside, nearer to the mesh than the tolerance.
  reached,  // Outside, farther than that, and a ball can get there.
  unknown,
};

// Places, and how far each is from the mesh.
struct Samples {
  Points points;
  std::vector<double> depth;

  void add(const Vec& point, double deep) { points.push_back(point), depth.push_back(deep); }
  double deepest() const {
    double most = 0.0;
    for (const double deep : depth) most = std::max(most, deep);
    return most;
  }
  double sum() const {
    double sum = 0.0;
    for (const double deep : depth) sum += deep;
    return sum;
  }
};

class Room {
 public:
  // Looks at `count` points spread evenly in the hull: the same ones at every run.
  Room(const Surface& surface, const Hull& hull, int count, double tolerance);

  // What is at a place that lies `distance` from the mesh: told by the points looked at in the ball of that radius,
  // which the mesh nowhere crosses.
  Place place(const Vec& point, double distance) const;

  Samples wrong;         // The points reached.
  double excess = 0.0;   // Volume of the hull beyond the mesh's, as a share of it; shut hollows count as the mesh's.
  double reach = 0.0;    // Distance from the mesh of the farthest point of the hull where something can get to [m].

 private:
  void measure(const Surface& surface);
  void flood(const Hull& hull);
  void shut_hollows();

  double tolerance_;
  Points points_;
  PointTree tree_;
  std::vector<Place> places_;
  std::vector<double> depth_;  // Of points outside.
};

}  // namespace covers
