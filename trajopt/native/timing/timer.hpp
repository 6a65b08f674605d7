// Times a smooth path: the fastest profile whose trajectory holds all limits at all times, from rest to rest.
//
// The same in plain Python, compared with this in the tests: tests/oracles/retiming/timing.py and jerk_timing.py.
#pragma once

#include "jerk_program.hpp"
#include "peaks.hpp"
#include "smoothing.hpp"

namespace timing {

constexpr double kStrict = 1.0 - 1e-9;  // STRICT of timing.py: part of each limit that a trajectory may use
constexpr double kToolRoom = 1e-3;  // part of each tool's limit that is left free, so that the judge need not sample
                                    // every millisecond to prove that the limit holds
constexpr std::size_t kFirstPoints = 80;  // intervals of the first grid, which only serves to lay the second
constexpr double kCoarse = 1.05;          // pieces that would have to run slower by more than this are cut in two
constexpr int kRefinements = 3;  // how often the grid is refined; a limit exceeded then is not due to the grid
constexpr double kDeviation = 5e-6;       // farthest that a piece may leave the path; else the grid is made finer
constexpr double kGravity = 1.0 - 1e-6;   // part of a torque limit that holding still may take

constexpr double kFirstAverage = 1.0;  // FIRST_AVERAGE of jerk_timing.py: least time to average over, in intervals
constexpr double kShown = 0.5;         // the acceleration does not rise to its limit in less time, in intervals of the
                                       // grid: faster changes would happen between the points, unseen
constexpr double kFirstGap = 0.3;      // part of the duration that the first barrier leaves open at first
constexpr double kRoughPoints = 0.6;   // part of the points on the first clock
constexpr double kRoughGap = 6e-2;     // part of the duration that the first solution may be from the least
constexpr double kGap = 4e-3;          // the same of the last
constexpr int kPasses = 4;             // how many times at most the limits are tightened
constexpr double kRemainder = 2e-3;    // part of the duration that the last uniform stretch may add
constexpr double kTrifle = 1e-9;       // jerk limits that are smaller count with this, where only a scale is needed
constexpr double kJerkCoarse = 1.03;   // a motion that must run slower by more, after all passes, gets a finer grid
constexpr double kFiner = 1.6;         // by this factor
constexpr int kGrids = 3;              // most grids that are tried

struct Options {
  std::size_t points;    // to aim at
  int passes;            // most times that the profile is computed
  double remainder;      // part of the duration that the last uniform stretch may add
  double shortest;       // least duration
  double longest;        // most that a path may take
};

enum class Outcome { kTimed, kGravityTooStrong, kTooLong, kNothingFits, kExceeded };

// What came of timing a path.
struct Timed {
  Outcome outcome = Outcome::kTimed;
  Which limit;          // that cannot be held, where it is one
  double place = 0.0;   // where it cannot be, as a part of the path
  double value = 0.0;   // the torque, or the duration, that it takes
  Motion motion;
  Numbers s;            // the path parameter of each point
  double added = 0.0;   // what keeping the limits between the points has cost, against the first profile
  int passes = 0;       // how many profiles were computed
  Numbers binding;      // for which part of the duration each kind of limit decides
};

// A trajectory that holds some bounds at its points, and how far it uses the limits.
struct Attempt {
  Bounds bounds;             // that hold at the points
  Profile profile;           // within them
  Motion motion;             // of the profile, perhaps a little slower
  Peaks peaks;               // what was measured of it
  Slowdown needed;           // how much slower it must be run
  bool measured;             // whether the torque was measured, if it has limits; it costs most, and is left out where
                             // the motion alone calls for another pass
  std::vector<bool> coarse;  // pieces that are known to be too long

  bool too_coarse() const { return std::find(coarse.begin(), coarse.end(), true) != coarse.end(); }

  // Better: no pieces too long, torque known, and the shorter when slowed down to hold all limits.
  bool better_than(const Attempt& other) const {
    if (too_coarse() != other.too_coarse()) return other.too_coarse();
    if (measured != other.measured) return measured;
    return motion.duration() * std::max(1.0, needed.factor) < other.motion.duration() * std::max(1.0, other.needed.factor);
  }
};

class Timer {
 public:
  Timer(const SmoothPath& path, Limits limits, const Options& options)
      : path_(path), limits_(std::move(limits)), options_(options) {
    for (Numbers* limit : {&limits_.velocity, &limits_.acceleration, &limits_.jerk, &limits_.torque})
      for (double& each : *limit) each *= kStrict;
    for (double& each : limits_.tool) each *= 1.0 - kToolRoom;
    if (limits_.torques) along_ = TorqueAlong(path_, limits_);
  }

