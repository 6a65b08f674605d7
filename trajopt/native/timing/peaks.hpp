// How far a trajectory uses its limits and leaves its path, also between its points, and the remedies.
//
// The same in plain Python, compared with this in the tests: tests/oracles/retiming/peaks.py.
#pragma once

#include <optional>

#include "extremes.hpp"
#include "motion.hpp"

namespace timing {

constexpr double kLeastRoom = 0.1;   // LEAST_ROOM of peaks.py: part of the room beside gravity that tightening leaves
constexpr double kAhead = 0.01;      // how far a piece may run ahead or behind, as a part of its length on the path
constexpr double kBinds = 0.97;      // part of a piece's speed to which a limit must hold it to count as deciding
constexpr int kRounds = 16;          // most stretches; one is enough but for rounding errors and friction
constexpr double kRounding = 1e-10;  // accepted relative overshoot; smaller than the safety factor on the limits
constexpr double kClear = 0.8;       // CLEAR of constraints.py: below this part of a limit three samples are enough
constexpr double kParts[] = {0.2, 0.4, 0.6, 0.8};  // where the torque is evaluated besides, if it is near a limit
constexpr double kQuarters[] = {0.25, 0.5, 0.75};  // where speeds of tools are, besides the ends

// Extremes in each of the k - 1 pieces of a trajectory.
struct Peaks {
  Table speed;      // largest absolute velocities, then speeds of tools, (k - 1, n + l)
  Table low, high;  // least and largest accelerations, then torques if they were measured, (k - 1, n + m)
  Table jerk;       // largest absolute jerks; empty if they were not measured
  bool torque;      // whether the torques were measured
};

// The largest absolute jerk of a piece: at its ends, or where the parabola turns.
inline double jerk_peak(const double c[6], double width) {
  const double square = 60.0 * c[0], rate = 24.0 * c[1], first = 6.0 * c[2];
  const double turn = square != 0.0 ? std::clamp(-rate / (2.0 * square), 0.0, width) : 0.0;
  const auto at = [&](double t) { return std::abs((square * t + rate) * t + first); };
  return std::max({std::abs(first), at(turn), at(width)});
}

// Bounds what has even samples: beyond them by a part of the second difference. The samples of piece i begin in row
// `row(i, 0)`.
template <typename Row>
void bounded(const Table& sampled, const Row& row, std::size_t samples, double supplement, std::size_t columns,
             double* low, double* high) {
  for (std::size_t column = 0; column < columns; ++column) {
    double least = sampled[row(0)][column], largest = least, bend = 0.0;
    for (std::size_t i = 1; i < samples; ++i) {
      const double value = sampled[row(i)][column];
      least = std::min(least, value), largest = std::max(largest, value);
      if (i + 1 < samples)
        bend = std::max(bend, std::abs(sampled[row(i + 1)][column] - 2.0 * value + sampled[row(i - 1)][column]));
    }
    low[column] = least - supplement * bend, high[column] = largest + supplement * bend;
  }
}

// Bounds the torque in each piece, in the columns behind the accelerations.
//
// It is evaluated at the points and half-way between. Parabolas through three even samples rise above them by an
// eighth of the second difference; where eight times as much stays clear of the limits, that is the bound. Else four
// samples between the points and twice what a parabola can add.
inline void measure_torque(const Motion& motion, const Limits& limits, Peaks& peaks) {
  peaks.torque = true;
  const std::size_t pieces = motion.pieces(), joints = motion.joints(), columns = limits.torque.size();
  States states(2 * pieces + 1, joints);
  for (std::size_t i = 0; i <= pieces; ++i) states.point(i, motion, i);
  for (std::size_t i = 0; i < pieces; ++i) states.within(pieces + 1 + i, motion, i, 0.5);
  const Table sampled = limits.torques(states.q, states.v, states.a);
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < pieces; ++i) {
    double *low = peaks.low[i] + joints, *high = peaks.high[i] + joints;
    const std::size_t rows[] = {i, pieces + 1 + i, i + 1};
    bounded(sampled, [&](std::size_t sample) { return rows[sample]; }, 3, 1.0, columns, low, high);
    bool clear = true;
    for (std::size_t column = 0; column < columns; ++column)
      clear &= !(std::max(high[column], -low[column]) > kClear * limits.torque[column]);
    if (!clear) near.push_back(i);
  }
  if (near.empty()) return;
  States inner(4 * near.size(), joints);
  for (std::size_t i = 0; i < near.size(); ++i)
    for (std::size_t part = 0; part < 4; ++part) inner.within(4 * i + part, motion, near[i], kParts[part]);
  Table six = limits.torques(inner.q, inner.v, inner.a);
  const std::size_t begin = six.rows;  // the points follow behind
  six.rows += pieces + 1;
  six.values.insert(six.values.end(), sampled.values.begin(), sampled.values.begin() + (pieces + 1) * columns);
  for (std::size_t i = 0; i < near.size(); ++i) {
    const std::size_t piece = near[i];
    const auto row = [&](std::size_t sample) {
      return sample == 0 ? begin + piece : sample == 5 ? begin + piece + 1 : 4 * i + sample - 1;
    };
    bounded(six, row, 6, 0.25, columns, peaks.low[piece] + joints, peaks.high[piece] + joints);
  }
}

