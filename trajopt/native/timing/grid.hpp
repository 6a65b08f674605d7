// A smooth path on a grid, the limits there, and the fastest profile within them.
//
// The grid has all knots of the path, and points between them evenly in time.
//
// The same in plain Python, compared with this in the tests: tests/oracles/retiming/discretised_path.py.
#pragma once

#include "limits.hpp"
#include "passes.hpp"
#include "profile.hpp"

namespace timing {

constexpr double kTurn = 0.25;        // TURN of discretised_path.py: at sharp corners the speed changes fast
constexpr double kMostBends = 150.0;  // most intervals that are added because a path turns
constexpr double kPi = 3.14159265358979323846;

// Limits at every point of a grid, so that they can be tightened in some places only.
struct Bounds {
  Table velocity;  // of the n joints and l tools at the k + 1 stations
  Table rows;      // of acceleration and torque at the k grid points, (k, n + m)
  Table jerk;      // of the n joints in the k - 1 intervals; empty where it is not limited
};

// A smooth path on a grid of k points.
struct DiscretisedPath {
  Numbers s;         // grid
  Table q, dq, ddq;  // positions at the grid points and their derivatives by s, (k, n)
  Table slope;       // dq/ds at the stations, and what the tools move per s, (k + 1, n + l)
  Rows rows;         // the n accelerations, then the m limited torques
  Bounds bounds;     // the limits, the same at all points

  std::size_t points() const { return s.size(); }
  std::size_t pieces() const { return s.size() - 1; }
  std::size_t joints() const { return q.columns; }
};

inline Table repeated(const Numbers& first, const Numbers& second, std::size_t count) {
  Table table(count, first.size() + second.size());
  for (std::size_t row = 0; row < count; ++row)
    std::copy(second.begin(), second.end(), std::copy(first.begin(), first.end(), table[row]));
  return table;
}

inline void torque_rows(const TorqueAlong& along, const SmoothPath&, double s, double* a, double* b, double* c,
                        std::size_t) {
  along.at(s, a, b, c);
}

// d²s/dt² = s' u + s'' x and (ds/dt)² = s'^2 x.
inline void torque_rows(const TorqueAlong& along, const RampedPath& ramp, double clock, double* a, double* b, double* c,
                        std::size_t columns) {
  double way[3];
  ramp.way(clock, 2, way);
  along.at(way[0], a, b, c);
  for (std::size_t column = 0; column < columns; ++column) {
    b[column] = a[column] * way[2] + b[column] * (way[1] * way[1]);
    a[column] *= way[1];
  }
}

// Evaluates a path and its limits on a grid, from 0 to its length.
template <typename AnyPath>
DiscretisedPath discretised(const AnyPath& path, Numbers s, const Limits& limits, const TorqueAlong& along) {
  const std::size_t count = s.size(), n = path.joints(), m = limits.torque.size(), l = limits.tool.size();
  DiscretisedPath on{std::move(s),        Table(count, n), Table(count, n), Table(count, n),
                     Table(count + 1, n + l), {Table(count, n + m), Table(count, n + m), Table(count, n + m)}, {}};
  Numbers values(3 * n);
  for (std::size_t i = 0; i < count; ++i) {
    path.at(on.s[i], 2, values.data());
    on.q.set(i, values.data()), on.dq.set(i, values.data() + n), on.ddq.set(i, values.data() + 2 * n);
    std::copy(on.dq[i], on.dq[i] + n, on.rows.a[i]), std::copy(on.ddq[i], on.ddq[i] + n, on.rows.b[i]);
    if (m > 0) torque_rows(along, path, on.s[i], on.rows.a[i] + n, on.rows.b[i] + n, on.rows.c[i] + n, m);
  }
  const Numbers station = stations(on.s);
  Table q(count + 1, n), v(count + 1, n);
  for (std::size_t i = 0; i <= count; ++i) {
    path.at(station[i], 1, values.data());
    q.set(i, values.data()), v.set(i, values.data() + n), std::copy(v[i], v[i] + n, on.slope[i]);
  }
  if (l > 0) {
    const Table speeds = limits.speeds(q, v);
    for (std::size_t i = 0; i <= count; ++i) std::copy(speeds[i], speeds[i] + l, on.slope[i] + n);
  }
  on.bounds.velocity = repeated(limits.velocity, limits.tool, count + 1);
  on.bounds.rows = repeated(limits.acceleration, limits.torque, count);
  return on;
}

// Finds the fastest profile from rest to rest within limits that hold at the grid points.
inline Profile fastest_profile(const DiscretisedPath& on, const Bounds& bounds) {
  const std::size_t count = on.points();
  const Numbers station = stations(on.s);
  Numbers distance(count), bound(count + 1);
  for (std::size_t i = 0; i < count; ++i) distance[i] = station[i + 1] - station[i];
  for (std::size_t i = 0; i <= count; ++i)
    bound[i] = squared_speed_bound(on.slope[i], bounds.velocity[i], on.slope.columns);
  const Rows& rows = on.rows;
  return Profile(on.s,
                 passes::fastest({distance.data(), rows.a.values.data(), rows.b.values.data(), rows.c.values.data(),
                                  bounds.rows.values.data(), bound.data(), count, rows.a.columns}),
                 true);
}

// Part of a half turn whose cosine runs along the path: near both ends like sqrt(distance).
inline Numbers phase(const Numbers& s, double length) {
  Numbers found;
  for (const double each : s) found.push_back(std::acos(std::clamp(1.0 - 2.0 * each / length, -1.0, 1.0)) / kPi);
  return found;
}

// How many parts of each span between marks on a clock make about `count` intervals of equal time.
inline std::vector<std::size_t> even_parts(const Numbers& marks, double count) {
  std::vector<std::size_t> parts;
  for (std::size_t i = 0; i + 1 < marks.size(); ++i)
    parts.push_back(
        parts_of(std::nearbyint((marks[i + 1] - marks[i]) * (count / (marks.back() - marks.front())))));
  return parts;
}

inline Numbers grid_of(const Numbers& knots, const Numbers& phases, const std::vector<std::size_t>& parts) {
  Numbers grid;
  for (const double each : phases) {
    const double sine = std::sin(kPi / 2.0 * each);
    grid.push_back(knots.back() * (sine * sine));
  }
  grid.front() = knots.front();
  for (std::size_t i = 0, place = 0; i < parts.size(); ++i) grid[place += parts[i]] = knots[i + 1];
  return grid;
}

// Cuts a path when nothing is known of its speed but that it starts and ends at rest: evenly in the phase, which from
// rest grows as time does.
inline Numbers first_grid(const Numbers& knots, std::size_t count) {
  const Numbers marks = phase(knots, knots.back());
  const auto parts = even_parts(marks, static_cast<double>(count));
  return grid_of(knots, cut(marks, parts), parts);
}

// Cuts a path so that a profile takes about the same time in each interval, and less in bends. All knots of the path
// are in the grid of the profile; `turning` is how far the path has turned at each of its points.
inline Numbers even_grid(const Numbers& knots, const Profile& profile, const Numbers& turning, std::size_t count) {
  const double bend = std::min(1.0 / kTurn, kMostBends / std::max(turning.back(), 1e-9));
  Numbers clock(profile.s.size()), marks;
  for (std::size_t i = 0; i < clock.size(); ++i)
    clock[i] = profile.times[i] * (static_cast<double>(count) / profile.duration()) + turning[i] * bend;
  for (const double knot : knots) {
    const auto place = std::lower_bound(profile.s.begin(), profile.s.end() - 1, knot) - profile.s.begin();
    marks.push_back(clock[place]);
  }
  const auto parts = even_parts(marks, std::nearbyint(clock.back()));
  const Numbers phases = phase(profile.s, knots.back());
  Numbers cuts = cut(marks, parts);
  for (double& each : cuts) each = interpolated(clock, phases, each);
  return grid_of(knots, cuts, parts);
}

// Halves intervals that are too coarse, and those beside them.
inline Numbers finer_grid(const Numbers& s, const std::vector<bool>& coarse) {
  Numbers finer;
  const std::size_t last = coarse.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    finer.push_back(s[i]);
    if (coarse[i] || (i > 0 && coarse[i - 1]) || (i < last && coarse[i + 1])) finer.push_back((s[i] + s[i + 1]) / 2.0);
  }
  finer.push_back(s.back());
  return finer;
}