  Timed run() const {
    const DiscretisedPath rough = on_grid(first_grid(path_.knots, kFirstPoints));
    if (auto refused = too_weak(rough)) return *refused;
    const Profile profile = fastest_profile(rough, rough.bounds);
    if (!(profile.duration() <= options_.longest)) {
      Timed refused;
      refused.outcome = Outcome::kTooLong, refused.value = profile.duration();
      return refused;
    }
    const Numbers turning = turned(rough, limits_.velocity);
    DiscretisedPath fine = on_grid(even_grid(path_.knots, profile, turning, options_.points));
    if (auto refused = too_weak(fine)) return *refused;
    for (std::size_t joint = 0; joint < fine.joints(); ++joint)
      for (std::size_t i = 0; i < fine.points(); ++i)
        if (std::isfinite(limits_.jerk[joint]) && fine.dq[i][joint] != 0.0)
          return with_jerk(fastest_profile(fine, fine.bounds));
    return without_jerk(std::move(fine));
  }

 private:
  DiscretisedPath on_grid(Numbers s) const { return discretised(path_, std::move(s), limits_, along_); }

  // Finds the point where holding still takes more torque than there is: the arm could only swing through such a
  // point, and never stop there.
  std::optional<Timed> too_weak(const DiscretisedPath& on) const {
    Timed refused;
    double worst = -1.0;
    const std::size_t joints = on.joints();
    for (std::size_t i = 0; i < on.points(); ++i) {
      for (std::size_t column = 0; column < limits_.torque.size(); ++column) {
        const double still = std::abs(on.rows.c[i][joints + column]), limit = limits_.torque[column];
        const double part = limit > 0.0 ? still / limit : barrier::kInfinity;
        if (!(part > worst)) continue;
        worst = part, refused.limit = {Kind::kTorque, column}, refused.value = still;
        refused.place = on.s[i] / on.s.back();
      }
    }
    refused.outcome = Outcome::kGravityTooStrong;
    return worst < kGravity ? std::nullopt : std::optional(refused);
  }

  // Makes the trajectory of a profile and measures all but its torque. Where no more than the part `remainder` of the
  // duration is missing, it is added at once.
  Attempt measured(const DiscretisedPath& on, Bounds bounds, Profile profile, double remainder) const {
    const bool jerk = on.bounds.jerk.rows > 0;
    Motion motion(on, profile);
    motion = motion.slowed(std::max(1.0, options_.shortest / motion.duration()));
    Peaks peaks = motion_peaks(motion, limits_, jerk);
    Slowdown needed = slowdown(on, limits_, peaks);
    if (1.0 < needed.factor && needed.factor <= 1.0 + remainder) {
      // Only a stretch is left to do: then the torque need not be measured before it and after.
      motion = motion.slowed(needed.factor * (1.0 + 1e-12));
      peaks = motion_peaks(motion, limits_, jerk);
      needed = slowdown(on, limits_, peaks);
    }
    return {std::move(bounds), std::move(profile), std::move(motion), std::move(peaks), std::move(needed),
            !limits_.torques, std::vector<bool>(on.pieces(), false)};
  }

  void with_torque(const DiscretisedPath& on, Attempt& attempt) const {
    if (attempt.measured) return;
    measure_torque(attempt.motion, limits_, attempt.peaks);
    attempt.needed = slowdown(on, limits_, attempt.peaks), attempt.measured = true;
  }

  // Slows the best attempt down until all limits hold. `first`: duration of the profile that holds the limits at the
  // points only.
  Timed finished(const DiscretisedPath& on, Attempt best, double first, int passes) const {
    with_torque(on, best);
    Timed timed;
    Slowdown left = best.needed;
    timed.motion = hold(on, limits_, best.motion, left);
    timed.passes = passes;
    if (!(left.factor <= 1.0 + kRounding)) {
      timed.outcome = Outcome::kExceeded, timed.limit = left.which[left.piece];
      timed.place = on.s[left.piece] / on.s.back();
      return timed;
    }
    timed.s = on.s, timed.added = timed.motion.duration() - first;
    timed.binding = binding(best.needed, best.motion.duration() / timed.motion.duration(), timed.motion);
    return timed;
  }

  Attempt attempt_without_jerk(const DiscretisedPath& on, const Bounds& bounds, bool refinable) const {
    Attempt attempt = measured(on, bounds, fastest_profile(on, bounds), options_.remainder);
    const Numbers away = path_deviation(path_, attempt.profile, attempt.motion);
    const auto mark = [&] {
      for (std::size_t i = 0; i < away.size(); ++i)
        if (attempt.needed.factors[i] > kCoarse || away[i] > kDeviation) attempt.coarse[i] = true;
    };
    mark();
    if (attempt.needed.factor > 1.0 + options_.remainder || (refinable && attempt.too_coarse())) return attempt;
    with_torque(on, attempt);
    mark();
    return attempt;
  }

  // Without limits on the jerk: refines the grid where a trajectory exceeds much between its points, or leaves the
  // path; where it is little, lowers the limits at the points. In the end slows it down by what remains.
  Timed without_jerk(DiscretisedPath on) const {
    Attempt attempt = attempt_without_jerk(on, on.bounds, true), best = attempt;
    DiscretisedPath best_on = on;
    const double first = std::max(attempt.profile.duration(), options_.shortest);
    int passes = 1;
    for (int refined = 0; passes < options_.passes; ++passes) {
      if (attempt.too_coarse() && refined < kRefinements) {
        ++refined;
        on = on_grid(finer_grid(on.s, attempt.coarse));
        attempt = attempt_without_jerk(on, on.bounds, refined < kRefinements);
      } else if (attempt.needed.factor > 1.0 + options_.remainder) {
        attempt = attempt_without_jerk(on, tightened(on, limits_, attempt.bounds, attempt.peaks), refined < kRefinements);
      } else {
        break;
      }
      if (attempt.better_than(best)) best = attempt, best_on = on;
    }
    return finished(best_on, std::move(best), first, passes);
  }

