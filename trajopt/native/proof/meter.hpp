// Signed distances of pairs at one moment, and proofs that pairs keep apart between two.
#pragma once

#include <limits>

#include "bodies.hpp"
#include "gjk.hpp"

namespace proof {

constexpr double infinite = std::numeric_limits<double>::infinity();

struct Measured {
  double distance;  // [m], less the error.
  bool exact;       // Otherwise the distance is no less than what was asked about.
};

// Workspace; one for each thread.
class Meter {
 public:
  Meter(const Bodies& bodies, double error);

  long calls = 0;  // Distances measured or proven so far.

  // Measure a distance less the pair's error, or find out that it is no less than `within`.
  Measured measure(int pair, Snapshot& at, double within);
  // The same with hulls in the place of exact meshes.
  double measure_hulls(int pair, Snapshot& at);
  // The same by a search of all directions, hulls in the place of meshes; minus infinity for half-spaces.
  double search_depth(int pair, Snapshot& at);
  // Whether one body is enclosed by the other's exact mesh.
  bool encloses(int pair, Snapshot& at) const;
  // Lower bound of the distance of a pair at two moments, and with chords in the place of paths in between, without
  // the pair's error [m]; minus infinity if it is not at least `needed`.
  double prove(int pair, Snapshot& early, Snapshot& late, double needed);

 private:
  struct Parts {
    int first, second;
  };
  const Bodies& bodies_;
  double error_;
  std::vector<Vec> guess_;  // Of each pair, the direction found last, in the pair's frame.
  std::vector<Parts> open_;

  // What is taken off a distance: the error of measuring, and that of where the bodies are [m].
  double taken_off(const Pair& pair, const Snapshot& at) const { return error_ + pair.error.at(at.time); }
  Sweep sweep(const Pair& pair, Snapshot& early, Snapshot& late, Parts parts) const;
  double height(const Pair& pair, Snapshot& at) const;
  double convex_distance(const Form& first, const Form& second, const Pair& pair, Snapshot& at, Vec& guess,
                         double within, bool& exact);
  // Distance of a pair with a cloud, hulls in the place of meshes.
  double union_distance(const Pair& pair, Snapshot& at, double within) const;
  // Distance of surfaces; minus infinity where they meet.
  double surface_distance(int pair, Snapshot& at, double within);
  Parts roots(const Pair& pair) const;
  bool split(const Pair& pair, Parts parts);
};

}  // namespace proof
