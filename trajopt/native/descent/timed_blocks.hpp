// Constraints of a motion whose samples have times.
#pragma once

#include "blocks.hpp"

namespace descent {

// Distance less error and margin of pairs that change with time by themselves, while both are there.
// The algorithm is `ClearanceInTime` of trajopt.optimise.transcription.spline_terms, which this is tested against.
struct DistancesInTime {
  Samples samples;
  std::vector<double> when;    // by sample
  std::vector<double> driven;  // positions of the joints that time drives, by sample
  robot::RobotQuery* among;    // of the group's joints and those
  std::vector<double> reach, margin, appears, expires;            // by pair, as all that follows
  std::vector<double> error, error_velocity, error_acceleration;  // of what is known of their places

  void evaluate(const Variables& variables, const Role& role, const double* x, Rows& rows) const;
};

// Torques as shares of their limits, at moments of a spline over time, where a joint needs much.
// The algorithm is `SplineTorque` of trajopt.optimise.transcription.spline_terms, which this is tested against.
struct Torques {
  Samples moments;                            // the weights of positions
  std::vector<double> velocity, acceleration;  // weights of these
  robot::RobotDynamics* dynamics;
  std::vector<double> effort;  // by joint; infinite for none
  double listed;               // share from which on a torque has a row

  void evaluate(const Variables& variables, const Role& role, const double* x, Rows& rows) const;
};

}  // namespace descent
