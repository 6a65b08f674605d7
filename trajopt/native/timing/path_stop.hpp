// Motions that brake along their own path: points of the motion, whose clock `stopping.hpp` slows down, and whether
// the quintic polynomials between them keep the limits.
//
// A stop is tabulated for moments that are evenly apart, when it is first asked for. Each tries shares of the limits
// to brake with, the largest first, and points that are few at first. Moments are left out from which no joint alone
// could be at rest sooner than with a stop that is known, and those at which an earlier one had not begun to slow down.
//
// The same in plain Python, compared with this in the tests: tests/oracles/stopping.py.
#pragma once

#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "extremes.hpp"
#include "stopping.hpp"
#include "table.hpp"

namespace stopping {

using timing::Numbers;

constexpr int kNewton = 6;  // steps until rounding: the rate changes little within one step of braking

struct Choices {
  Numbers shares;                  // of the limits, tried one after the other
  std::vector<std::size_t> every;  // each so many steps are a point of the motion, tried one after the other
  double ramp, kept;               // as in Limits
  double step, moment;             // of braking, and between the moments at which it may begin [s]
  double excess;                   // relative excess of a limit that is accepted
};

// When a motion is where on the clock of another, and how fast that runs.
struct Beat {
  double time, clock, rate, slope;
};

// How a motion brakes that begins to at a moment: the clock at the end of each step; and when it is at rest.
struct Way {
  double begin;
  std::vector<Beat> beats;
  std::size_t every;

  double end() const { return begin + beats.back().time; }
};

// Points of a motion: (k,), and (k, n) each.
struct Points {
  Numbers times, positions, velocities, accelerations;
};

class PathStops {
 public:
  PathStops(Numbers times, Numbers coefficients, Numbers acceleration, Numbers jerk, Choices choices)
      : times_(std::move(times)), coefficients_(std::move(coefficients)), acceleration_(std::move(acceleration)),
        jerk_(std::move(jerk)), choices_(std::move(choices)), joints_(jerk_.size()) {}

  double duration() const { return times_.back(); }

  // The motion from a time on that is at rest first, of those that begin to brake after another; nothing where that is
  // not sooner than its own end. And until when it goes on as it was.
  std::optional<std::pair<Points, double>> earliest(double time, double after) {
    const double moment = choices_.moment;
    const Way* best = nullptr;
    double soonest = duration() - moment, same = 0.0;
    for (auto number = static_cast<long>(std::ceil(after / moment)); number < std::ceil(duration() / moment); ++number) {
      const double begin = static_cast<double>(number) * moment;
      if (begin >= soonest) break;
      if (begin < same || begin + least(begin) >= soonest) continue;
      const Known& known = tabulated(number, soonest);
      if (known.way && known.way->end() < soonest) best = &*known.way, soonest = known.way->end();
      same = known.idle;
    }
    if (best == nullptr) return std::nullopt;
    return std::make_pair(braked(time, *best), best->begin);
  }

 private:
  Numbers times_, coefficients_, acceleration_, jerk_;
  Choices choices_;
  std::size_t joints_;
  // What was found for a moment; where it is nothing, nothing is at rest before a time. Until another time none of what
  // was tried runs slower than the motion: from there on it is the same as if it had begun there.
  struct Known {
    std::optional<Way> way;
    double before, idle;
  };
  std::map<long, Known> table_;

  Motion motion() const { return {times_.data(), coefficients_.data(), times_.size() - 1, joints_}; }
  double near() const { return choices_.step / 10.0; }  // Points nearer than this are one: the jerk would be rounding.

  // The least time from a moment to rest: no stop that keeps the limits takes less, along the path or off it.
  double least(double begin) const {
    const std::size_t piece = piece_at(motion(), begin);
    const double more = 1.0 + choices_.excess;
    double longest = 0.0;
    for (std::size_t joint = 0; joint < joints_; ++joint) {
      const Rates at = rates(motion(), piece, joint, begin - times_[piece]);
      longest = std::max(longest, least_stop(at, acceleration_[joint] * more, jerk_[joint] * more));
    }
    return longest;
  }

  // The way to brake from a moment on, if there is one that is at rest before a time.
  const Known& tabulated(long number, double before) {
    const auto known = table_.find(number);
    if (known != table_.end() && (known->second.way || known->second.before >= before)) return known->second;
    return table_.insert_or_assign(number, found(static_cast<double>(number) * choices_.moment, before)).first->second;
  }

