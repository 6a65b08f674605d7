// All pairs that are near each other at the samples of a motion, found again and again while it changes.
//
// What was measured once is kept as a bound: a pair whose distance was d, and whose bodies have moved by no more
// than m since, is still at least d - m apart. So every body carries the sum of its motion bounds at each sample,
// every bound is stored as d plus that sum, and most pairs are dismissed by one subtraction. Obstacles are listed
// for stretches of consecutive samples, with a skin: a list stays good until its body has moved through the skin.
// Nothing is lost by any of it: the rows are the same as without.
#pragma once

#include <cstdint>
#include <vector>

#include "cell.hpp"
#include "narrow.hpp"

namespace proximity {

// Near pairs of all samples, one entry each.
struct ClosePairs {
  std::vector<std::int64_t> sample, pair;
  std::vector<double> distance;
  std::vector<double> normal, first, second;  // three numbers each
  std::vector<double> jacobian;               // of the distance by the group's positions, n numbers each

  void clear();
};

class Tracker {
 public:
  explicit Tracker(const Cell& cell);

  // Measure every pair nearer than its reach at S configurations.
  const ClosePairs& close_pairs(const double* positions, int samples, const std::vector<double>& reach);

  Work work;

 private:
  static constexpr int kStretch = 8;
  static constexpr double kSkin = 0.15;

  // Obstacles near one mover along one stretch of samples.
  struct Neighbours {
    bool listed = false;
    std::vector<double> since;  // the mover's motion sum at each sample when the list was made
    std::vector<int> pair, body;
    std::vector<double> clear;  // bound plus motion sum, by entry and sample
  };

  void place_all(const double* positions, int samples);
  void forget();
  bool outdated(const Neighbours& list, int mover, int begin, int end) const;
  void list_obstacles(Neighbours& list, int mover, int begin, int end);
  void along_obstacles(Neighbours& list, int mover, int begin, int end);
  void between_movers(int sample);
  double measure(int pair, int sample);
  void add_row(int pair, int sample, const Nearest& found);

  const Place& at(int sample, int body) const;
  double& moved(int sample, int mover) { return moved_[sample * movers_ + mover]; }
  double moved(int sample, int mover) const { return moved_[sample * movers_ + mover]; }

  const Cell& cell_;
  Kinematics kinematics_;
  NarrowPhase narrow_;
  const int movers_;

  int samples_ = 0;
  std::vector<double> reach_;
  double longest_reach_ = 0.0;
  std::vector<pinocchio::SE3, Eigen::aligned_allocator<pinocchio::SE3>> joints_;  // by sample and joint
  std::vector<Place, Eigen::aligned_allocator<Place>> places_;                    // by sample and mover
  std::vector<double> moved_;                                                     // by sample and mover
  std::vector<Neighbours> neighbours_;                                            // by stretch and mover
  std::vector<double> clear_between_;                                             // by sample and pair of movers
  ClosePairs found_;
};

}  // namespace proximity
