#include "timed_blocks.hpp"

#include <algorithm>

#include "sample_rows.hpp"

namespace descent {

void DistancesInTime::evaluate(const Variables& variables, const Role& role, const double* x, Rows& rows) const {
  const std::size_t joints = variables.joints, count = samples.count(), all = among->positions(), timed = all - joints;
  const std::vector<double> group = positions_of(samples, variables.joints, x);
  std::vector<double> positions(count * all);
  for (std::size_t sample = 0; sample < count; ++sample) {
    double* at = positions.data() + sample * all;
    std::copy_n(group.data() + sample * joints, joints, at);
    std::copy_n(driven.data() + sample * timed, timed, at + joints);
  }
  const robot::Near found = among->near(positions.data(), samples.count(), reach, reach);
  for (std::size_t entry = 0; entry < found.count; ++entry) {
    const std::size_t sample = found.sample[entry], pair = found.pair[entry];
    const double time = when[sample], *slope = found.jacobian + entry * all;
    if (time < appears[pair] || time > expires[pair]) continue;
    if (!take_bounds(rows, role, pair, touched(variables, samples, sample, slope))) continue;
    const double off = error[pair] + error_velocity[pair] * time + error_acceleration[pair] * time * time / 2.0;
    add_row(rows, variables, samples, sample, found.distance[entry] - off - margin[pair], slope, 1.0, pair);
  }
  rows.settle(samples.stencil);
}

namespace {

// A weighted sum of the knots of a sample.
void sum_of(const Samples& samples, const std::vector<double>& weight, int sample, int joints, const double* x,
            std::vector<double>& sum) {
  std::fill(sum.begin(), sum.end(), 0.0);
  for (int k = 0; k < samples.stencil; ++k) {
    const std::size_t place = static_cast<std::size_t>(sample) * samples.stencil + k;
    const double* knot = x + samples.knot[place] * joints;
    for (int joint = 0; joint < joints; ++joint) sum[joint] += weight[place] * knot[joint];
  }
}

}  // namespace

void Torques::evaluate(const Variables& variables, const Role& role, const double* x, Rows& rows) const {
  const int joints = variables.joints, stencil = moments.stencil;
  std::vector<double> q(joints), v(joints), a(joints), torque(joints);
  std::vector<double> by_q(joints * joints), by_v(by_q), by_a(by_q), slope(stencil * joints);
  for (int moment = 0; moment < moments.count(); ++moment) {
    sum_of(moments, moments.weight, moment, joints, x, q);
    sum_of(moments, velocity, moment, joints, x, v);
    sum_of(moments, acceleration, moment, joints, x, a);
    dynamics->torques(q.data(), v.data(), a.data(), torque.data());
    bool differentiated = false;
    for (int joint = 0; joint < joints; ++joint) {
      const double share = torque[joint] / effort[joint];
      if (!(std::abs(share) >= listed)) continue;
      if (!differentiated) dynamics->slopes(q.data(), v.data(), a.data(), by_q.data(), by_v.data(), by_a.data());
      differentiated = true;
      bool touches = false;
      for (int k = 0; k < stencil; ++k) {
        const std::size_t place = static_cast<std::size_t>(moment) * stencil + k;
        for (int by = 0; by < joints; ++by) {
          const int at = joint * joints + by;
          const double sum = moments.weight[place] * by_q[at] + velocity[place] * by_v[at] + acceleration[place] * by_a[at];
          slope[k * joints + by] = sum / effort[joint];
          touches = touches || (slope[k * joints + by] != 0.0 && variables.knot_moves[moments.knot[place]]);
        }
      }
      if (!take_bounds(rows, role, joint, touches)) continue;
      rows.value.push_back(share);
      rows.component.push_back(joint);
      rows.place.push_back(moments.place[moment]);
      rows.new_jacobian.insert(rows.new_jacobian.end(), slope.begin(), slope.end());
      const auto knots = moments.knot.begin() + static_cast<std::ptrdiff_t>(moment) * stencil;
      rows.new_knot.insert(rows.new_knot.end(), knots, knots + stencil);
    }
  }
  rows.settle(stencil);
}

}  // namespace descent