// How far a path has turned at each grid point: the angle of its tangent, summed up, in joints over their speeds; a
// joint with a limit of zero stands still.
inline Numbers turned(const DiscretisedPath& on, const Numbers& velocity) {
  const std::size_t joints = on.joints();
  double steepest = 0.0;
  Numbers scale(joints), rate(on.points()), turning{0.0};
  for (std::size_t joint = 0; joint < joints; ++joint) scale[joint] = velocity[joint] > 0.0 ? velocity[joint] : 1.0;
  for (std::size_t i = 0; i < on.points(); ++i)
    for (std::size_t joint = 0; joint < joints; ++joint)
      steepest = std::max(steepest, std::abs(on.dq[i][joint] / scale[joint]));
  for (std::size_t i = 0; i < on.points(); ++i) {
    double square = 0.0, along = 0.0, across = 0.0;
    for (std::size_t joint = 0; joint < joints; ++joint) square += std::pow(on.dq[i][joint] / scale[joint], 2);
    const double size = std::max(std::sqrt(square), 1e-9 * steepest);
    for (std::size_t joint = 0; joint < joints; ++joint)
      along += on.dq[i][joint] / scale[joint] / size * (on.ddq[i][joint] / scale[joint]);
    for (std::size_t joint = 0; joint < joints; ++joint)
      across += std::pow(
          (on.ddq[i][joint] / scale[joint] - on.dq[i][joint] / scale[joint] / size * along) / size, 2);
    rate[i] = std::sqrt(across);
  }
  // A reversal turns by half a turn at once, where the rate has a pole: no interval turns farther.
  for (std::size_t i = 0; i < on.pieces(); ++i)
    turning.push_back(turning.back() + std::min((rate[i] + rate[i + 1]) / 2.0 * (on.s[i + 1] - on.s[i]), kPi));
  return turning;
}

}  // namespace timing
