#include "blocks.hpp"

#include <cmath>

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

namespace {

std::vector<double> positions_of(const Samples& samples, int joints, const double* x) {
  std::vector<double> positions(static_cast<std::size_t>(samples.count()) * joints, 0.0);
  for (int sample = 0; sample < samples.count(); ++sample) {
    double* at = positions.data() + static_cast<std::size_t>(sample) * joints;
    for (int k = 0; k < samples.stencil; ++k) {
      const std::size_t place = static_cast<std::size_t>(sample) * samples.stencil + k;
      const double* knot = x + samples.knot[place] * joints;
      for (int joint = 0; joint < joints; ++joint) at[joint] += samples.weight[place] * knot[joint];
    }
  }
  return positions;
}

// Whether any variable that moves changes a value with these derivatives by a sample's configuration.
bool touched(const Variables& variables, const Samples& samples, std::size_t sample, const double* slope) {
  const double* end = slope + variables.joints;
  for (int k = 0; k < samples.stencil; ++k) {
    const std::size_t place = sample * samples.stencil + k;
    if (!variables.knot_moves[samples.knot[place]]) continue;
    for (const double* each = slope; each != end; ++each) {
      if (samples.weight[place] * *each != 0.0) return true;
    }
  }
  return false;
}

// Add a row: chained to the knots of its sample.
void add_row(Rows& rows, const Variables& variables, const Samples& samples, std::size_t sample, double value,
             const double* slope, double factor, std::size_t component) {
  rows.value.push_back(value);
  rows.component.push_back(static_cast<std::int64_t>(component));
  rows.place.push_back(samples.place[sample]);
  for (int k = 0; k < samples.stencil; ++k) {
    const std::size_t at = sample * samples.stencil + k;
    rows.new_knot.push_back(samples.knot[at]);
    for (int joint = 0; joint < variables.joints; ++joint) {
      rows.new_jacobian.push_back(samples.weight[at] * (factor * slope[joint]));
    }
  }
}

// Take the bounds of a row; false if it has none, or no variable changes it.
bool take_bounds(Rows& rows, const Role& role, std::size_t number, bool touches) {
  const double lower = of(role.lower, number), upper = of(role.upper, number);
  if (!touches || (!std::isfinite(lower) && !std::isfinite(upper))) return false;
  rows.new_lower.push_back(lower);
  rows.new_upper.push_back(upper);
  return true;
}

}  // namespace

void Distances::evaluate(const Variables& variables, const Role& role, robot::RobotQuery& query, const double* x,
                         Rows& rows) const {
  const std::vector<double> positions = positions_of(samples, variables.joints, x);
  const robot::Near found = query.near(positions.data(), samples.count(), reach);
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
