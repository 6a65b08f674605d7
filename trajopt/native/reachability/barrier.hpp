// Minimises the duration of a jerk-limited profile from within its limits.
//
// The unknowns are control values z of a squared clock speed. Limits come in blocks of three neighbouring values:
// `linear` rows with constant limits above and below, then `jerk` rows, half of them at the start of an interval
// and half at its end, with the limit jerk / sqrt(y) to both sides, y the squared speed there. Newton steps
// minimise the duration plus a barrier at every limit; each takes the tangent of jerk / sqrt(y) at hand, which
// lies below it, so that the Hessian is positive definite and no step within the tangents leaves the limits.
//
// The same in plain Python, compared with this in the tests: tests/oracles/barrier.py.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
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

struct Program {
  const double *weight, *bound, *rows, *above, *below, *jerk, *speed;
  std::size_t blocks, linear, jerks;  // jerks: rows of both ends

  std::size_t columns() const { return linear + jerks; }
  std::size_t unknowns() const { return blocks + 2; }
};

inline double dot(const double* a, const double* z) { return a[0] * z[0] + a[1] * z[1] + a[2] * z[2]; }

// A sum of logarithms; one of them for eight numbers.
class Logarithms {
 public:
  void add(double value) {
    product_ *= value;
    if (++count_ == 8) flush();
  }
  double total() {
    flush();
    return sum_;
  }

 private:
  void flush() { sum_ += std::log(product_), product_ = 1.0, count_ = 0; }
  double sum_ = 0.0, product_ = 1.0;
  int count_ = 0;
};

struct State {
  std::vector<double> z, above, below;
  std::vector<double> root;  // sqrt(y) at both ends of each interval
  bool inside;
  double barrier;   // sum of the logarithms of all distances from limits
  double duration;  // about what the motion takes
};

inline void evaluate(const Program& program, State& state) {
  const std::size_t columns = program.columns(), half = program.jerks / 2;
  state.above.resize(program.blocks * columns), state.below.resize(program.blocks * columns);
  state.root.resize(2 * program.blocks);
  state.inside = true, state.duration = 0.0;
  Logarithms sum;
  for (std::size_t i = 0; i < program.unknowns(); ++i) {
    const double left = program.bound[i] - state.z[i];
    if (!(left > 0.0 && state.z[i] > 0.0)) {
      state.inside = false;
      return;
    }
    sum.add(left);
    state.duration += program.weight[i] / std::sqrt(state.z[i]);
  }
  bool held = true;  // what is no number is not held
  for (std::size_t i = 0; i < program.blocks; ++i) {
    const double* z = &state.z[i];
    const double* row = program.rows + 3 * columns * i;
    double *above = &state.above[columns * i], *below = &state.below[columns * i];
    for (std::size_t j = 0; j < program.linear; ++j) {
      const double value = dot(row + 3 * j, z);
      above[j] = program.above[program.linear * i + j] - value;
      below[j] = program.below[program.linear * i + j] + value;
    }
    for (std::size_t end = 0; end < 2; ++end) {
      const double root = std::sqrt(dot(program.speed + 6 * i + 3 * end, z));
      state.root[2 * i + end] = root;
      const double* jerk = program.jerk + program.jerks * i + half * end;
      for (std::size_t j = 0; j < half; ++j) {
        const std::size_t at = program.linear + half * end + j;
        const double value = dot(row + 3 * at, z), limit = jerk[j] / root;
        above[at] = limit - value, below[at] = limit + value;
      }
    }
    for (std::size_t j = 0; j < columns; ++j) {
      held &= (above[j] > 0.0) & (below[j] > 0.0);
      sum.add(above[j]), sum.add(below[j]);
    }
  }
  state.inside = held;
  state.barrier = sum.total();
}

inline double merit(const State& state, double weight) {
  return state.inside ? weight * state.duration - state.barrier : kInfinity;
}

// Gradient and bands of the Hessian of the merit (with tangents): diagonal, and the two beside it.
struct Derivatives {
  std::vector<double> gradient, diagonal, first, second;
};

