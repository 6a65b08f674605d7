// Smoothing a polyline: exact in its knots, except at corners too sharp for the tolerance.
//
// The control points lie on the polyline (Schoenberg's spline, which reproduces straight lines and never oscillates),
// and are moved so that the spline passes through every knot. Where it then leaves the polyline by more than the
// tolerance, the knot is replaced by a rounded corner: its control points stay on the polyline, and two spline knots
// beside it set where the rounding begins.
//
// The same in plain Python, compared with this in the tests: tests/oracles/retiming/smoothing.py.
#pragma once

#include <functional>
#include <limits>
#include <stdexcept>

#include "paths.hpp"

namespace timing {

// Positions on the smooth path and as many on the polyline -> how far any body moves between them. The largest joint
// difference counts where there is none.
using Deviation = std::function<Numbers(const Table&, const Table&)>;

constexpr std::size_t kSamples = 8;  // SAMPLES of smoothing.py, and so on: even, for each piece
constexpr double kBetween = 0.98;    // part of the tolerance that samples may use: arcs between are little higher
// Samples whose neighbours both stay below this part of the largest are not measured: they do not exceed the largest,
// for a piece leaves the polyline by a cubic (Lagrange's weights of four even samples tell).
constexpr double kDominated = 0.5;
constexpr double kNegligible = 1e-9;  // joint differences up to this are not worth a call of the bound
constexpr double kShrink = 0.1;       // smallest factor by which a rounding shrinks in one step
constexpr double kMerged = 1e-9;  // knots nearer to the one before than this part of the whole length are left out

constexpr const char* kTooFar = "has knots so far apart, or so near, that their distances are no numbers";

// Straight segments between corners, none of them of zero length.
//
// The parameter s grows on each segment by the Euclidean norm over the joints of |dq| / v, v the velocity limit: it is
// about the time that the segment takes at full speed, and makes radians and metres comparable.
struct Polyline {
  Numbers origin, goal;
  Numbers parameters;  // of each corner, start and goal included, from 0
  Table corners;       // relative to the origin

  double length() const { return parameters.back(); }

