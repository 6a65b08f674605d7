// Straight lines between configurations, looked at from coarse to fine: most that touch something touch it early.
#pragma once

#include "clear.hpp"

namespace proximity {

class Lines {
 public:
  // step: no body moves farther between two configurations that are looked at [m].
  Lines(const Cell& cell, std::vector<double> reach, double step)
      : clear(cell, std::move(reach)), dofs_(cell.robot.dofs()), step_(step), between_(dofs_) {}

  // Whether a line keeps clear; it is taken that its beginning does.
  bool free(const double* from, const double* to);

  Clear clear;

 private:
  // How far a joint turns between looked-at configurations at most, all joints together [rad | m]: beyond half a turn a
  // body may come back to where it was, and the bound of its motion says nothing.
  static constexpr double kTurn = 1.0;

  // A stretch of the line, its ends as shares of the whole and as places in `looked_`.
  struct Stretch {
    double from, to;
    int first, last;
  };

  bool clear_at(const double* from, const double* to, double share);
  int keep_places();

  const int dofs_;
  const double step_;
  std::vector<double> between_;
  std::vector<Places> looked_;  // reused from line to line
  int used_ = 0;
  std::vector<Stretch> waiting_;
};

}  // namespace proximity