// Bounds the speeds of tools in each piece, in the columns behind the velocities: at the points and at quarters
// between. A parabola through three even samples rises above them by an eighth of the second difference; eight times
// as much is added.
inline void measure_tools(const Motion& motion, const Limits& limits, Peaks& peaks) {
  const std::size_t pieces = motion.pieces(), joints = motion.joints(), columns = limits.tool.size();
  States states(4 * pieces + 1, joints);
  for (std::size_t i = 0; i <= pieces; ++i) states.point(4 * i, motion, i);
  for (std::size_t i = 0; i < pieces; ++i)
    for (std::size_t part = 0; part < 3; ++part) states.within(4 * i + 1 + part, motion, i, kQuarters[part]);
  const Table sampled = limits.speeds(states.q, states.v);
  Numbers low(columns);
  for (std::size_t i = 0; i < pieces; ++i)
    bounded(sampled, [&](std::size_t sample) { return 4 * i + sample; }, 5, 1.0, columns, low.data(),
            peaks.speed[i] + joints);
}

// Measures velocity and acceleration, and perhaps the jerk, exactly; speeds of tools at samples with a supplement.
inline Peaks motion_peaks(const Motion& motion, const Limits& limits, bool jerk) {
  const std::size_t pieces = motion.pieces(), joints = motion.joints();
  Peaks peaks{Table(pieces, limits.speed_columns()), Table(pieces, limits.row_columns()),
              Table(pieces, limits.row_columns()), jerk ? Table(pieces, joints) : Table(), false};
  for (std::size_t i = 0; i < pieces; ++i) {
    const Motion::Piece piece(motion, i);
    for (std::size_t joint = 0; joint < joints; ++joint) {
      double c[6];
      piece.coefficients(joint, c);
      const auto found = extremes::of_piece(c, 1, piece.width);
      peaks.speed[i][joint] = found.speed, peaks.low[i][joint] = found.low, peaks.high[i][joint] = found.high;
      if (jerk) peaks.jerk[i][joint] = jerk_peak(c, piece.width);
    }
  }
  if (limits.speeds) measure_tools(motion, limits, peaks);
  return peaks;
}

enum class Kind { kVelocity, kToolSpeed, kAcceleration, kTorque, kJerk };
constexpr std::size_t kKinds = 5;

// A limit: its kind, and its place among those of that kind.
struct Which {
  Kind kind = Kind::kVelocity;
  std::size_t place = 0;
};

// How much slower a trajectory must be run so that its limits hold.
struct Slowdown {
  double factor = 0.0;       // of all times; not above 1 when the limits hold
  std::size_t piece = 0;     // the piece that requires it
  Numbers factors;           // what each piece alone would require
  std::vector<Which> which;  // the limit that requires it there
};