  // Positions relative to the origin.
  void at(double s, double* value) const {
    const std::size_t segment =
        std::upper_bound(parameters.begin() + 1, parameters.end() - 1, s) - parameters.begin() - 1;
    const double begin = parameters[segment], part = (s - begin) / (parameters[segment + 1] - begin);
    const double *from = corners[segment], *to = corners[segment + 1];
    for (std::size_t joint = 0; joint < corners.columns; ++joint)
      value[joint] = from[joint] * (1.0 - part) + to[joint] * part;
  }
};

// Leaves out repeated knots and lays the parameter along the rest. A joint whose velocity limit is zero or infinite
// counts with 1.
inline Polyline polyline(const Table& knots, const Numbers& velocity) {
  const std::size_t joints = knots.columns, last = knots.rows - 1;
  const auto apart = [&](std::size_t a, std::size_t b) {
    double sum = 0.0;
    for (std::size_t joint = 0; joint < joints; ++joint) {
      const double scale = std::isfinite(velocity[joint]) && velocity[joint] > 0.0 ? velocity[joint] : 1.0;
      const double step = (knots[b][joint] - knots[0][joint] - (knots[a][joint] - knots[0][joint])) / scale;
      sum += step * step;
    }
    return std::sqrt(sum);
  };
  double least = 0.0;
  for (std::size_t i = 0; i < last; ++i) least += apart(i, i + 1);
  least *= kMerged;
  std::vector<std::size_t> kept{0};
  for (std::size_t i = 1; i <= last; ++i)
    if (apart(kept.back(), i) > least) kept.push_back(i);
  if (!std::isfinite(least) || kept.size() < 2) throw std::overflow_error(kTooFar);
  kept.back() = last;
  Polyline line{Numbers(knots[0], knots[0] + joints), Numbers(knots[last], knots[last] + joints), {0.0},
                Table(kept.size(), joints)};
  for (std::size_t i = 0; i < kept.size(); ++i) {
    for (std::size_t joint = 0; joint < joints; ++joint)
      line.corners[i][joint] = knots[kept[i]][joint] - knots[0][joint];
    if (i > 0) line.parameters.push_back(line.parameters.back() + apart(kept[i - 1], kept[i]));
  }
  return line;
}

// A smooth path, and its largest deviation at the samples, by the measure of the bound.
struct Smoothing {
  SmoothPath path;
  double deviation;
};

// Rounded corners, and the size of each rounding in the parameter.
struct Rounding {
  std::vector<bool> rounded;
  Numbers reach;
};

// Knots of the spline, and the places among them of polyline knots to pass through.
inline Numbers spline_knots(const Polyline& line, const Rounding& rounding, std::vector<std::size_t>& through) {
  Numbers knots{0.0};
  through.clear();
  const std::size_t last = line.parameters.size() - 1;
  for (std::size_t i = 1; i <= last; ++i) {
    const double begin = line.parameters[i - 1], end = line.parameters[i];
    const bool leaves = rounding.rounded[i - 1], enters = rounding.rounded[i];
    const double leave = begin + rounding.reach[i - 1], enter = end - rounding.reach[i];
    if (leaves && enters && enter - leave < 1e-3 * (end - begin)) {
      knots.push_back((leave + enter) / 2.0);
    } else {
      if (leaves) knots.push_back(leave);
      if (enters) knots.push_back(enter);
    }
    if (!rounding.rounded[i] && i < last) through.push_back(knots.size());
    knots.push_back(end);
  }
  return knots;
}

// Control points on the polyline, moved where the spline must pass through a knot: the one with the most weight there
// and, by their small weights, its two neighbours if they are moved, too. The system has three bands and is totally
// positive, so that elimination needs no pivots. Source: de Boor and Pinkus, Backward error analysis for totally
// positive linear systems, Numerische Mathematik 27, 1977.
inline Table spline_control(const Polyline& line, const Numbers& knots, const std::vector<std::size_t>& through) {
  const std::size_t last = knots.size() - 1, joints = line.corners.columns;
  const auto knot = [&](std::size_t place, std::size_t back) {  // `place` - `back`, the end knots repeated
    return knots[place < back ? 0 : std::min(place - back, last)];
  };
  Table control(last + 3, joints);
  for (std::size_t i = 0; i < control.rows; ++i) {
    // Greville abscissae. The sum of three equal numbers, divided by three, may differ from them in the last bit.
    const double middle = (knot(i, 2) + knot(i, 1) + knot(i, 0)) / 3.0;
    line.at(i == 0 ? knots.front() : i + 1 == control.rows ? knots.back() : middle, control[i]);
  }
  if (through.empty()) return control;
  const std::size_t count = through.size();
  Table wanted(count, joints);
  Numbers before(count), pivot(count), after(count), on_line(joints);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t p = through[k];
    const double x = knots[p];
    const double a = (x - knot(p, 2)) / (knots[p + 1] - knot(p, 2));
    const double b = (x - knots[p - 1]) / (knot(p + 2, 0) - knots[p - 1]);
    const double c = (x - knots[p - 1]) / (knots[p + 1] - knots[p - 1]);
    const double weight[3] = {(1.0 - c) * (1.0 - a), (1.0 - c) * a + c * (1.0 - b), c * b};
    line.at(x, on_line.data());
    for (std::size_t joint = 0; joint < joints; ++joint)
      wanted[k][joint] = on_line[joint] - weight[0] * control[p][joint] - weight[1] * control[p + 1][joint] -
                         weight[2] * control[p + 2][joint];
    before[k] = k > 0 && through[k - 1] + 1 == p ? weight[0] : 0.0;
    pivot[k] = weight[1];
    after[k] = k + 1 < count && p + 1 == through[k + 1] ? weight[2] : 0.0;
  }
  for (std::size_t k = 1; k < count; ++k) {
    const double factor = before[k] / pivot[k - 1];
    pivot[k] -= factor * after[k - 1];
    for (std::size_t joint = 0; joint < joints; ++joint) wanted[k][joint] -= factor * wanted[k - 1][joint];
  }
  for (std::size_t k = count; k-- > 0;) {
    for (std::size_t joint = 0; joint < joints; ++joint) {
      if (k + 1 < count) wanted[k][joint] -= after[k] * wanted[k + 1][joint];
      wanted[k][joint] /= pivot[k];
      control[through[k] + 1][joint] += wanted[k][joint];
    }
  }
  return control;
}

// Measures some samples, in place.
inline void ask(const Deviation& deviation, const Table& on_path, const Table& on_line,
                const std::vector<std::size_t>& asked, Numbers& far) {
  if (asked.empty()) return;
  Table first(asked.size(), on_path.columns), second = first;
  for (std::size_t i = 0; i < asked.size(); ++i) first.set(i, on_path[asked[i]]), second.set(i, on_line[asked[i]]);
  const Numbers found = deviation(first, second);
  for (std::size_t i = 0; i < asked.size(); ++i) far[asked[i]] = found[i];
}

// The distances of samples; every other one only where it can be the largest: else the larger of the neighbours.
inline Numbers measured(const Deviation& deviation, const Table& on_path, const Table& on_line) {
  const std::size_t count = on_path.rows;
  Numbers apart(count, 0.0);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t joint = 0; joint < on_path.columns; ++joint)
      apart[i] = std::max(apart[i], std::abs(on_path[i][joint] - on_line[i][joint]));
  if (!deviation) return apart;
  Numbers far(count, 0.0);
  std::vector<std::size_t> asked;
  for (std::size_t i = 0; i < count; i += 2)
    if (apart[i] > kNegligible) asked.push_back(i);
  ask(deviation, on_path, on_line, asked, far);
  double largest = 0.0;
  for (std::size_t i = 1; i < count; i += 2) {
    if (apart[i] > kNegligible) far[i] = std::max(far[i - 1], i + 1 < count ? far[i + 1] : 0.0);
    largest = std::max({largest, far[i], far[i - 1]});
  }
  asked.clear();
  for (std::size_t i = 1; i < count; i += 2)
    if (apart[i] > kNegligible && far[i] >= kDominated * largest) asked.push_back(i);
  ask(deviation, on_path, on_line, asked, far);
  return far;
}

