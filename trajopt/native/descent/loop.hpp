// Steps that reduce cost plus penalty times violation, until none is predicted to reduce it enough.
//
// The algorithm is `StepwiseDescent` of trajopt.optimise.solvers.descent, which this is tested against: the same steps, of
// programs that need no Python.
#pragma once

#include "points.hpp"

namespace descent {

enum class Ending { kConverged, kMaxIterations, kTrustRegionCollapsed, kQpFailed, kNonFinite, kGivenUp };

// The box around the current point, in units of the program's scale, and the rule that sizes it.
struct Region {
  double radius, smallest, largest, accept, good, grow, shrink;

  bool accepts(double ratio) const { return ratio >= accept; }
  bool collapsed() const { return radius < smallest; }
  void resize(double ratio);
};

struct Options {
  double penalty;                       // weight of violations
  double relative_gain, absolute_gain;  // the least reduction that is worth a step
  double accuracy;                      // of a step, as a share of that
  double regularisation;
  int qp_iterations;                    // of the interior point method, at most
  int steps;                            // at most
  int failures;                         // of the interior point method that smaller steps are tried after
  bool until_feasible;                  // whether to end where all constraints hold
  int window;                           // last steps, whose rate must make them hold in time; 0: no seed is given up
  std::vector<double> violations;       // after each step on the same samples, before this descent
};

// What is told of each step.
struct Entry {
  double cost, violation, merit, radius;
  bool accepted;
  int rows, qp_iterations;
  Work work;
};

// Told of steps, several at a time: when some time has passed since the last, or as much work is done as it allows.
struct Watch {
  std::function<void(const Entry* entries, std::size_t count)> tell;
  double seconds;
  std::int64_t configurations;  // that may be evaluated before it must be told; negative for any number
};

struct Descent {
  std::shared_ptr<const Point> at;
  Region region;
  int failures = 0;  // of the interior point method, so far
  std::vector<Entry> log;
};

Ending descend(Program& program, Descent& descent, const Options& options, const Program::Ask& ask,
              const Watch& watch);

}  // namespace descent
