#include "barrier.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "../processors.hpp"

namespace barrier {
namespace {

constexpr std::size_t kFactors = 4;  // rows whose distances are multiplied before the powers of two are taken out

// Keeps products as a number in [1, 2) and a power of two, so that one logarithm serves for many.
FOR_SEVERAL_PROCESSORS
void take_out_powers(double* __restrict product, std::int64_t* __restrict power, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    std::int64_t bits;
    std::memcpy(&bits, product + i, sizeof bits);
    power[i] += (bits >> 52) - 1023;  // the sign is none
    bits = (bits & 0x000fffffffffffff) | 0x3ff0000000000000;
    std::memcpy(product + i, &bits, sizeof bits);
  }
}

// The values of a row in all blocks.
FOR_SEVERAL_PROCESSORS
void values_of(const double* __restrict row, const double* __restrict z, double* __restrict value, std::size_t n) {
  const double *a0 = row, *a1 = row + n, *a2 = row + 2 * n;
  for (std::size_t i = 0; i < n; ++i) value[i] = a0[i] * z[i] + a1[i] * z[i + 1] + a2[i] * z[i + 2];
}

// The distances of a row's values from its limits in all blocks, multiplied into `product`; `held` is cleared where
// they are not positive, or no numbers.
FOR_SEVERAL_PROCESSORS
void distances(const double* __restrict value, const double* __restrict upper, const double* __restrict lower,
               double* __restrict above, double* __restrict below, double* __restrict product,
               double* __restrict held, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const double high = upper[i] - value[i], low = lower[i] + value[i];
    above[i] = high, below[i] = low, product[i] *= high * low;
    held[i] = high > 0.0 ? held[i] : 0.0;
    held[i] = low > 0.0 ? held[i] : 0.0;
  }
}

// 1 / above and 1 / below, by one division.
FOR_SEVERAL_PROCESSORS
void reciprocals(const double* __restrict above, const double* __restrict below, double* __restrict up,
                 double* __restrict down, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const double both = 1.0 / (above[i] * below[i]);
    up[i] = below[i] * both, down[i] = above[i] * both;
  }
}

// Square roots, and their reciprocals.
FOR_SEVERAL_PROCESSORS
void roots(double* __restrict value, double* __restrict inverse, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) value[i] = std::sqrt(value[i]), inverse[i] = 1.0 / value[i];
}

// The larger of `most` and what a step uses up of the distances, in all blocks.
FOR_SEVERAL_PROCESSORS
void use_up(const double* __restrict value, const double* __restrict limit, const double* __restrict up,
            const double* __restrict down, double* __restrict most, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const double over = (value[i] - limit[i]) * up[i], under = (-value[i] - limit[i]) * down[i];
    const double larger = over > under ? over : under;
    most[i] = larger > most[i] ? larger : most[i];
  }
}

// The sum of the logarithms of products and powers of two.
double sum_of_logarithms(const Numbers& product, const std::vector<std::int64_t>& power) {
  std::int64_t powers = 0;
  double sum = 0.0, together = 1.0;
  for (std::size_t i = 0; i < product.size(); ++i) {
    powers += power[i], together *= product[i];
    if (i % 512 == 511) sum += std::log(together), together = 1.0;  // 2^512 is still a number
  }
  return sum + std::log(together) + std::log(2.0) * static_cast<double>(powers);
}

double merit(const State& state, double weight) {
  return state.inside ? weight * state.duration - state.barrier : kInfinity;
}

// Gradient and bands of the Hessian of the merit (with tangents): diagonal, and the two beside it. And what they are
// made of: reciprocal distances of all rows, and the slopes of 1 / sqrt(y) by y.
struct Derivatives {
  Numbers gradient, diagonal, first, second;
  Numbers up, down, steep;
};

// What the rows of some blocks add to gradient and Hessian, and what the falling limits of the jerk rows at one end
// add: by themselves, and mixed with the row of the speed.
struct Sums {
  double g0[kLanes] = {}, g1[kLanes] = {}, g2[kLanes] = {};
  double h00[kLanes] = {}, h01[kLanes] = {}, h02[kLanes] = {}, h11[kLanes] = {}, h12[kLanes] = {}, h22[kLanes] = {};
  double c0[kLanes] = {}, c1[kLanes] = {}, c2[kLanes] = {}, pull[kLanes] = {}, square[kLanes] = {};

