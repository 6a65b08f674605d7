// What a descent asks of a robot among its obstacles. The core `proximity` answers; the two are compiled apart and
// meet in this class alone.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace robot {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Rates = Eigen::Matrix<double, 3, Eigen::Dynamic>;  // by the group's positions

// Pairs of bodies that are near each other at many configurations, one entry each; good until the next question.
struct Near {
  std::size_t count;
  const std::int64_t *sample, *pair;
  const double *distance, *jacobian;  // the latter by the group's positions, a row for each entry
};

// A point of a frame, and the reference that it is seen from: the joints that carry them (0: the world), and where
// they are in these joints.
struct View {
  int joint, base;
  Matrix3 rotation, base_rotation;
  Vector3 point, base_origin;
};

// What is seen of it at one configuration.
struct Seen {
  Vector3 point;
  Matrix3 rotation;
  Rates point_rate, spin;  // the latter an angular velocity
};

// What was done: bounds of distance that were compared, and distances that were measured.
struct Work {
  std::int64_t bounds = 0, distances = 0;
};

class RobotQuery {
 public:
  virtual ~RobotQuery() = default;

  // Of the group, of the model (the world included), and pairs of bodies.
  virtual int positions() const = 0;
  virtual int joints() const = 0;
  virtual int pairs() const = 0;
  // Every pair nearer than its reach at configurations of the group, which lie one after the other. A distance above
  // the pair's aim may be too small by a share of what it exceeds the aim by; nearer ones are exact.
  virtual Near near(const double* positions, int samples, const std::vector<double>& reach,
                    const std::vector<double>& aim) = 0;
  virtual void see(const View& view, const double* positions, Seen& seen) = 0;
  virtual Work work() const = 0;
};

// What a descent asks of a robot's dynamics.
class RobotDynamics {
 public:
  virtual ~RobotDynamics() = default;

  virtual int dofs() const = 0;
  // Torques of the group's joints at a state of theirs.
  virtual void torques(const double* positions, const double* velocities, const double* accelerations,
                       double* torques) = 0;
  // Their derivatives by positions, velocities and accelerations, row by row.
  virtual void slopes(const double* positions, const double* velocities, const double* accelerations,
                      double* by_position, double* by_velocity, double* by_acceleration) = 0;
};

}  // namespace robot
