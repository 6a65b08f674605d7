#include "limits.hpp"

#include <cstdio>

namespace checker {
namespace {

std::string rates_fault(const Statement& statement, const Arm& arm, const Joint& joint) {
  static const char* const NAMES[] = {"velocity", "acceleration", "jerk"};
  const int cells = static_cast<int>(arm.grid.size()) - 1, count = arm.motion.count;
  for (int order = 0; order < 3; ++order) {
    const double limit = joint.rates[order], most = down(down(1.0 + statement.excess) * limit);
    if (!std::isfinite(limit)) continue;
    for (int cell = 0; cell < cells; ++cell) {
      const double reached = arm.motion.bounds[order + 1][cell * count + joint.coordinate].size();
      if (!(up(reached * std::abs(joint.factor)) <= most))
        return unshown(joint.name + " keeps its limit of " + NAMES[order], arm, cell);
    }
  }
  return "";
}

std::string positions_fault(const Statement& statement, const Arm& arm, const Joint& joint) {
  const int cells = static_cast<int>(arm.grid.size()) - 1;
  const double least = up(joint.lower - down(statement.excess * larger(1.0, std::abs(joint.lower))));
  const double most = down(joint.upper + down(statement.excess * larger(1.0, std::abs(joint.upper))));
  for (int cell = 0; cell < cells; ++cell) {
    const Range& range = arm.motion.bounds[0][cell * arm.motion.count + joint.coordinate];
    Range within;
    for (const double end : {range.low, range.high}) within.include(Ball{end} * Ball{joint.factor} + Ball{joint.offset});
    const bool above = std::isinf(joint.lower) || within.low >= least;
    if (!above || !(std::isinf(joint.upper) || within.high <= most))
      return unshown(joint.name + " keeps its limit of position", arm, cell);
  }
  return "";
}

// A fault if the acceleration of a joint with a limit of jerk may jump, also at the ends.
std::string jumps_fault(const Statement& statement, const Arm& arm, const Joint& joint) {
  if (!std::isfinite(joint.rates[2])) return "";
  const int cells = static_cast<int>(arm.grid.size()) - 1, count = arm.motion.count;
  const auto& [starts, ends] = arm.motion.accelerations;
  const double scale = std::isfinite(joint.rates[1]) ? joint.rates[1] : joint.rates[2];
  const double most = down(statement.excess * scale);
  for (int cell = 0; cell <= cells; ++cell) {
    Ball jump;
    if (cell == cells) {
      if (!statement.ends.rests) continue;
      jump = ends[(cell - 1) * count + joint.coordinate];
    } else {
      const Ball before = cell ? ends[(cell - 1) * count + joint.coordinate] : Ball{statement.ends.accelerations[joint.coordinate]};
      jump = starts[cell * count + joint.coordinate] - before;
    }
    if (!(up(jump.size() * std::abs(joint.factor)) <= most))
      return "the acceleration of " + joint.name + " may jump, but its jerk is limited";
  }
  return "";
}

std::string ends_fault(const Statement& statement, const Arm& arm) {
  const Ends& ends = statement.ends;
  const Motion& motion = arm.motion;
  const int last = (static_cast<int>(arm.grid.size()) - 1) * motion.count;
  bool accelerates = false;
  for (const double each : ends.accelerations) accelerates = accelerates || each != 0.0;
  for (int at = 0; at < statement.curve.count(); ++at) {
    const auto near = [](Ball found, double stated, double tolerance) {
      return (found - Ball{stated}).size() <= tolerance;
    };
    if (!near(motion.positions[at], ends.positions[at], ends.tolerance)) return "the motion does not start where it must";
    if (!near(motion.velocities[at], ends.velocities[at], ends.speed))
      return "the motion does not start with the velocity that is stated";
    if (accelerates && !near(motion.accelerations[0][at], ends.accelerations[at], ends.speed))
      return "the motion does not start with the acceleration that is stated";
    if (ends.rests && !near(motion.velocities[last + at], 0.0, ends.speed)) return "the motion does not end at rest";
  }
  return "";
}

}  // namespace

std::string unshown(const std::string& words, const Arm& arm, int cell) {
  char span[80];
  std::snprintf(span, sizeof span, " from %.6g to %.6g s", arm.grid[cell], arm.grid[cell + 1]);
  return "it is not shown that " + words + span;
}

std::string limits_fault(const Statement& statement, const Arm& arm) {
  for (const Joint& joint : statement.joints)
    for (const auto fault : {positions_fault, rates_fault, jumps_fault})
      if (const std::string found = fault(statement, arm, joint); !found.empty()) return found;
  return ends_fault(statement, arm);
}

}  // namespace checker
