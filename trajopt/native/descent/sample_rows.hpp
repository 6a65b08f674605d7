// Rows at the samples of a curve, chained to its knots.
#pragma once

#include <cmath>

#include "blocks.hpp"

namespace descent {

inline std::vector<double> positions_of(const Samples& samples, int joints, const double* x) {
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
inline bool touched(const Variables& variables, const Samples& samples, std::size_t sample, const double* slope) {
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
inline void add_row(Rows& rows, const Variables& variables, const Samples& samples, std::size_t sample, double value,
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
inline bool take_bounds(Rows& rows, const Role& role, std::size_t number, bool touches) {
  const double lower = of(role.lower, number), upper = of(role.upper, number);
  if (!touches || (!std::isfinite(lower) && !std::isfinite(upper))) return false;
  rows.new_lower.push_back(lower);
  rows.new_upper.push_back(upper);
  return true;
}

}  // namespace descent