  [[gnu::always_inline]] void add(const double* a, std::size_t stride, const double* up, const double* down) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const double a0 = a[i], a1 = a[stride + i], a2 = a[2 * stride + i];
      const double apart = up[i] - down[i], both = up[i] * up[i] + down[i] * down[i];
      const double s0 = both * a0, s1 = both * a1, s2 = both * a2;
      g0[i] += apart * a0, g1[i] += apart * a1, g2[i] += apart * a2;
      h00[i] += s0 * a0, h01[i] += s0 * a1, h02[i] += s0 * a2;
      h11[i] += s1 * a1, h12[i] += s1 * a2, h22[i] += s2 * a2;
    }
  }

  [[gnu::always_inline]] void add_falling(const double* a, std::size_t stride, const double* up, const double* down,
                                          const double* jerk, const double* steep) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const double slope = steep[i] * jerk[i], both = up[i] * up[i] + down[i] * down[i];
      const double mixed = (up[i] * up[i] - down[i] * down[i]) * slope;
      c0[i] += mixed * a[i], c1[i] += mixed * a[stride + i], c2[i] += mixed * a[2 * stride + i];
      pull[i] -= slope * (up[i] + down[i]), square[i] += slope * slope * both;
    }
  }

  // Adds the row of the speed at one end, and begins anew for the other.
  [[gnu::always_inline]] void add_speed(const double* e, std::size_t stride) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const double e0 = e[i], e1 = e[stride + i], e2 = e[2 * stride + i];
      g0[i] += pull[i] * e0, g1[i] += pull[i] * e1, g2[i] += pull[i] * e2;
      h00[i] += square[i] * e0 * e0 - 2.0 * c0[i] * e0, h01[i] += square[i] * e0 * e1 - c0[i] * e1 - c1[i] * e0;
      h02[i] += square[i] * e0 * e2 - c0[i] * e2 - c2[i] * e0, h11[i] += square[i] * e1 * e1 - 2.0 * c1[i] * e1;
      h12[i] += square[i] * e1 * e2 - c1[i] * e2 - c2[i] * e1, h22[i] += square[i] * e2 * e2 - 2.0 * c2[i] * e2;
      c0[i] = c1[i] = c2[i] = pull[i] = square[i] = 0.0;
    }
  }

  void hand_to(Derivatives& d, std::size_t begin, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = begin + i;
      d.gradient[at] += g0[i], d.gradient[at + 1] += g1[i], d.gradient[at + 2] += g2[i];
      d.diagonal[at] += h00[i], d.diagonal[at + 1] += h11[i], d.diagonal[at + 2] += h22[i];
      d.first[at] += h01[i], d.first[at + 1] += h12[i], d.second[at] += h02[i];
    }
  }
};

// Makes one unknown of the first two control values, and one of the last two.
void tie(Derivatives& d) {
  const std::size_t last = d.gradient.size() - 1;
  d.gradient[1] += d.gradient[0], d.diagonal[1] += d.diagonal[0] + 2.0 * d.first[0], d.first[1] += d.second[0];
  d.gradient[last - 1] += d.gradient[last], d.diagonal[last - 1] += d.diagonal[last] + 2.0 * d.first[last - 1];
  d.first[last - 2] += d.second[last - 2];
}

