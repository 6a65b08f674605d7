// The best x of a `Program` between bounds.
#pragma once

#include "program.hpp"

namespace banded {

enum class Outcome { kSolved, kInaccurate, kFailed };

struct Options {
  double accuracy = 1e-6;   // by how much the objective may exceed its least value
  double start = 0.1;       // distance from the kinks that slacks start with, in the unit of their row
  // Share of the way between its bounds that a variable starts inside them: at first, and where that does not converge.
  double inside = 0.01, well_inside = 0.1;
  int max_iterations = 60;
};

struct Solution {
  Outcome outcome = Outcome::kFailed;
  int iterations = 0;
  Eights x;
  double reduction = 0.0;  // of the objective, from x = 0
};

Solution best(const Program& program, const Eights& lower, const Eights& upper, const Options& options);

}  // namespace banded
