// The statement and the witness of a proof, as docs/proofs.md describes them.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "ball.hpp"

namespace checker {

// The statement or the witness is not of the format; the message is a sentence.
struct Malformed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline void demand(bool fits, const std::string& sentence) {
  if (!fits) throw Malformed(sentence);
}

// A fixed placement in a joint's frame; joint 0 is the world.
struct Place {
  int joint = 0;
  Turn rotation;
  Vec translation;
};

struct Joint {
  std::string name;
  Place place;
  bool turns = false;
  Vec axis;
  int coordinate = 0;
  double factor = 0.0, offset = 0.0, lower = 0.0, upper = 0.0;
  std::array<double, 3> rates{};  // limits of velocity, acceleration and jerk
};

// Hermite interpolants: positions, velocities and, of quintics, accelerations of n coordinates at k knots.
struct Curve {
  std::vector<std::string> names;
  std::vector<double> times;
  std::vector<std::vector<double>> values;
  int count() const { return static_cast<int>(names.size()); }
};

struct Ends {
  std::vector<double> positions, velocities, accelerations;
  double tolerance = 0.0, speed = 0.0;
  bool rests = false;
};

// Points within a radius of the hull of vertices; or a frustum; or z <= 0.
struct Shape {
  enum Kind { HULL, FRUSTUM, HALF_SPACE } kind = HULL;
  std::vector<double> x, y, z;  // a multiple of four vertices, the last one repeated
  int vertices = 0;
  double radius = 0.0, farthest = 0.0;
  double bottom = 0.0, top = 0.0, length = 0.0;
  // Upper bound of the largest inner product with the directions of a ball.
  double support(const Vec& direction) const;
};

struct Part {
  std::string owner;
  Place place;
  Shape shape;
  Vec centre;  // of a sphere around it, in its joint's frame
  double radius = 0.0;
};

struct Change {
  std::string owner;
  double appears = 0.0, expires = 0.0;
  std::array<double, 3> error{};
};

// Two owners that keep apart only between two times.
struct Contact {
  std::string one, other;
  double since = 0.0, until = 0.0;
};

struct Pair {
  int one = 0, other = 0;
  double clearance = 0.0;
};

struct Arm;

// A requirement: its words, and a function that returns the first cell of the grid in which it is not shown, or SHOWN. The end
// is the last time of the grid; for a requirement of the end it may be any other one.
constexpr int SHOWN = -2;
struct Rule {
  std::string words;
  std::function<int(const Arm&, int end)> unshown;
};

struct Statement {
  Curve curve;
  std::vector<Curve> drives;
  std::vector<Joint> joints;
  Ends ends;
  double excess = 0.0;
  std::vector<Part> parts;
  std::vector<Change> changes;
  std::vector<Pair> pairs;
  std::vector<std::pair<std::string, std::string>> excused;
  std::vector<Contact> contacts;
  std::vector<Rule> rules;
};

struct Witness {
  std::vector<double> grid;
  std::vector<int> first;  // leaf of each pair, and the number of all
  std::vector<int> begin;  // of each leaf in the grid
  std::vector<std::array<double, 3>> direction;
  int end(int pair, int leaf) const {
    return leaf + 1 < first[pair + 1] ? begin[leaf + 1] : static_cast<int>(grid.size()) - 1;
  }
};

}  // namespace checker
