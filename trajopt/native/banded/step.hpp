// The best step of a `Program`, between bounds of all variables, those that cannot move included.
#pragma once

#include "interior_point.hpp"

namespace banded {

struct Step {
  Outcome outcome = Outcome::kFailed;
  int iterations = 0;
  std::vector<double> change;  // of each variable
  double reduction = 0.0;      // of the objective
};

Step best_step(Program& program, const double* lower, const double* upper, double regularisation,
               const Options& options);

}  // namespace banded
