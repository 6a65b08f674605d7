// Balls around the parts of a robot over intervals of its motion, and objects at rest that they must keep apart from.
#pragma once

#include <map>

#include "arm.hpp"

namespace checker {

class SweptParts {
 public:
  // Where each object's frame is, by its owner's name; only these can be asked for.
  using Frames = std::map<std::string, Place>;

  // With the knots of a statement, times are the bounds of the intervals.
  SweptParts(const Statement& statement, std::vector<double> times, const Frames& frames);

  // Whether the balls show that all pairs of an object keep their clearance if its frame is at a place in the world.
  bool keep_apart(const std::string& owner, const Place& frame) const;

 private:
  // Contains a part in some intervals.
  struct Sphere {
    double x = 0.0, y = 0.0, z = 0.0, radius = 0.0;
  };
  // Levels of balls: of one interval each, of two, of four, up to all.
  using Tree = std::vector<std::vector<Sphere>>;
  struct Other {
    int part = 0;
    double clearance = 0.0;
  };
  struct Watched {
    Shape shape;
    Place local;          // in the object's frame
    double around = 0.0;  // radius of a sphere around the origin of its own frame
    std::array<double, 3> low{}, high{};  // the box of its shape, without its radius
    std::vector<Other> others;
  };

  static Tree tree_of(const Arm& arm, const Part& part);
  static Watched watched(const Part& part, const Place& frame);
  static bool clear(const Watched& item, const Place& place, const Sphere& ball, double clearance);
  bool clear(const Watched& item, const Place& place, const Other& other, std::size_t level, std::size_t number) const;

  std::vector<Tree> trees_;  // of each part of the statement; empty if none is needed
  std::map<std::string, std::vector<Watched>> objects_;
};

}  // namespace checker
