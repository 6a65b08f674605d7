// Primal-dual interior point method with Mehrotra's predictor and corrector for a `Program`.
//
// Each penalised row, row x - bound = t - s with s, t >= 0, costs penalty t. Its multipliers, lambda of s >= 0 and
// nu of t >= 0, add up to the penalty: that is stationarity in t, and is kept exactly. Eliminating s, t and both
// multipliers leaves, with w = 1 / (s / lambda + t / nu) for each row,
//
//   (H + A' diag(w) A + Z_l / S_l + Z_u / S_u) dx = right-hand side,
//
// a band whose pattern is the same whatever the number of rows. Bounds are simple: x stays strictly inside.
// Source: Nocedal and Wright, Numerical Optimization (2006), section 16.6 and algorithm 16.4; the elimination of
// the slacks is worked out in docs/decisions/banded-qp.md.
#pragma once

#include "program.hpp"

namespace banded {

enum class Outcome { kSolved, kInaccurate, kFailed };

struct Options {
  double accuracy = 1e-6;   // by how much the objective may exceed its least value
  double start = 0.1;       // distance from the kinks that slacks and bounds start with, in their own unit
  int max_iterations = 60;
};

struct Solution {
  Outcome outcome = Outcome::kFailed;
  int iterations = 0;
  std::vector<double> x;
  std::vector<double> multiplier;  // of each row, 0 ... penalty
};

class InteriorPoint {
 public:
  InteriorPoint(const Program& program, const double* lower, const double* upper, const Options& options);

  Solution solve();

 private:
  // Complementary products that a Newton step aims at: one target for all, less the second-order terms.
  struct Targets {
    std::vector<double> lower, upper, below, above;
  };

  void start();
  void residuals();
  double gap() const;
  double error_bound() const;
  void factorise();
  void direction();
  void aim(double target, bool corrected);
  double longest_step() const;
  double gap_after(double step) const;
  void take(double step);

  const Program& program_;
  const double* lower_;
  const double* upper_;
  Options options_;
  int size_, rows_;

  std::vector<double> x_, to_lower_, to_upper_, z_lower_, z_upper_;  // variables, their room and its multipliers
  std::vector<double> excess_, s_, t_, lambda_, nu_;                 // rows
  std::vector<double> stationarity_, product_;
  std::vector<double> weight_;
  Band system_;
  Targets targets_;
  std::vector<double> dx_, dz_lower_, dz_upper_, ds_, dt_, dlambda_;
};

}  // namespace banded
