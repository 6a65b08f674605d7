// How fast pairs of bodies can approach each other; see trajopt/driving/servo_program.py.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "braking.hpp"

namespace servo {

// A body: the joint that carries it, a sphere around it in the joint's frame, and what moves the joint.
struct Body {
  std::size_t joint;
  std::array<double, 3> centre;
  double radius;
  std::vector<std::size_t> carriers;
};

struct BodySpeeds {
  std::vector<Body> bodies;
  std::vector<std::int64_t> first, second;  // of each pair
  std::size_t group, moving;                // joints of the group, and of the model
  Numbers mimic;                            // moving x group: speed of each joint of the model
  Numbers levers;                           // pairs x group: the approach of a pair by the speed of each joint

  // At the middle of the bounds no point of a body is faster than its centre plus its angular speed times its radius;
  // the rest is bounded by levers. Placements and Jacobian (6 x moving) are those of the model's joints.
  Numbers nearer(const double* rotation, const double* translation, const double* jacobian, const double* lower,
                 const double* upper) const {
    Numbers rates(moving, 0.0), fastest(group), spread(group);
    for (std::size_t joint = 0; joint < group; ++joint) {
      const double middle = (lower[joint] + upper[joint]) / 2.0;
      for (std::size_t number = 0; number < moving; ++number) rates[number] += mimic[number * group + joint] * middle;
      fastest[joint] = std::max(-lower[joint], upper[joint]);
      spread[joint] = (upper[joint] - lower[joint]) / 2.0;
    }
    Numbers speed;
    for (const Body& body : bodies)
      speed.push_back(middle_speed(body, rotation + 9 * body.joint, translation + 3 * body.joint, jacobian, rates));
    Numbers found(first.size());
    for (std::size_t pair = 0; pair < found.size(); ++pair) {
      const double* lever = levers.data() + pair * group;
      double by_levers = 0.0, rest = 0.0;
      for (std::size_t joint = 0; joint < group; ++joint) {
        by_levers += lever[joint] * fastest[joint];
        rest += lever[joint] * spread[joint];
      }
      found[pair] = std::min(by_levers, speed[first[pair]] + speed[second[pair]] + rest);
    }
    return found;
  }

 private:
  double middle_speed(const Body& body, const double* rotation, const double* translation, const double* jacobian,
                      const Numbers& rates) const {
    double twist[6] = {};
    for (std::size_t row = 0; row < 6; ++row)
      for (const std::size_t number : body.carriers) twist[row] += jacobian[row * moving + number] * rates[number];
    double centre[3];
    for (std::size_t row = 0; row < 3; ++row) {
      centre[row] = translation[row];
      for (std::size_t column = 0; column < 3; ++column) centre[row] += rotation[3 * row + column] * body.centre[column];
    }
    const double *linear = twist, *angular = twist + 3;
    const double x = linear[0] + angular[1] * centre[2] - angular[2] * centre[1];
    const double y = linear[1] + angular[2] * centre[0] - angular[0] * centre[2];
    const double z = linear[2] + angular[0] * centre[1] - angular[1] * centre[0];
    const double turning = std::sqrt(angular[0] * angular[0] + angular[1] * angular[1] + angular[2] * angular[2]);
    return std::sqrt(x * x + y * y + z * z) + turning * body.radius;
  }
};

}  // namespace servo