FOR_SEVERAL_PROCESSORS
void differentiate(const Program& program, const State& state, double weight, Derivatives& d) {
  const std::size_t count = program.unknowns(), n = program.stride, linear = program.linear, half = program.half;
  d.gradient.assign(count, 0.0), d.diagonal.assign(count, 0.0), d.first.assign(count, 0.0), d.second.assign(count, 0.0);
  d.up.resize(program.columns() * n), d.down.resize(d.up.size()), d.steep.resize(2 * n);
  for (std::size_t i = 0; i < count; ++i) {
    const double left = 1.0 / (program.bound[i] - state.z[i]);
    const double cost = weight * program.weight[i] / (state.z[i] * std::sqrt(state.z[i]));
    d.gradient[i] = -0.5 * cost + left;
    d.diagonal[i] = 0.75 * cost / state.z[i] + left * left;
  }
  reciprocals(state.above.data(), state.below.data(), d.up.data(), d.down.data(), d.up.size());
  for (std::size_t i = 0; i < 2 * n; ++i) d.steep[i] = -0.5 / (state.root[i] * state.root[i] * state.root[i]);
  for (std::size_t begin = 0; begin < n; begin += kLanes) {
    Sums sums;
    const auto at = [&](const Numbers& table, std::size_t j) { return table.data() + j * n + begin; };
    for (std::size_t j = 0; j < linear; ++j) sums.add(at(program.rows, 3 * j), n, at(d.up, j), at(d.down, j));
    for (std::size_t end = 0; end < 2; ++end) {
      for (std::size_t k = end * half; k < (end + 1) * half; ++k) {
        const double *row = at(program.rows, 3 * (linear + k)), *up = at(d.up, linear + k), *down = at(d.down, linear + k);
        sums.add(row, n, up, down);
        sums.add_falling(row, n, up, down, at(program.jerk, k), at(d.steep, end));
      }
      sums.add_speed(at(program.speed, 3 * end), n);
    }
    sums.hand_to(d, begin, std::min(kLanes, program.blocks - begin));
  }
  tie(d);
}

// Solves for the Newton step in the unknowns 1 to count - 2 (L D L^T of five bands), and ties the others. Only
// `first` and `second` are kept, as the bands of L; `step` has room for blocks that are none, too, which stay.
void newton_step(Derivatives& d, Numbers& step) {
  const std::size_t begin = 1, end = d.gradient.size() - 1;
  std::fill(step.begin(), step.end(), 0.0);
  double *first = d.first.data(), *second = d.second.data();
  first[end - 1] = second[end - 1] = second[end - 2] = 0.0;
  // What the rows before have left of this pivot and the next, of the band between them, and of both right sides.
  double pivot = d.diagonal[begin], next = d.diagonal[begin + 1], near = first[begin];
  double right = -d.gradient[begin], after = -d.gradient[begin + 1];
  for (std::size_t i = begin; i < end; ++i) {
    const double inverse = 1.0 / pivot, far = second[i], l1 = near * inverse, l2 = far * inverse;
    const bool more = i + 2 < end;
    pivot = next - l1 * near, next = (more ? d.diagonal[i + 2] : 1.0) - l2 * far;
    near = first[i + 1] - l1 * far;
    step[i] = right * inverse;
    const double then = after - l1 * right;
    after = (more ? -d.gradient[i + 2] : 0.0) - l2 * right, right = then;
    first[i] = l1, second[i] = l2;
  }
  double one = 0.0, two = 0.0;  // the steps after
  for (std::size_t i = end; i-- > begin;) {
    const double found = step[i] - first[i] * one - second[i] * two;
    step[i] = found, two = one, one = found;
  }
  step[0] = step[begin], step[end] = step[end - 1];
}

// How far along a direction all limits, the jerk's by their tangents, hold.
double reach(const Program& program, const State& state, const Derivatives& d, const Numbers& step) {
  const std::size_t n = program.stride, linear = program.linear, half = program.half;
  double used = 0.0;
  for (std::size_t i = 0; i < program.unknowns(); ++i)
    used = std::max({used, step[i] / (program.bound[i] - state.z[i]), -step[i] / state.z[i]});
  Numbers most(n, 0.0), value(n), limit(n, 0.0), slow(2 * n);
  for (std::size_t end = 0; end < 2; ++end) {
    values_of(program.speed.data() + 3 * end * n, step.data(), slow.data() + end * n, n);
    for (std::size_t i = end * n; i < (end + 1) * n; ++i) slow[i] *= d.steep[i];
  }
  for (std::size_t j = 0; j < program.columns(); ++j) {
    values_of(program.rows.data() + 3 * j * n, step.data(), value.data(), n);
    if (j >= linear) {
      const double *jerk = program.jerk.data() + (j - linear) * n, *fall = slow.data() + (j < linear + half ? 0 : n);
      for (std::size_t i = 0; i < n; ++i) limit[i] = fall[i] * jerk[i];
    }
    use_up(value.data(), limit.data(), d.up.data() + j * n, d.down.data() + j * n, most.data(), n);
  }
  for (const double each : most) used = std::max(used, each);
  return used > 0.0 ? 1.0 / used : kInfinity;
}

}  // namespace

