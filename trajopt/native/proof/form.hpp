// Shapes as the judge sees them: how far they reach along a direction, and little more.
//
// Each has its origin where trajopt.values.shapes.shapes has it. A sphere and a capsule are a point and a segment,
// rounded: the distance of the cores less the radii is exact, in shallow penetration too.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "pose.hpp"

namespace coal {
class CollisionGeometry;
}

namespace proof {

class PointTree;
struct SurfaceTree;

enum class Kind { Box, Sphere, Cylinder, Capsule, Cone, Plane, Convex, Mesh, Cloud };

struct Form {
  Kind kind = Kind::Sphere;
  Vec half = Vec::Zero();  // Box, and each cube of a cloud: half edges. Round shapes: (radius, radius, half length).
  double rounding = 0.0;   // Radius by which the core is rounded [m].
  Vec low = Vec::Zero(), high = Vec::Zero();  // Axis-aligned box in the shape's own frame.
  Vec centre = Vec::Zero();                   // Of a sphere around it ...
  double radius = 0.0;                        // ... and its radius, infinite for planes.
  std::vector<double> x, y, z;                // Vertices of a convex hull or mesh.
  std::vector<Eigen::Vector3i> faces;
  std::vector<int> first_neighbour, neighbours;  // Of each vertex of a large hull; empty for small ones.
  std::array<int, 8> corners{};                  // Of a large hull, the farthest vertex into each octant.
  std::shared_ptr<const Form> hull;           // Of a mesh.
  std::shared_ptr<const SurfaceTree> tree;    // Of a mesh.
  std::shared_ptr<const SurfaceTree> shell;   // Of a mesh's closed parts, which have an inside; null without any.
  std::shared_ptr<const PointTree> points;    // Of a cloud: the centres of its balls or cubes ...
  std::shared_ptr<const Form> element;        // ... and one of these about the origin.
  std::vector<Vec> representatives;           // One point of each connected part.

  mutable std::once_flag coal_once;           // Coal's twin is made when it is first asked for.
  mutable std::shared_ptr<const coal::CollisionGeometry> coal;

  // Farthest point of the core along a direction of any length; of a mesh, that of its hull.
  Vec core_support(const Vec& direction) const;
  // Largest direction @ point over the shape's points, for a unit direction.
  double reach(const Vec& direction) const { return direction.dot(core_support(direction)) + rounding; }
};

// A union of balls or cubes about points, each one like `element`.
std::shared_ptr<Form> make_cloud(std::vector<Vec> points, std::shared_ptr<const Form> element);
std::shared_ptr<Form> make_solid(Kind kind, const Vec& half);
// `closed`: the faces are the whole surface of the vertices' convex hull, outward.
std::shared_ptr<Form> make_hull(const double* vertices, size_t count, const int64_t* faces, size_t triangles,
                                bool closed);

}  // namespace proof