// Finds by how much time must be stretched uniformly. Stretching by k divides velocities by k, by k² accelerations and
// that part of the torque which is not gravity, and by k³ jerks.
inline Slowdown slowdown(const DiscretisedPath& on, const Limits& limits, const Peaks& peaks) {
  const std::size_t joints = on.joints(), speeds = limits.speed_columns();
  const std::size_t rows = peaks.torque ? limits.row_columns() : joints;
  const double *velocity = on.bounds.velocity[0], *limit = on.bounds.rows[0];
  Slowdown needed;
  needed.factors.assign(on.pieces(), 0.0), needed.which.resize(on.pieces());
  for (std::size_t i = 0; i < on.pieces(); ++i) {
    double& most = needed.factors[i];
    const auto ask = [&](double factor, Kind first, Kind second, std::size_t column) {
      if (!(factor > most)) return;
      most = factor;
      needed.which[i] = column < joints ? Which{first, column} : Which{second, column - joints};
    };
    for (std::size_t column = 0; column < speeds; ++column)
      ask(peaks.speed[i][column] / (velocity[column] > 0.0 ? velocity[column] : 1.0), Kind::kVelocity, Kind::kToolSpeed,
          column);
    for (std::size_t column = 0; column < rows; ++column) {
      const double still = (on.rows.c[i][column] + on.rows.c[i + 1][column]) / 2.0, least = 1e-9 * limit[column];
      const double square = std::max((peaks.high[i][column] - still) / std::max(limit[column] - still, least),
                                     (still - peaks.low[i][column]) / std::max(limit[column] + still, least));
      if (square > most * most) ask(std::sqrt(square), Kind::kAcceleration, Kind::kTorque, column);
    }
    if (peaks.jerk.rows > 0 && on.bounds.jerk.rows > 0) {
      for (std::size_t joint = 0; joint < joints; ++joint) {
        const double allowed = on.bounds.jerk[i][joint], cube = peaks.jerk[i][joint] / (allowed > 0.0 ? allowed : 1.0);
        if (cube > most * most * most) ask(std::cbrt(cube), Kind::kJerk, Kind::kJerk, joint);
      }
    }
    if (most > needed.factor) needed.factor = most, needed.piece = i;
  }
  return needed;
}

// Lowers limits beside the pieces that exceed them, by as much as they do.
inline Bounds tightened(const DiscretisedPath& on, const Limits& limits, const Bounds& bounds, const Peaks& peaks) {
  const std::size_t pieces = on.pieces(), joints = on.joints(), speeds = limits.speed_columns();
  const std::size_t rows = limits.row_columns(), measured = peaks.torque ? rows : joints;
  const double *velocity = on.bounds.velocity[0], *limit = on.bounds.rows[0];
  Table over(pieces + 2, speeds, 1.0), excess(pieces + 1, rows);
  for (std::size_t i = 0; i < pieces; ++i) {
    for (std::size_t column = 0; column < speeds; ++column) {
      const double used = peaks.speed[i][column] / (velocity[column] > 0.0 ? velocity[column] : 1.0);
      for (std::size_t station = i; station < i + 3; ++station)  // before, within and after the piece
        over[station][column] = std::max(over[station][column], used);
    }
    for (std::size_t column = 0; column < measured; ++column) {
      const double beyond = std::max(peaks.high[i][column], -peaks.low[i][column]) - limit[column];
      for (std::size_t point = i; point < i + 2; ++point)
        excess[point][column] = std::max(excess[point][column], beyond);
    }
  }
  Bounds tight = bounds;
  for (std::size_t i = 0; i < over.values.size(); ++i) tight.velocity.values[i] /= over.values[i];
  for (std::size_t i = 0; i <= pieces; ++i) {
    for (std::size_t column = 0; column < rows; ++column) {
      const double still = std::abs(on.rows.c[i][column]), floor = still + kLeastRoom * (limit[column] - still);
      tight.rows[i][column] = std::max(bounds.rows[i][column] - excess[i][column], floor);
    }
  }
  if (peaks.jerk.rows == 0 || bounds.jerk.rows == 0) return tight;
  const auto share = [&](std::size_t piece, std::size_t joint) {
    const double allowed = on.bounds.jerk[piece][joint];
    return peaks.jerk[piece][joint] / (allowed > 0.0 ? allowed : 1.0);
  };
  for (std::size_t i = 0; i < pieces; ++i) {
    const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, pieces - 1);
    for (std::size_t joint = 0; joint < joints; ++joint)
      tight.jerk[i][joint] /= std::max({1.0, share(before, joint), share(i, joint), share(after, joint)});
  }
  return tight;
}