void evaluate(const Program& program, State& state) {
  const std::size_t n = program.stride, columns = program.columns(), linear = program.linear, half = program.half;
  state.z.resize(n + 2, 1.0);
  state.above.resize(columns * n), state.below.resize(columns * n), state.root.resize(2 * n);
  state.inside = false, state.duration = 0.0;
  // The distances from the bounds come first, those of the blocks' limits are multiplied to them.
  state.product.assign(n + 2, 1.0), state.power.assign(n + 2, 0);
  for (std::size_t i = 0; i < program.unknowns(); ++i) {
    const double left = state.product[i] = program.bound[i] - state.z[i];
    if (!(left > 0.0 && state.z[i] > 0.0)) return;
    state.duration += program.weight[i] / std::sqrt(state.z[i]);
  }
  for (std::size_t end = 0; end < 2; ++end)
    values_of(program.speed.data() + 3 * end * n, state.z.data(), state.root.data() + end * n, n);
  state.held.assign(n, 1.0), state.value.resize(n), state.limit.resize(n), state.inverse.resize(2 * n);
  roots(state.root.data(), state.inverse.data(), 2 * n);
  for (std::size_t j = 0; j < columns; ++j) {
    values_of(program.rows.data() + 3 * j * n, state.z.data(), state.value.data(), n);
    const double *upper = state.limit.data(), *lower = upper;
    if (j < linear) {
      upper = program.above.data() + j * n, lower = program.below.data() + j * n;
    } else {
      const double *jerk = program.jerk.data() + (j - linear) * n;
      const double* slow = state.inverse.data() + (j < linear + half ? 0 : n);
      for (std::size_t i = 0; i < n; ++i) state.limit[i] = jerk[i] * slow[i];
    }
    distances(state.value.data(), upper, lower, state.above.data() + j * n, state.below.data() + j * n,
              state.product.data(), state.held.data(), n);
    if (j % kFactors == kFactors - 1) take_out_powers(state.product.data(), state.power.data(), n);
  }
  take_out_powers(state.product.data(), state.power.data(), n + 2);
  state.inside = std::all_of(state.held.begin(), state.held.end(), [](double each) { return each > 0.0; });
  state.barrier = sum_of_logarithms(state.product, state.power);
}

bool scale_inside(const Program& program, State& state) {
  const Numbers given = state.z;
  const auto fits = [&](double factor) {
    for (std::size_t i = 0; i < program.unknowns(); ++i) state.z[i] = given[i] * factor;
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

Numbers minimise(const Program& program, Numbers z, double first_gap, double gap, int& steps) {
  State state, trial;
  state.z = std::move(z);
  steps = 0;
  if (!scale_inside(program, state)) return {};
  Derivatives derivatives;
  Numbers gradient, step(program.stride + 2);
  const double rows = double(program.limits());
  for (double open = first_gap;; open = std::max(gap, open * kTighter)) {
    const double weight = rows / (open * state.duration);
    for (int round = 0; round < kSteps; ++round) {
      differentiate(program, state, weight, derivatives);
      gradient = derivatives.gradient;
      newton_step(derivatives, step);
      double decrement = 0.0;
      for (std::size_t i = 1; i + 1 < program.unknowns(); ++i) decrement -= gradient[i] * step[i];
      double part = std::min(1.0, kNear * reach(program, state, derivatives, step));
      const double before = merit(state, weight);
      bool better = false;
      for (int halving = 0; halving < kHalvings && !better; ++halving, part /= 2.0) {
        trial.z = state.z;
        for (std::size_t i = 0; i < program.unknowns(); ++i) trial.z[i] += part * step[i];
        evaluate(program, trial);
        better = merit(trial, weight) <= before - kArmijo * part * decrement;
      }
      ++steps;
      if (!better) break;
      std::swap(state, trial);
      if (decrement < kSettled * rows) break;
    }
    if (open > gap) continue;
    state.z.resize(program.unknowns());
    return state.z;
  }
}

}  // namespace barrier