// Rounds the corners beside which the deviation is too large, or shrinks their rounding.
//
// Too large a deviation (`ratio` to the tolerance above 1, at samples `s`) rounds the nearer corner of its segment, or
// else the other one; only when both are rounded (or an end) does the nearer rounding shrink. False if nothing changed.
inline bool round_corners(const Numbers& corners, const Numbers& s, const Numbers& ratio, Rounding& rounding) {
  const std::size_t last = corners.size() - 1;
  const auto sharp = [&](std::size_t corner) { return corner > 0 && corner < last && !rounding.rounded[corner]; };
  Numbers worst(last + 1, 0.0);
  for (std::size_t i = 0; i < s.size(); ++i) {
    const std::size_t found = std::upper_bound(corners.begin(), corners.end(), s[i]) - corners.begin();
    const std::size_t right = std::clamp<std::size_t>(found, 1, last), left = right - 1;
    const bool near_left = s[i] - corners[left] <= corners[right] - s[i];
    const std::size_t near = (near_left && left > 0) || right == last ? left : right, other = left + right - near;
    const std::size_t blamed = sharp(other) && !sharp(near) ? other : near;
    worst[blamed] = std::max(worst[blamed], ratio[i]);
  }
  bool changed = false;
  for (std::size_t corner = 0; corner <= last; ++corner) {
    if (!(worst[corner] > 1.0)) continue;
    changed = true;
    if (rounding.rounded[corner]) rounding.reach[corner] *= std::max(kShrink, 0.95 / worst[corner]);
    else if (sharp(corner)) rounding.rounded[corner] = true;
  }
  return changed;
}

// Finds a smooth path within the tolerance of a polyline of positive length.
//
// Each step either rounds one more corner or shrinks a rounding, and the deviation at a rounded corner is proportional
// to its size: so this ends. Control points are held within the position limits, hence so is the whole path.
inline Smoothing smooth(const Polyline& line, const Numbers& lower, const Numbers& upper, const Deviation& deviation,
                        double tolerance) {
  const std::size_t count = line.corners.rows, joints = line.corners.columns;
  Numbers least(joints), most(joints);
  for (std::size_t joint = 0; joint < joints; ++joint) {
    least[joint] = lower[joint] - line.origin[joint], most[joint] = upper[joint] - line.origin[joint];
    for (std::size_t corner = 0; corner < count; ++corner) {
      least[joint] = std::min(least[joint], line.corners[corner][joint]);
      most[joint] = std::max(most[joint], line.corners[corner][joint]);
    }
  }
  Rounding rounding{std::vector<bool>(count, false), Numbers(count, std::numeric_limits<double>::infinity())};
  for (std::size_t i = 1; i + 1 < count; ++i)
    rounding.reach[i] =
        std::min(line.parameters[i] - line.parameters[i - 1], line.parameters[i + 1] - line.parameters[i]) / 2.0;
  std::vector<std::size_t> through;
  while (true) {
    const Numbers knots = spline_knots(line, rounding, through);
    // A rounding can become too small for its knots to differ.
    if (!std::is_sorted(knots.begin(), knots.end(), std::less_equal<double>())) throw std::overflow_error(kTooFar);
    Table control = spline_control(line, knots, through);
    for (std::size_t i = 0; i < control.rows; ++i)
      for (std::size_t joint = 0; joint < joints; ++joint)
        control[i][joint] = std::clamp(control[i][joint], least[joint], most[joint]);
    SmoothPath path(line.origin, line.goal, knots, std::move(control));
    Numbers s;
    for (std::size_t piece = 0; piece + 1 < knots.size(); ++piece)
      for (std::size_t i = 0; i < kSamples; ++i)
        s.push_back(knots[piece] + (knots[piece + 1] - knots[piece]) * static_cast<double>(i) / double(kSamples));
    Table on_path(s.size(), joints), on_line(s.size(), joints);
    for (std::size_t i = 0; i < s.size(); ++i) {
      path.at(s[i], 0, on_path[i]), line.at(s[i], on_line[i]);
      for (std::size_t joint = 0; joint < joints; ++joint) on_line[i][joint] += line.origin[joint];
    }
    Numbers far = measured(deviation, on_path, on_line);
    const double worst = *std::max_element(far.begin(), far.end());
    if (worst <= kBetween * tolerance || count == 2) return {std::move(path), worst};
    for (double& each : far) each /= kBetween * tolerance;
    if (!round_corners(line.parameters, s, far, rounding)) throw std::overflow_error(kTooFar);
  }
}

}  // namespace timing