  Known found(double begin, double before) const {
    Known known{std::nullopt, before, duration()};
    double suspect = begin;
    for (const double share : choices_.shares) {
      const Limits limits{acceleration_.data(), jerk_.data(), choices_.ramp, share, choices_.kept};
      const Braking rows = brake(motion(), limits, begin, choices_.step, before - begin);
      known.idle = std::min(known.idle, idle(rows));
      Way way{begin, beats(rows), 0};
      if (way.beats.empty() || way.end() >= before) continue;
      for (const std::size_t every : choices_.every) {
        way.every = every;
        if (!holds(way, suspect)) continue;
        known.way = way;
        return known;
      }
    }
    return known;
  }

  // Until when the clock has not begun to run slower.
  static double idle(const Braking& rows) {
    const auto slower = std::find_if(rows.slope.begin(), rows.slope.end(), [](double slope) { return slope < 0.0; });
    return rows.clock[static_cast<std::size_t>(slower - rows.slope.begin()) - 1];
  }

  // The clock at the end of each step; none where the limits leave no way to stop.
  std::vector<Beat> beats(const Braking& rows) const {
    if (std::isinf(rows.last)) return {};
    std::vector<Beat> beats;
    const std::size_t count = rows.clock.size() - 1;
    for (std::size_t i = 0; i <= count; ++i) {
      beats.push_back({choices_.step * static_cast<double>(i), rows.clock[i], rows.rate[i], rows.slope[i]});
    }
    const Beat& left = beats.back();
    const double end = left.clock + rows.last * (left.rate + rows.last * left.slope / 3.0);
    beats.push_back({left.time + rows.last, end, 0.0, 0.0});
    return beats;
  }

  // When the clock of a braking motion shows something, by Newton's method.
  static Beat shown(const Way& way, double clock) {
    const auto after = std::upper_bound(way.beats.begin(), way.beats.end(), clock,
                                        [](double value, const Beat& beat) { return value < beat.clock; });
    const auto last = static_cast<long>(way.beats.size()) - 2;
    const auto number = static_cast<std::size_t>(std::clamp(static_cast<long>(after - way.beats.begin()) - 1, 0L, last));
    const Beat &begin = way.beats[number], &end = way.beats[number + 1];
    const double width = end.time - begin.time, bend = (end.slope - begin.slope) / width;
    double since = 0.0;
    const auto moved = [&] { return since * (begin.rate + since * (begin.slope / 2.0 + since * bend / 6.0)); };
    const auto rate = [&] { return begin.rate + since * (begin.slope + since * bend / 2.0); };
    for (int step = 0; step < kNewton; ++step) {
      since = std::clamp(since + (clock - begin.clock - moved()) / std::max(rate(), kStill), 0.0, width);
    }
    return {begin.time + since, begin.clock + moved(), rate(), begin.slope + since * bend};
  }

  // The moments that are points of the motion from a time on, which brakes from a later time on.
  std::vector<Beat> moments(double time, const Way& way) const {
    std::vector<Beat> found, inner;
    if (time - way.begin < -near()) found.push_back({time - way.begin, time, 1.0, 0.0});
    for (const double own : times_) {
      if (own > time + near() && own - way.begin < -near()) found.push_back({own - way.begin, own, 1.0, 0.0});
    }
    // The motion's own points are points of the stop: between two of them its polynomials are smooth.
    const double rest = way.beats.back().time;
    for (const double own : times_) {
      if (own <= way.begin || own >= way.beats.back().clock) continue;
      const Beat at = shown(way, own);
      if (at.time > near() && at.time < rest - near()) inner.push_back(at);
    }
    found.push_back(way.beats.front());
    auto next = inner.begin();
    const std::size_t last = way.beats.size() - 1;
    for (std::size_t number = way.every; number < last; number += way.every) {
      const Beat& beat = way.beats[number];
      while (next != inner.end() && next->time <= beat.time) found.push_back(*next++);
      const bool follows = next != inner.end() && next->time - beat.time <= near();
      const bool led = next != inner.begin() && beat.time - (next - 1)->time <= near();
      if (!follows && !led) found.push_back(beat);
    }
    found.insert(found.end(), next, inner.end());
    found.push_back(way.beats.back());
    return found;
  }