// Slows a trajectory down until it holds its limits, and measures that it does: nothing is left in `needed` then, or
// what it still exceeds: torque that does not decrease with the speed.
inline Motion hold(const DiscretisedPath& on, const Limits& limits, Motion motion, Slowdown& needed) {
  double beyond = 1e-12;
  for (int round = 0; round < kRounds && !(needed.factor <= 1.0 + kRounding); ++round, beyond *= 8.0) {
    // Each next stretch goes a little beyond, more and more: it must not end in rounding errors.
    motion = motion.slowed(needed.factor * (1.0 + beyond));
    Peaks peaks = motion_peaks(motion, limits, on.bounds.jerk.rows > 0);
    if (limits.torques) measure_torque(motion, limits, peaks);
    needed = slowdown(on, limits, peaks);
  }
  return motion;
}

// For which part of its duration each kind of limit decides how fast a motion is; `ratio` is how much shorter it was
// when the slowdown was measured.
inline std::vector<double> binding(const Slowdown& needed, double ratio, const Motion& final) {
  std::vector<double> parts(kKinds, 0.0);
  for (std::size_t i = 0; i < final.pieces(); ++i)
    if (needed.factors[i] * ratio >= kBinds)
      parts[static_cast<std::size_t>(needed.which[i].kind)] += final.width(i) / final.duration();
  return parts;
}

// The distance of the middle of each quintic piece from the path, the largest joint difference.
//
// The trajectory has the position, velocity and acceleration of the path at its points; between them it deviates most
// near the middle, with the sixth power of the length of the piece.
template <typename AnyPath>
Numbers path_deviation(const AnyPath& path, const Profile& profile, const Motion& motion) {
  const std::size_t joints = motion.joints();
  Numbers found(motion.pieces()), reached(joints), unused(joints), values(2 * joints);
  const double *on_path = values.data(), *tangent = on_path + joints;
  for (std::size_t i = 0; i < motion.pieces(); ++i) {
    const double h = profile.times[i + 1] - profile.times[i];
    // The path parameter half-way, by the quintic with the same ends.
    const double s = (profile.s[i] + profile.s[i + 1]) / 2.0 +
                     5.0 / 32.0 * h * (std::sqrt(profile.x[i]) - std::sqrt(profile.x[i + 1])) +
                     h * h / 64.0 * (profile.u[i] + profile.u[i + 1]);
    motion.within(i, 0.5, reached.data(), unused.data(), unused.data());
    path.at(s, 1, values.data());
    double square = 0.0, along = 0.0;
    for (std::size_t joint = 0; joint < joints; ++joint) {
      square += tangent[joint] * tangent[joint], along += (reached[joint] - on_path[joint]) * tangent[joint];
    }
    // Running a little ahead or behind is no deviation; at a reversal there is nothing ahead.
    const double most = kAhead * (profile.s[i + 1] - profile.s[i]);
    path.at(s + (square > 0.0 ? std::clamp(along / square, -most, most) : 0.0), 0, values.data());
    for (std::size_t joint = 0; joint < joints; ++joint)
      found[i] = std::max(found[i], std::abs(reached[joint] - on_path[joint]));
  }
  return found;
}

}  // namespace timing
