// Search for a proof that bodies keep apart at all times, interval by interval.
//
// Over an interval a pair is proven by one direction that separates its bodies at both ends by more than they can be
// off the chords between (see travel.hpp), or by its distance in the middle and the travel from there (conservative
// advancement). What is left is halved. Only pairs not yet proven are looked at in the halves.
//
// The verdict is the first pass's: whether every bound exceeds what is required. A second one, where asked for, only
// measures: its bounds come as near as the resolution says to the smallest distances, and it changes no verdict.
#pragma once

#include "candidates.hpp"
#include "meter.hpp"
#include "motion.hpp"
#include "travel.hpp"

namespace proof {

constexpr int first_intervals = 16;  // A motion that is measured is cut into so many at first.

struct Options {
  double resolution, far, smallest_interval, most_distances, error;
  double intervals;  // A motion of which is decided is cut into so many at first.
};

// When contact of a pair is accepted, and how deep: at or before `until`, at or after `from`. To any depth where one
// of the two is not there.
struct Window {
  double until, from, first_depth, last_depth;
};

// The pairs that have a window, and when one opens or closes.
struct Windows {
  std::vector<int> number;  // Of each pair's window; -1 for none.
  std::vector<Window> windows;
  std::vector<double> edges;

  bool accept(double time, int pair) const {
    if (number[pair] < 0) return false;
    const Window& window = windows[number[pair]];
    return time <= window.until || time >= window.from;
  }
  // What the distance must exceed while contact is accepted: minus the accepted depth [m].
  double floor(double time, int pair) const;
};

// Smallest distance proven and measured of every pair [m], and when it was measured [s].
struct Tally {
  std::vector<double> proven, measured, time;

  explicit Tally(size_t count);
  void note(int pair, double distance, double when);
};

struct Contact {
  int pair;
  double time, distance;
};

struct Gap {
  int pair = -1;
  double begin = 0.0, end = 0.0;
};

class ClearanceSearch {
 public:
  ClearanceSearch(const Bodies& bodies, const Candidates& candidates, Meter& meter, const Motion& motion,
                  const Windows& windows, const Options& options);

  // Decide only whether all that is required is proven; the first contact found, or interval unproven, ends it.
  void decide();
  // Decide, and measure how near everything comes.
  void run();

  Tally free, accepted;            // At times when pairs must keep apart, and when contact is accepted.
  std::vector<Contact> contacts;   // Not accepted; every one found.
  Gap gap;                         // First interval without proof; pair -1 for none.
  long configurations = 0;         // At which forward kinematics was computed.

 private:
  struct Cell {
    double begin, end;
    std::shared_ptr<Snapshot> early, late;
    std::vector<int> pairs;
    bool fresh;  // Its pairs are still to be listed.
  };
  // What is known about the cell at hand.
  struct Reach {
    double begin, end;
    std::shared_ptr<Snapshot> early, middle, late;
    JointBounds bounds;
    bool chords;  // No velocity jumps inside.
    std::vector<Travel> travels;  // Of the travellers that move, once asked for.
    std::vector<char> known;
  };

  const Bodies& bodies_;
  const Candidates& candidates_;
  Meter& meter_;
  const Motion& motion_;
  const Windows& windows_;
  const Options& options_;
  double far_;                     // Clearance above the required one beyond which nothing is looked at closely [m].
  std::vector<double> best_;       // Smallest free distance measured of the pairs of each level [m].
  double beyond_;                  // Lower bound of the distances of all pairs that were never listed [m].
  std::vector<double> tight_time_; // When each pair's proven bound is smallest [s].
  std::vector<std::shared_ptr<Snapshot>> samples_;  // Even over the motion.
  long before_;
  bool deciding_ = false;             // Whether bounds need only exceed what is required.
  // Bounds of the first pass, free and accepted, if they prove everything that is required.
  std::unique_ptr<std::pair<Tally, Tally>> decided_;

  bool proven() const { return contacts.empty() && gap.pair < 0; }
  void look_at_ends();
  void spread_beyond();
  void forget_bounds();
  void keep_decided(const std::vector<int>& pairs, double time);
  std::shared_ptr<Snapshot> at(double time);
  void look(Snapshot& at, bool only_contacts);
  void consider(int pair, Snapshot& at, bool only_contacts);
  void judge(int pair, double time, double distance);
  void note_free(int pair, double distance, double time);
  double floor(double time, int pair) const;
  double nearest(int level) const;
  double required(int pair) const { return bodies_.pairs[pair].required; }
  double doubted(int pair, Snapshot& at, double distance);
  double target(double time, int pair) const;
  std::vector<Cell> first_cells();
  void list_near(Cell& cell, Reach& reach);
  void advance(std::vector<Cell>& cells);
  bool prove(int pair, Reach& reach);
  double middle_distance(int pair, Reach& reach, double travel);
  Travel travel(int traveller, Reach& reach);
  Reach reach(const Cell& cell);
  void search();
  bool nothing_near();
  void measure_near_pairs();
  void measure_free(int pair, Snapshot& at);
  void sharpen(int pair);
};

}  // namespace proof
