// Costs and constraints that are evaluated without leaving the core.
#pragma once

#include "frame_terms.hpp"
#include "margins.hpp"
#include "rows.hpp"

namespace descent {

// Samples of a curve: each is a weighted mean of few knots.
struct Samples {
  int stencil = 0;  // knots of each
  std::vector<std::int64_t> knot;
  std::vector<double> weight;
  std::vector<double> place;  // along the motion

  int count() const { return static_cast<int>(place.size()); }
};

// The variables: knots, one after the other, of as many joints each.
struct Variables {
  int joints = 0;
  std::vector<char> moves;  // variable by variable
  std::vector<char> knot_moves;

  int knots() const { return static_cast<int>(knot_moves.size()); }
};

// constant + J x, with a J that never changes.
struct Linear {
  int stencil = 0;
  std::vector<double> constant, jacobian;
  std::vector<std::int64_t> knot;

  void evaluate(const Variables& variables, const Role& role, const double* x, Rows& rows) const;
};

// factor (distance - margin) of every pair that is nearer than its reach.
struct Distances {
  Samples samples;
  std::vector<double> reach, factor;  // by pair
  Margins margins;

  void evaluate(const Variables& variables, const Role& role, robot::RobotQuery& query, const double* x,
                Rows& rows) const;
};

// A term of a frame at every sample. Bounds are by sample and component.
struct Frames {
  Samples samples;
  robot::View view;
  std::shared_ptr<const FrameTerm> term;
  std::int64_t configurations;  // that count as work: terms over the same samples share them

  void evaluate(const Variables& variables, const Role& role, robot::RobotQuery& query, const double* x,
                Rows& rows) const;
};

}  // namespace descent
