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

}  // namespace

void Distances::evaluate(const Variables& variables, const Role& role, distances::DistanceQuery& query, const double* x,
                         Rows& rows) const {
  const std::vector<double> positions = positions_of(samples, variables.joints, x);
  const distances::Near found = query.near(positions.data(), samples.count(), reach);
  for (std::size_t entry = 0; entry < found.count; ++entry) {
    const std::size_t sample = found.sample[entry], pair = found.pair[entry];
    const double* slope = found.jacobian + entry * variables.joints;
    if (role.bounded()) {
      const double lower = of(role.lower, pair), upper = of(role.upper, pair);
      if (!std::isfinite(lower) && !std::isfinite(upper)) continue;
      if (!touched(variables, samples, sample, slope)) continue;
      rows.new_lower.push_back(lower);
      rows.new_upper.push_back(upper);
    } else {
      rows.new_weight.push_back(of(role.weight, pair));
    }
    const double place = samples.place[sample];
    rows.value.push_back(factor[pair] * (found.distance[entry] - margins(pair, place)));
    rows.component.push_back(static_cast<std::int64_t>(pair));
    rows.place.push_back(place);
    for (int k = 0; k < samples.stencil; ++k) {
      const std::size_t at = sample * samples.stencil + k;
      rows.new_knot.push_back(samples.knot[at]);
      for (int joint = 0; joint < variables.joints; ++joint) {
        rows.new_jacobian.push_back(samples.weight[at] * (factor[pair] * slope[joint]));
      }
    }
  }
  rows.settle(samples.stencil);
}

}  // namespace descent
