#include "blocks.hpp"

#include "sample_rows.hpp"

namespace descent {

void Linear::evaluate(const Variables& variables, const Role& role, const double* x, Rows& rows) const {
  const int joints = variables.joints;
  rows.stencil = stencil;
  rows.jacobian = jacobian.data();
  rows.knot = knot.data();
  rows.weight = role.weight.data();
  rows.lower = role.lower.data();
  rows.upper = role.upper.data();
  rows.value = constant;
  const double* slope = jacobian.data();
  for (std::size_t row = 0; row < constant.size(); ++row) {
    double sum = 0.0;
    for (int k = 0; k < stencil; ++k, slope += joints) {
      const double* at = x + knot[row * stencil + k] * joints;
      for (int joint = 0; joint < joints; ++joint) sum += slope[joint] * at[joint];
    }
    rows.value[row] += sum;
  }
}

void Distances::evaluate(const Variables& variables, const Role& role, robot::RobotQuery& query, const double* x,
                         Rows& rows) const {
  const std::vector<double> positions = positions_of(samples, variables.joints, x);
  const robot::Near found = query.near(positions.data(), samples.count(), reach, margins.full);
  for (std::size_t entry = 0; entry < found.count; ++entry) {
    const std::size_t sample = found.sample[entry], pair = found.pair[entry];
    const double* slope = found.jacobian + entry * variables.joints;
    if (!role.bounded()) {
      rows.new_weight.push_back(of(role.weight, pair));
    } else if (!take_bounds(rows, role, pair, touched(variables, samples, sample, slope))) {
      continue;
    }
    const double value = factor[pair] * (found.distance[entry] - margins(pair, samples.place[sample]));
    add_row(rows, variables, samples, sample, value, slope, factor[pair], pair);
  }
  rows.settle(samples.stencil);
}

void Frames::evaluate(const Variables& variables, const Role& role, robot::RobotQuery& query, const double* x,
                      Rows& rows) const {
  const std::vector<double> positions = positions_of(samples, variables.joints, x);
  robot::Seen seen;
  Components found;
  for (int sample = 0; sample < samples.count(); ++sample) {
    query.see(view, positions.data() + static_cast<std::size_t>(sample) * variables.joints, seen);
    found.clear();
    term->evaluate(seen, found);
    for (const auto& [component, value, rate] : found) {
      const std::size_t number = static_cast<std::size_t>(sample) * term->components() + component;
      if (!role.bounded()) {
        rows.new_weight.push_back(of(role.weight, number));
      } else if (!take_bounds(rows, role, number, touched(variables, samples, sample, rate.data()))) {
        continue;
      }
      add_row(rows, variables, samples, sample, value, rate.data(), 1.0, component);
    }
  }
  rows.settle(samples.stencil);
}

}  // namespace descent