inline void differentiate(const Program& program, const State& state, double weight, Derivatives& d) {
  const std::size_t count = program.unknowns(), columns = program.columns(), half = program.jerks / 2;
  d.gradient.assign(count, 0.0), d.diagonal.assign(count, 0.0);
  d.first.assign(count, 0.0), d.second.assign(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const double left = 1.0 / (program.bound[i] - state.z[i]);
    const double cost = weight * program.weight[i] / (state.z[i] * std::sqrt(state.z[i]));
    d.gradient[i] = -0.5 * cost + left;
    d.diagonal[i] = 0.75 * cost / state.z[i] + left * left;
  }
  for (std::size_t i = 0; i < program.blocks; ++i) {
    double g[3] = {}, h[6] = {};  // h: 00, 01, 02, 11, 12, 22
    const auto add = [&](const double* a, double pull, double both) {
      const double s0 = both * a[0], s1 = both * a[1], s2 = both * a[2];
      g[0] += pull * a[0], g[1] += pull * a[1], g[2] += pull * a[2];
      h[0] += s0 * a[0], h[1] += s0 * a[1], h[2] += s0 * a[2];
      h[3] += s1 * a[1], h[4] += s1 * a[2], h[5] += s2 * a[2];
    };
    const double* row = program.rows + 3 * columns * i;
    const double *above = &state.above[columns * i], *below = &state.below[columns * i];
    for (std::size_t j = 0; j < program.linear; ++j) {
      const double up = 1.0 / above[j], down = 1.0 / below[j];
      add(row + 3 * j, up - down, up * up + down * down);
    }
    for (std::size_t end = 0; end < 2; ++end) {
      const double* e = program.speed + 6 * i + 3 * end;
      const double root = state.root[2 * i + end], steep = -0.5 / (root * root * root);
      const double* jerk = program.jerk + program.jerks * i + half * end;
      double falling = 0.0, square = 0.0, c[3] = {};
      for (std::size_t j = 0; j < half; ++j) {
        const std::size_t at = program.linear + half * end + j;
        const double* a = row + 3 * at;
        const double up = 1.0 / above[at], down = 1.0 / below[at], slope = steep * jerk[j];
        const double both = up * up + down * down, apart = (up * up - down * down) * slope;
        add(a, up - down, both);
        falling -= slope * (up + down), square += slope * slope * both;
        c[0] += apart * a[0], c[1] += apart * a[1], c[2] += apart * a[2];
      }
      add(e, falling, square);
      h[0] -= 2.0 * c[0] * e[0], h[1] -= c[0] * e[1] + c[1] * e[0], h[2] -= c[0] * e[2] + c[2] * e[0];
      h[3] -= 2.0 * c[1] * e[1], h[4] -= c[1] * e[2] + c[2] * e[1], h[5] -= 2.0 * c[2] * e[2];
    }
    for (std::size_t j = 0; j < 3; ++j) d.gradient[i + j] += g[j];
    d.diagonal[i] += h[0], d.diagonal[i + 1] += h[3], d.diagonal[i + 2] += h[5];
    d.first[i] += h[1], d.first[i + 1] += h[4], d.second[i] += h[2];
  }
  // The first two control values are one unknown, and the last two.
  const std::size_t last = count - 1;
  d.gradient[1] += d.gradient[0], d.diagonal[1] += d.diagonal[0] + 2.0 * d.first[0], d.first[1] += d.second[0];
  d.gradient[last - 1] += d.gradient[last], d.diagonal[last - 1] += d.diagonal[last] + 2.0 * d.first[last - 1];
  d.first[last - 2] += d.second[last - 2];
}

// Solves for the Newton step in place of the unknowns 1 to count - 2 (L D L^T of five bands), and ties the others.
inline std::vector<double> newton_step(Derivatives& d) {
  const std::size_t begin = 1, end = d.gradient.size() - 1;
  std::vector<double> step(d.gradient.size(), 0.0);
  auto &diagonal = d.diagonal, &first = d.first, &second = d.second;
  for (std::size_t i = begin; i < end; ++i) {
    const double near = i + 1 < end ? first[i] : 0.0, far = i + 2 < end ? second[i] : 0.0, pivot = diagonal[i];
    step[i] -= d.gradient[i];
    first[i] = near / pivot, second[i] = far / pivot;
    if (i + 1 < end) {
      diagonal[i + 1] -= first[i] * near, first[i + 1] -= first[i] * far;
      step[i + 1] -= first[i] * step[i];
    }
    if (i + 2 < end) {
      diagonal[i + 2] -= second[i] * far;
      step[i + 2] -= second[i] * step[i];
    }
  }
  for (std::size_t i = end; i-- > begin;) {
    step[i] /= diagonal[i];
    if (i + 1 < end) step[i] -= first[i] * step[i + 1];
    if (i + 2 < end) step[i] -= second[i] * step[i + 2];
  }
  step.front() = step[begin], step.back() = step[end - 1];
  return step;
}

