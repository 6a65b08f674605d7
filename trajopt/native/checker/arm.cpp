#include "arm.hpp"

#include <algorithm>

namespace checker {
namespace {

using Matrix = std::array<double, 9>;

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix found{};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      for (int at = 0; at < 3; ++at) found[3 * row + column] += a[3 * row + at] * b[3 * at + column];
  return found;
}

}  // namespace

// Errors of the axis count once in its cross product K and twice in K^2, which is taken 1 - cos q <= 2 times. The
// rounding of K^2, F K, F K^2, F - C and of the sum at a position is below 80 U.
Turning turning(const Joint& joint) {
  const Vec& a = joint.axis;
  const Matrix across{0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0};
  Turning found;
  found.still = joint.place.rotation.m;
  found.error = grown(joint.place.rotation.r + 6.0 * a.r + 100.0 * U + 2.0 * WAVE_ERROR);
  if (!joint.turns) return found;
  found.of_sine = product(joint.place.rotation.m, across);
  found.of_cosine = product(found.of_sine, across);
  for (int at = 0; at < 9; ++at) {
    found.of_cosine[at] = -found.of_cosine[at];
    found.still[at] -= found.of_cosine[at];
  }
  return found;
}

// A rotation by an angle that is wrong by r is wrong by r at most.
Turn Turning::at(Ball position) const {
  const auto [sine, cosine] = sine_and_cosine(position.c);
  Turn found;
  for (int at = 0; at < 9; ++at) found.m[at] = still[at] + of_sine[at] * sine + of_cosine[at] * cosine;
  found.r = grown(position.r + error);
  return found;
}

Arm::Arm(const Statement& stated, const std::vector<double>& times)
    : statement(stated), grid(times), motion(motion_on(stated, times)), joints(static_cast<int>(stated.joints.size()) + 1) {
  const int count = static_cast<int>(grid.size()), robot = stated.curve.count();
  own.resize(count * joints), rotation.resize(count * joints);
  translation.resize(count * joints), axes.resize(count * joints);
  carried_by.assign(joints * joints, false), driven.assign(joints, false), moved.assign(joints, false);
  carried_by[0] = true;
  for (int joint = 1; joint < joints; ++joint) {
    const Joint& item = stated.joints[joint - 1];
    const int before = item.place.joint;
    for (int other = 0; other < joints; ++other)
      carried_by[joint * joints + other] = carried_by[before * joints + other] || other == joint;
    driven[joint] = driven[before] || item.coordinate >= robot;
    moved[joint] = moved[before] || item.coordinate < robot;
    const Turning turns = turning(item);
    const Vec slides = slide(item);
    for (int time = 0; time < count; ++time) {
      const Ball position =
          motion.positions[time * motion.count + item.coordinate] * Ball{item.factor} + Ball{item.offset};
      const Turn turn = turns.at(item.turns ? position : Ball{});
      const int here = at(time, joint), there = at(time, before);
      const Vec origin = item.turns ? item.place.translation : item.place.translation + slides * position;
      own[here] = turn;
      rotation[here] = rotation[there] * turn;
      translation[here] = translation[there] + turned(rotation[there], origin);
      axes[here] = turned(rotation[here], item.axis);
    }
  }
  for (int order = 0; order < 3; ++order) {
    auto& largest = largest_[order];
    largest.resize(1);
    largest[0].assign((count - 1) * joints, 0.0);
    for (int cell = 0; cell + 1 < count; ++cell)
      for (int joint = 1; joint < joints; ++joint) {
        const Joint& item = stated.joints[joint - 1];
        const double size = motion.bounds[order + 1][cell * motion.count + item.coordinate].size();
        largest[0][at(cell, joint)] = up(size * std::abs(item.factor));
      }
    for (int width = 1; 2 * width < count; width *= 2) {
      const auto& half = largest.back();
      std::vector<double> whole((count - 2 * width) * joints);
      for (std::size_t at = 0; at < whole.size(); ++at) whole[at] = larger(half[at], half[at + width * joints]);
      largest.push_back(std::move(whole));
    }
    rates[order] = largest[0];
  }
}

int Arm::shared(int one, int other) const {
  int joint = std::min(one, other);
  while (!carries(joint, one) || !carries(joint, other)) --joint;
  return joint;
}

std::array<double, 3> Arm::fastest(int joint, int begin, int end) const {
  int level = 0;
  while (2 << level <= end - begin) ++level;
  std::array<double, 3> found;
  for (int order = 0; order < 3; ++order) {
    const auto& widest = largest_[order][level];
    found[order] = larger(widest[at(begin, joint)], widest[at(end - (1 << level), joint)]);
  }
  return found;
}

Travel::Travel(const Arm& arm, int joint, const Vec& centre, double radius) : arm_(arm), centre_(centre), radius_(radius) {
  for (; joint > 0; joint = arm.parent(joint)) chain_.push_back(joint);
  levers_.assign(arm.grid.size() * chain_.size(), -1.0);
}

const double* Travel::levers(int time) {
  double* found = &levers_[time * chain_.size()];
  if (*found >= 0.0) return found;
  const Vec place = arm_.point(time, chain_[0], centre_);
  for (std::size_t link = 0; link < chain_.size(); ++link) {
    const int here = arm_.at(time, chain_[link]);
    found[link] = up(cross(place - arm_.translation[here], arm_.axes[here]).length() + radius_);
  }
  return found;
}

PointTravel Travel::bounds(int begin, int end, int seen) {
  if (chain_.empty() || chain_[0] == seen) return {};
  const double half = up(arm_.grid[end] - arm_.grid[begin]) / 2.0;
  const double *first = levers(begin), *last = levers(end);
  double v = 0.0, u = 0.0, k = 0.0;
  for (std::size_t link = 0; link < chain_.size() && chain_[link] != seen; ++link) {
    const auto [w, a, j] = arm_.fastest(chain_[link], begin, end);
    if (arm_.statement.joints[chain_[link] - 1].turns) {
      const double r = larger(first[link], last[link]) + v * half;
      k += 3.0 * w * u + 3.0 * (a + w * w) * v + (j + 3.0 * w * a + w * w * w) * r;
      u += 2.0 * w * v + (w * w + a) * r;
      v += w * r;
    } else {
      v += w, u += a, k += j;
    }
  }
  return {v * SAFE, u * SAFE, k * SAFE};
}

}  // namespace checker
