// Velocities of joints after a tick of the servo, and the time in which they stop; see trajopt/driving/servo_program.py.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace servo {

using Numbers = std::vector<double>;

// Limits of the joints, and the constants of the tick.
struct Braking {
  Numbers lower, upper, velocity, acceleration, jerk, delay;
  double period, cycle, excess, inset;  // [s], [s], share of a limit, [rad | m]

  std::size_t joints() const { return velocity.size(); }

  // The time in which velocities are braked [s].
  double time(const double* velocities) const {
    double slowest = 0.0;
    for (std::size_t joint = 0; joint < joints(); ++joint)
      slowest = std::max(slowest, std::abs(velocities[joint]) / acceleration[joint]);
    return slowest + *std::max_element(delay.begin(), delay.end());
  }

  // The velocities at which joints can settle. `state`: positions, velocities and accelerations, row by row.
  void bounds(const double* state, double* least, double* greatest) const {
    const std::size_t count = joints();
    for (std::size_t joint = 0; joint < count; ++joint) {
      const double position = state[joint], now = state[2 * count + joint], most = acceleration[joint];
      const double change = jerk[joint] * period, fastest = velocity[joint] * (1.0 - excess);
      const double low = settled(state, joint, std::clamp(now - change, -most, most));
      const double high = settled(state, joint, std::clamp(now + change, -most, most));
      const double down = std::min(fastest, brakeable(joint, position - lower[joint]));
      const double up = std::min(fastest, brakeable(joint, upper[joint] - position));
      least[joint] = std::min(std::max(-down, low), high);
      greatest[joint] = std::min(std::max(up, low), high);
    }
  }

  // The state after the tick for velocities at which the joints settle.
  void after(const double* state, const double* settled, double* then) const {
    const std::size_t count = joints();
    for (std::size_t joint = 0; joint < count; ++joint) {
      const double position = state[joint], speed = state[count + joint], before = state[2 * count + joint];
      const double most = acceleration[joint];
      const double reached = std::clamp(wanted(speed, before, joint, settled[joint]), -most, most);
      then[joint] = position + period * (speed + period * (2.0 * before + reached) / 6.0);
      then[count + joint] = speed + period * (before + reached) / 2.0;
      then[2 * count + joint] = reached;
    }
  }

 private:
  // The velocity at which a joint settles after an acceleration at the end of the tick.
  double settled(const double* state, std::size_t joint, double reached) const {
    const double gone = std::max(std::abs(reached) / jerk[joint] + cycle, period);
    return state[joints() + joint] + period * (state[2 * joints() + joint] + reached) / 2.0 + reached * gone / 2.0;
  }

  // The acceleration at the end of the tick after which a joint settles at a velocity: the inverse of `settled`.
  double wanted(double speed, double before, std::size_t joint, double settled) const {
    const double half = (period + cycle) / 2.0, change = settled - speed - period * before / 2.0;
    const double size = std::abs(change);
    const double longer = jerk[joint] * (std::sqrt(half * half + 2.0 * size / jerk[joint]) - half);
    return std::copysign(std::min(size / period, longer), change);
  }

  // The largest velocity w at a distance w t + w^2 / 2a, where t is the delay.
  double brakeable(std::size_t joint, double distance) const {
    const double most = acceleration[joint], delayed = most * delay[joint];
    return std::sqrt(delayed * delayed + 2.0 * most * std::max(distance - inset, 0.0)) - delayed;
  }
};

}  // namespace servo
