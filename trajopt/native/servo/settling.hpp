// The program of a tick: velocities between bounds that follow a task best, and keep limits on approach speeds.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "../banded/step.hpp"
#include "braking.hpp"

namespace servo {

// Rows over the velocities of the joints, and a number for each.
struct LinearRows {
  std::size_t count;
  const double* matrix;  // count x joints
  const double* number;  // count

  const double* row(std::size_t at, std::size_t joints) const { return matrix + at * joints; }
};

struct Weights {
  double damping;         // of a joint's velocity, relative to its limit
  double penalty;         // of what an approach speed exceeds its limit by
  double still;           // joints whose bounds are closer, as a share of the limit, do not move
  double accuracy;        // of the program's value
  double regularisation;  // of the program's Hessian
  int max_iterations;
};

// Rows of a program of one knot.
class OneKnot {
 public:
  explicit OneKnot(std::size_t joints) : joints_(joints) {}

  void add(const double* row, double value) {
    jacobian_.insert(jacobian_.end(), row, row + joints_);
    value_.push_back(value);
    knot_.push_back(0);
  }
  std::size_t size() const { return value_.size(); }
  banded::Stencils rows() const {
    return {int(value_.size()), 1, int(joints_), value_.data(), jacobian_.data(), knot_.data()};
  }

 private:
  std::size_t joints_;
  Numbers jacobian_, value_;
  std::vector<std::int64_t> knot_;
};

inline double dot(const double* row, const Numbers& of) {
  double sum = 0.0;
  for (std::size_t joint = 0; joint < of.size(); ++joint) sum += row[joint] * of[joint];
  return sum;
}

// The task's rows should have its numbers, those of the approach at least theirs. Nothing if the program has no solution.
inline std::optional<Numbers> settle(const LinearRows& task, const LinearRows& approach, const Numbers& lower,
                                     const Numbers& upper, const Numbers& velocity, const Weights& weights) {
  const std::size_t joints = lower.size();
  Numbers middle(joints), down(joints), up(joints), unit(joints, 0.0);
  std::vector<char> moves(joints);
  for (std::size_t joint = 0; joint < joints; ++joint) {
    middle[joint] = (lower[joint] + upper[joint]) / 2.0;
    down[joint] = lower[joint] - middle[joint], up[joint] = upper[joint] - middle[joint];
    moves[joint] = upper[joint] - lower[joint] > weights.still * velocity[joint];
  }
  banded::Program program(int(joints), moves);
  OneKnot command(joints), kept(joints);
  for (std::size_t at = 0; at < task.count; ++at)
    command.add(task.row(at, joints), dot(task.row(at, joints), middle) - task.number[at]);
  for (std::size_t joint = 0; joint < joints; ++joint) {
    unit[joint] = 1.0 / velocity[joint];
    command.add(unit.data(), middle[joint] / velocity[joint]);
    unit[joint] = 0.0;
  }
  Numbers weight(task.count, 1.0), bound;
  weight.resize(command.size(), weights.damping);
  program.add_squared(command.rows(), weight.data());
  for (std::size_t at = 0; at < approach.count; ++at) {
    const double* row = approach.row(at, joints);
    double slowest = 0.0;
    for (std::size_t joint = 0; joint < joints; ++joint)
      slowest += std::min(row[joint] * lower[joint], row[joint] * upper[joint]);
    if (!(slowest < approach.number[at])) continue;  // no velocities between the bounds break it
    kept.add(row, dot(row, middle));
    bound.push_back(approach.number[at]);
  }
  const Numbers endless(kept.size(), std::numeric_limits<double>::infinity()), penalty(kept.size(), weights.penalty);
  program.add_excess(kept.rows(), bound.data(), endless.data(), penalty.data());
  banded::Options options;
  options.accuracy = weights.accuracy, options.max_iterations = weights.max_iterations;
  banded::Step step = banded::best_step(program, down.data(), up.data(), weights.regularisation, options);
  if (step.outcome == banded::Outcome::kFailed) return std::nullopt;
  for (std::size_t joint = 0; joint < joints; ++joint)
    step.change[joint] = std::min(std::max(middle[joint] + step.change[joint], lower[joint]), upper[joint]);
  return std::move(step.change);
}

}  // namespace servo