  DiscretisedPath on_clock(const RampedPath& ramp) const {
    DiscretisedPath on = discretised(ramp, ramp.clock, limits_, along_);
    on.bounds.jerk = repeated(limits_.jerk, {}, on.pieces());
    return on;
  }

  Numbers control(JerkProgram& program, const Bounds& bounds, Numbers start, double first_gap, double gap) const {
    const double cell = program.on().s.back() / static_cast<double>(options_.points);
    Numbers shown = limits_.acceleration;
    for (double& each : shown) each /= kShown * cell;
    return program.minimise(bounds, shown, std::move(start), first_gap, gap);
  }

  static Numbers even(const DiscretisedPath& on) { return Numbers(on.points() + 1, 1.0); }

  static RoughMotion moved(const RampedPath& ramp, const Profile& profile) {
    RoughMotion motion{profile.times, profile.s, profile.s};
    for (std::size_t i = 0; i < profile.s.size(); ++i) {
      double way[2];
      ramp.way(profile.s[i], 1, way);
      motion.s[i] = way[0], motion.speed[i] = way[1] * std::sqrt(profile.x[i]);
    }
    return motion;
  }

  // Lowers limits where they are exceeded between the points, while that makes the motion faster. Nothing if no speed
  // is within all limits.
  std::optional<Attempt> improved(const DiscretisedPath& on, const RampedPath& ramp, int& passes) const {
    JerkProgram program(on, ramp);
    Numbers found = even(on);
    std::optional<Attempt> best;
    Bounds bounds = on.bounds;
    for (int pass = 0; pass <= kPasses; ++pass) {
      found = control(program, bounds, std::move(found), pass == 0 ? kFirstGap : kGap, kGap);
      if (found.empty()) return std::nullopt;
      Attempt attempt = measured(on, bounds, Profile(on.s, found, false), kRemainder);
      if (attempt.needed.factor <= 1.0 + kRemainder) with_torque(on, attempt);
      ++passes;
      const bool more = pass < kPasses && attempt.needed.factor > 1.0 + kRemainder;
      if (more) bounds = tightened(on, limits_, attempt.bounds, attempt.peaks);
      if (!best || attempt.better_than(*best)) best = std::move(attempt);
      if (!more) break;
    }
    return best;
  }

  // With limits on the jerk: with no acceleration at the ends. The fastest motion without such limits is averaged over
  // the time that the acceleration takes to rise. On the clock of that motion the squared clock speed is near 1, and a
  // program finds it. The result gives the next clock: then everything is even in time, also where the jerk makes a
  // corner much slower.
  Timed with_jerk(const Profile& fastest) const {
    std::size_t count = options_.points;
    double rise = 0.0;
    for (std::size_t joint = 0; joint < limits_.joints(); ++joint)
      rise = std::max(rise, limits_.acceleration[joint] / std::max(limits_.jerk[joint], kTrifle));
    const double average = std::max(std::min(rise, fastest.duration()),
                                    kFirstAverage * fastest.duration() / static_cast<double>(count));
    RoughMotion motion{fastest.times, fastest.s, fastest.x};
    for (double& each : motion.speed) each = std::sqrt(each);
    Timed nothing;
    nothing.outcome = Outcome::kNothingFits;
    int passes = 1;
    {
      const auto few = static_cast<std::size_t>(std::nearbyint(kRoughPoints * static_cast<double>(count)));
      const RampedPath ramp = ramped(path_, motion, average, few);
      const DiscretisedPath on = on_clock(ramp);
      JerkProgram program(on, ramp);
      const Numbers found = control(program, on.bounds, even(on), kFirstGap, kRoughGap);
      if (found.empty()) return nothing;
      motion = moved(ramp, Profile(on.s, found, false));
    }
    for (int grids = 1;; ++grids) {
      const RampedPath ramp = ramped(path_, motion, 0.0, count);
      const DiscretisedPath on = on_clock(ramp);
      std::optional<Attempt> best = improved(on, ramp, passes);
      if (!best) return nothing;
      const Numbers away = path_deviation(ramp, best->profile, best->motion);
      const bool coarse = *std::max_element(away.begin(), away.end()) > kDeviation;
      if (grids < kGrids && (coarse || best->needed.factor > kJerkCoarse)) {
        motion = moved(ramp, best->profile);
        count = static_cast<std::size_t>(std::nearbyint(static_cast<double>(count) * kFiner));
        continue;
      }
      const double first = best->profile.duration();
      Timed timed = finished(on, std::move(*best), first, passes);
      for (double& each : timed.s) each = ramp.way(each);
      return timed;
    }
  }

  const SmoothPath& path_;
  Limits limits_;
  Options options_;
  TorqueAlong along_;
};

}  // namespace timing
