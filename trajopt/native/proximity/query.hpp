// What one thread asks a cell with.
#pragma once

#include "../distance_query.hpp"
#include "tracker.hpp"

namespace proximity {

struct Query : distances::DistanceQuery {
  explicit Query(const Cell& asked) : cell(asked), kinematics(asked.robot), tracker(asked) {}

  int joints() const override { return cell.robot.dofs(); }
  int pairs() const override { return static_cast<int>(cell.pairs.size()); }
  distances::Near near(const double* positions, int samples, const std::vector<double>& reach) override {
    const ClosePairs& found = tracker.close_pairs(positions, samples, reach);
    return {found.pair.size(), found.sample.data(), found.pair.data(), found.distance.data(), found.jacobian.data()};
  }
  distances::Work work() const override { return {tracker.work.bounds, tracker.work.distances}; }

  const Cell& cell;
  Kinematics kinematics;
  Tracker tracker;
};

}  // namespace proximity
