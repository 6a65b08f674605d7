// All pairs that are near each other at the samples of a motion, found again and again while it changes.
//
// What was measured once is kept as a bound: a pair whose distance was d, and whose bodies have moved by no more
// than m since, is still at least d - m apart. So every body carries the sum of its motion bounds at each sample,
// every bound is stored as d plus that sum, and one subtraction dismisses a pair along a stretch of samples. The same
// holds along the path, from one sample to the next. Of a pair that was measured beyond its reach, the direction is
// kept in which the two were apart: mostly they still are, and that is asked with one farthest point of each. Obstacles
// are listed for stretches of consecutive samples, with a skin: a list stays good until its body has moved through it.
// Nothing is lost by any of it: the rows are the same as without. Of a pair within reach the nearest points and the
// direction between them are kept too, as its bodies carry them: they bound the distance from both sides, and where the
// bounds agree well enough the lower one stands for it. It is exact at the pair's aim and below.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cell.hpp"
#include "cloud_phase.hpp"
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

  // Find every pair nearer than its reach at S configurations. Distances up to a pair's aim are measured.
  const ClosePairs& close_pairs(const double* positions, int samples, const std::vector<double>& reach,
                                const std::vector<double>& aim);

  // Forget everything, so that later distances above their aim do not hang on earlier calls.
  void forget() { samples_ = 0; }

  Work work;

 private:
  static constexpr int kStretch = 8;
  static constexpr double kSkin = 0.15;
  // A distance above the aim may be too small by this share of its excess: the nearer a row is to its bound, the more
  // exact it is, and none loses more than a third of what it had to spare.
  static constexpr double kInexact = 0.5;

  // Pairs along one stretch of samples, and what is known of them.
  struct Watched {
    std::vector<int> pair;
    std::vector<double> least;                           // of the bounds of each pair, motion sums included
    std::vector<std::array<double, kStretch>> clear;     // bound plus both bodies' motion sums
    std::vector<std::array<Vector3, kStretch>> across;   // direction along which they are apart, where one is known
    std::vector<std::uint8_t> known;                     // whether it is, a bit for each sample
    std::vector<std::uint8_t> close;                     // whether they were within reach at last, a bit for each sample

    void reset();
  };

  // Obstacles near one mover along one stretch of samples.
  struct Neighbours {
    bool listed = false;
    std::array<double, kStretch> since;  // the mover's motion sum at each sample when the list was made
    Watched pairs;
  };

  // Where a pair was nearest when it was measured, from the bodies' centres along their axes.
  struct Contact {
    int pair;
    Vector3 first, second;                // points of the bodies
    Vector3 normal_first, normal_second;  // the direction from the first to the second, as each carries it
  };

  // The movers of a pair; what stands still is one more, that never moves.
  struct Both {
    int first, second;
  };

  void place_all(const double* positions);
  void begin_anew(int samples);
  void pass_on(const double* positions, int samples);
  void widen(const std::vector<double>& reach);
  void along_stretch(int begin, int end);
  bool outdated(const Neighbours& list, int mover, int begin, int end) const;
  void list_obstacles(Neighbours& list, int mover, int begin, int end);
  void watch(Watched& pairs, int begin, int end);
  void follow(Watched& pairs, std::size_t entry, int begin, int end);
  double apart(Watched& pairs, std::size_t entry, int sample, int place);
  double noted(Watched& pairs, std::size_t entry, int place, const Nearest& found);
  const Contact* kept(int pair, int sample) const;
  bool carried(const Contact& contact, int sample, Nearest& found);
  void keep(int pair, int sample, const Nearest& found);
  double step(int mover, int sample, int place);
  Nearest measure(int pair, int sample);
  Nearest measure_cloud(int pair, int sample);
  void add_row(int pair, int sample, const Nearest& found);

  int mover(int body) const { return cell_.mover_of[body] < 0 ? movers_ : cell_.mover_of[body]; }
  const Place& at(int sample, int body) const;
  const Place& place_of(int sample, int mover) const { return places_[static_cast<std::size_t>(sample) * movers_ + mover]; }
  double& moved(int sample, int mover) { return moved_[static_cast<std::size_t>(sample) * (movers_ + 1) + mover]; }
  double moved(int sample, int mover) const { return moved_[static_cast<std::size_t>(sample) * (movers_ + 1) + mover]; }
  double moved(int sample, const Both& both) const { return moved(sample, both.first) + moved(sample, both.second); }

  const Cell& cell_;
  Kinematics kinematics_;
  NarrowPhase narrow_;
  CloudPhase clouds_{narrow_};
  const int movers_;
  std::vector<Both> both_;  // by pair

  int samples_ = 0;
  std::vector<double> reach_, aim_;  // now
  std::vector<double> listed_;   // the widest of each pair so far: what lists of obstacles are made for
  double longest_listed_ = 0.0;
  std::vector<pinocchio::SE3, Eigen::aligned_allocator<pinocchio::SE3>> joints_;  // by sample and joint
  std::vector<Place, Eigen::aligned_allocator<Place>> places_;                    // by sample and mover
  std::vector<double> moved_;                                                     // by sample and mover
  std::vector<Neighbours> neighbours_;                                            // by stretch and mover
  std::vector<Watched> between_;                                                  // pairs of movers, by stretch
  std::vector<std::vector<Contact>> contacts_;                                    // by sample
  std::vector<double> positions_;                                                 // of the samples
  // Of the stretch that is asked now: the farthest that each mover has moved, and its steps from sample to sample.
  std::vector<double> farthest_, steps_;
  std::vector<int> near_;
  ClosePairs found_;
};

}  // namespace proximity