  // Where the motion is at a moment of braking: all joints' positions, velocities and accelerations.
  void state(const Beat& beat, double* positions, double* velocities, double* accelerations) const {
    const double clock = std::clamp(beat.clock, 0.0, duration());
    const std::size_t piece = piece_at(motion(), clock);
    const double t = clock - times_[piece], inside = beat.clock < duration() ? 1.0 : 0.0;
    for (std::size_t joint = 0; joint < joints_; ++joint) {
      const double* c = coefficients_.data() + piece * joints_ + joint;
      double position = c[0];
      for (int power = 1; power < 6; ++power) position = position * t + c[static_cast<std::size_t>(power) * stride()];
      const Rates at = rates(motion(), piece, joint, t);
      positions[joint] = position;
      velocities[joint] = inside * at.velocity * beat.rate;
      accelerations[joint] = inside * (at.acceleration * beat.rate * beat.rate + at.velocity * beat.slope);
    }
  }
  std::size_t stride() const { return (times_.size() - 1) * joints_; }

  Points braked(double time, const Way& way) const {
    const std::vector<Beat> rows = moments(time, way);
    const std::size_t size = rows.size() * joints_;
    Points found{{}, Numbers(size), Numbers(size), Numbers(size)};
    found.times.reserve(rows.size());
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const std::size_t at = row * joints_;
      found.times.push_back(rows[row].time - rows.front().time);
      state(rows[row], &found.positions[at], &found.velocities[at], &found.accelerations[at]);
    }
    return found;
  }

  // Whether the polynomials between points keep the limits of acceleration and jerk at all times: by their extremes.
  // Where they did not on the clock of the motion, with other points or less hard, is looked at first.
  bool holds(const Way& way, double& suspect) const {
    const std::vector<Beat> rows = moments(way.begin, way);
    Numbers begin(3 * joints_), end(3 * joints_);
    const auto look = [&](const Beat& beat, Numbers& at) { state(beat, &at[0], &at[joints_], &at[2 * joints_]); };
    const auto breaks = [&](std::size_t i) {
      const double h = rows[i + 1].time - rows[i].time, h3 = h * h * h;
      for (std::size_t joint = 0; joint < joints_; ++joint) {
        const double p0 = begin[joint], v0 = begin[joints_ + joint], a0 = begin[2 * joints_ + joint];
        const double da = (end[2 * joints_ + joint] - a0) * h * h;
        const double dv = (end[joints_ + joint] - v0 - a0 * h) * h;
        const double dp = end[joint] - p0 - v0 * h - a0 * h * h / 2.0;
        const double c[6] = {(6.0 * dp - 3.0 * dv + da / 2.0) / (h3 * h * h), (-15.0 * dp + 7.0 * dv - da) / (h3 * h),
                             (10.0 * dp - 4.0 * dv + da / 2.0) / h3, a0 / 2.0, v0, p0};
        if (!keeps(c, h, acceleration_[joint], jerk_[joint])) return true;
      }
      return false;
    };
    const auto after = std::upper_bound(rows.begin() + 1, rows.end() - 1, suspect,
                                        [](double clock, const Beat& beat) { return clock < beat.clock; });
    const auto first = static_cast<std::size_t>(after - rows.begin()) - 1;
    look(rows[first], begin), look(rows[first + 1], end);
    if (breaks(first)) return false;
    look(rows.front(), begin);
    for (std::size_t i = 0; i + 1 < rows.size(); ++i, std::swap(begin, end)) {
      look(rows[i + 1], end);
      if (!breaks(i)) continue;
      suspect = (rows[i].clock + rows[i + 1].clock) / 2.0;
      return false;
    }
    return true;
  }

  bool keeps(const double* c, double h, double acceleration, double jerk) const {
    // The jerk of a quintic is a parabola: largest at an end, or where it turns.
    const double begin = 6.0 * c[2], slope = 24.0 * c[1], square = 60.0 * c[0];
    const auto jerk_at = [&](double t) { return std::abs(begin + t * (slope + t * square)); };
    const double most = jerk * (1.0 + choices_.excess), turn = -slope / (2.0 * square);
    if (!(jerk_at(0.0) <= most && jerk_at(h) <= most)) return false;
    if (turn > 0.0 && turn < h && !(jerk_at(turn) <= most)) return false;
    const auto found = extremes::of_piece(c, 1, h);
    return std::max(-found.low, found.high) <= acceleration * (1.0 + choices_.excess);
  }
};

}  // namespace stopping