// How far along a direction all limits, the jerk's by their tangents, hold.
inline double reach(const Program& program, const State& state, const std::vector<double>& step) {
  const std::size_t columns = program.columns(), half = program.jerks / 2;
  double used = 0.0;
  for (std::size_t i = 0; i < program.unknowns(); ++i)
    used = std::max({used, step[i] / (program.bound[i] - state.z[i]), -step[i] / state.z[i]});
  for (std::size_t i = 0; i < program.blocks; ++i) {
    const double* row = program.rows + 3 * columns * i;
    const double *above = &state.above[columns * i], *below = &state.below[columns * i];
    for (std::size_t j = 0; j < program.linear; ++j) {
      const double value = dot(row + 3 * j, &step[i]);
      used = std::max(used, value > 0.0 ? value / above[j] : -value / below[j]);
    }
    for (std::size_t end = 0; end < 2; ++end) {
      const double root = state.root[2 * i + end], y = dot(program.speed + 6 * i + 3 * end, &step[i]);
      const double lowered = -0.5 * y / (root * root * root);
      const double* jerk = program.jerk + program.jerks * i + half * end;
      for (std::size_t j = 0; j < half; ++j) {
        const std::size_t at = program.linear + half * end + j;
        const double value = dot(row + 3 * at, &step[i]), limit = lowered * jerk[j];
        used = std::max({used, (value - limit) / above[at], (-value - limit) / below[at]});
      }
    }
  }
  return used > 0.0 ? 1.0 / used : kInfinity;
}

// Runs a profile slower or faster, uniformly, until it is well within all limits; false if no such speed is found.
inline bool scale_inside(const Program& program, State& state) {
  const std::vector<double> given = state.z;
  const auto fits = [&](double factor) {
    for (std::size_t i = 0; i < given.size(); ++i) state.z[i] = given[i] * factor;
    evaluate(program, state);
    return state.inside;
  };
  double factor = 1.0;
  for (int scaling = 0; scaling < kScalings && fits(factor); ++scaling) factor *= 2.0;
  for (int scaling = 0; scaling < 2 * kScalings && !fits(factor); ++scaling) factor /= 2.0;
  if (!fits(factor)) return false;
  for (const double part : {1.5, 1.25})
    if (fits(factor * part)) factor *= part;
  return fits(factor * kStart);
}

// Nearly the least control values from `z`; `first_gap` and `gap` are parts of the duration that barriers leave.
// Empty if no uniform scaling of `z` is within all limits.
inline std::vector<double> minimise(const Program& program, std::vector<double> z, double first_gap, double gap,
                                    int& steps) {
  State state, trial;
  state.z = std::move(z);
  steps = 0;
  if (!scale_inside(program, state)) return {};
  Derivatives derivatives;
  const double rows = double(2 * state.above.size() + state.z.size());
  for (double open = first_gap;; open = std::max(gap, open * kTighter)) {
    const double weight = rows / (open * state.duration);
    for (int round = 0; round < kSteps; ++round) {
      differentiate(program, state, weight, derivatives);
      const std::vector<double> gradient = derivatives.gradient;
      const std::vector<double> step = newton_step(derivatives);
      double decrement = 0.0;
      for (std::size_t i = 1; i + 1 < step.size(); ++i) decrement -= gradient[i] * step[i];
      double part = std::min(1.0, kNear * reach(program, state, step));
      const double before = merit(state, weight);
      bool better = false;
      for (int halving = 0; halving < kHalvings && !better; ++halving, part /= 2.0) {
        trial.z.resize(step.size());
        for (std::size_t i = 0; i < step.size(); ++i) trial.z[i] = state.z[i] + part * step[i];
        evaluate(program, trial);
        better = merit(trial, weight) <= before - kArmijo * part * decrement;
      }
      ++steps;
      if (!better) break;
      std::swap(state, trial);
      if (decrement < kSettled * rows) break;
    }
    if (open <= gap) return state.z;
  }
}

}  // namespace barrier
