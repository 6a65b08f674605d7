// Minimises the duration of a jerk-limited profile from within its limits.
//
// The unknowns are control values z of a squared clock speed. Limits come in blocks of three neighbouring values:
// `linear` rows with constant limits above and below, then `jerk` rows, half of them at the start of an interval
// and half at its end, with the limit jerk / sqrt(y) to both sides, y the squared speed there. Newton steps
// minimise the duration plus a barrier at every limit; each takes the tangent of jerk / sqrt(y) at hand, which
// lies below it, so that the Hessian is positive definite and no step within the tangents leaves the limits.
//
// Every table is stored limit by limit, the blocks next to each other, and filled up to a multiple of `kLanes` with
// blocks that limit nothing: so all loops run over some blocks at once, and become vector instructions.
//
// The same in plain Python, compared with this in the tests: tests/oracles/barrier.py.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace barrier {

constexpr double kTighter = 0.1;    // TIGHTER of barrier.py, and so on
constexpr int kSteps = 12;
constexpr double kSettled = 5e-4;
constexpr double kNear = 0.95;
constexpr double kStart = 0.9;
constexpr int kHalvings = 20;
constexpr double kArmijo = 0.1;
constexpr int kScalings = 200;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Numbers = std::vector<double>;

constexpr std::size_t kLanes = 8;

struct Program {
  std::size_t blocks = 0, linear = 0, half = 0;  // half: jerk rows of one end
  std::size_t stride = 0;                        // blocks, those that limit nothing included
  Numbers weight;        // of 1 / sqrt(z) in the duration, blocks + 2
  Numbers bound;         // what z stays below, blocks + 2
  Numbers rows;          // factors of three neighbouring values, (columns, 3, stride)
  Numbers above, below;  // limits of the linear rows and of their negatives, (linear, stride)
  Numbers jerk;          // limits of the other rows times sqrt(y), (2 half, stride)
  Numbers speed;         // factors of y at the starts and at the ends, (2, 3, stride)

  Program() = default;
  Program(std::size_t blocks, std::size_t linear, std::size_t half)
      : blocks(blocks), linear(linear), half(half), stride((blocks + kLanes - 1) / kLanes * kLanes), weight(blocks + 2),
        bound(blocks + 2), rows(columns() * 3 * stride), above(linear * stride, 1.0), below(linear * stride, 1.0),
        jerk(2 * half * stride, 1.0), speed(6 * stride) {
    // The speed of a block that is none is a control value that is none, too: it stays 1.
    for (std::size_t block = blocks; block < stride; ++block) speed_row(0, 2, block) = speed_row(1, 2, block) = 1.0;
  }

  std::size_t columns() const { return linear + 2 * half; }
  std::size_t unknowns() const { return blocks + 2; }
  std::size_t limits() const { return 2 * columns() * blocks + unknowns(); }
  double& row(std::size_t column, std::size_t place, std::size_t block) {
    return rows[(3 * column + place) * stride + block];
  }
  double& speed_row(std::size_t end, std::size_t place, std::size_t block) {
    return speed[(3 * end + place) * stride + block];
  }
};

// A program at some control values.
struct State {
  Numbers z;             // the unknowns, and ones where blocks are none, stride + 2
  Numbers above, below;  // distances of all rows from their limits, (columns, stride)
  Numbers root;          // sqrt(y) at the starts and at the ends, (2, stride)
  bool inside = false;
  double barrier = 0.0;   // sum of the logarithms of all distances from limits
  double duration = 0.0;  // about what the motion takes

  // What evaluating needs meanwhile, kept for the next time.
  Numbers held, value, limit, inverse, product;
  std::vector<std::int64_t> power;
};

void evaluate(const Program& program, State& state);

// Runs a profile slower or faster, uniformly, until it is well within all limits; false if no such speed is found.
bool scale_inside(const Program& program, State& state);

// Nearly the least control values from `z`; `first_gap` and `gap` are parts of the duration that barriers leave.
// Empty if no uniform scaling of `z` is within all limits.
Numbers minimise(const Program& program, Numbers z, double first_gap, double gap, int& steps);

}  // namespace barrier
