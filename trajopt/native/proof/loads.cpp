#include "loads.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proof {

namespace {

// Values of all functions in a piece, since its begin.
void evaluate(const Curve& curve, int piece, double since, double* values) {
  for (int f = 0; f < curve.functions; ++f) {
    double value = curve.coefficient(0, piece, f);
    for (int row = 1; row <= curve.degree; ++row) value = value * since + curve.coefficient(row, piece, f);
    values[f] = value;
  }
}

// Whether the acceleration of any joint jumps where a piece begins.
std::vector<char> jumps(const Curve& acceleration, double rounding) {
  const int pieces = acceleration.pieces(), functions = acceleration.functions;
  std::vector<char> found(size_t(pieces), 1);
  std::vector<double> off(size_t(pieces), 0.0), reached(size_t(functions), 0.0);
  double largest = 0.0;
  for (int piece = 0; piece < pieces; ++piece) {
    for (int f = 0; f < functions; ++f) {
      const double begin = acceleration.coefficient(acceleration.degree, piece, f);
      largest = std::max(largest, std::abs(begin));
      off[piece] = std::max(off[piece], std::abs(begin - reached[f]));
    }
    evaluate(acceleration, piece, acceleration.times[piece + 1] - acceleration.times[piece], reached.data());
  }
  for (int piece = 1; piece < pieces; ++piece) found[piece] = !(off[piece] <= rounding * largest);
  return found;
}

}  // namespace

double largest_share(const Dynamics& dynamics, const Curve& position, const Samples& samples,
                     const Eigen::MatrixXd& expand, const Eigen::VectorXd& offset, const double* effort) {
  const Curve velocity = position.derivative(), acceleration = velocity.derivative();
  const std::vector<char> begins = jumps(acceleration, samples.rounding);
  const size_t joints = dynamics.joints();
  const Eigen::Index group = position.functions;
  std::vector<double> q, v, a;
  Eigen::VectorXd at(group), moved(expand.rows());
  auto add = [&](std::vector<double>& rows, bool places) {
    moved.noalias() = expand * at;
    if (places) moved += offset;
    rows.insert(rows.end(), moved.data(), moved.data() + moved.size());
  };
  for (int piece = 0; piece < position.pieces(); ++piece) {
    const double length = position.times[piece + 1] - position.times[piece];
    for (int64_t number = begins[piece] ? 0 : 1; number <= samples.steps[piece]; ++number) {
      const double since = length * double(number) / double(samples.steps[piece]);
      evaluate(position, piece, since, at.data()), add(q, true);
      evaluate(velocity, piece, since, at.data()), add(v, false);
      evaluate(acceleration, piece, since, at.data()), add(a, false);
    }
  }
  for (size_t row = 0; row < samples.rest_count; ++row) {
    at = Eigen::Map<const Eigen::VectorXd>(samples.rests + row * size_t(group), group);
    add(q, true);
    v.resize(q.size(), 0.0), a.resize(q.size(), 0.0);
  }
  std::vector<double> torque(q.size());
  const size_t rows = q.size() / joints;
  dynamics.torques(rows, q.data(), v.data(), a.data(), torque.data());
  double worst = 0.0;
  for (size_t row = 0; row < rows; ++row) {
    at.noalias() = expand.transpose() * Eigen::Map<const Eigen::VectorXd>(torque.data() + row * joints, Eigen::Index(joints));
    for (Eigen::Index f = 0; f < group; ++f) {
      if (std::isinf(effort[f])) continue;
      const double share = std::abs(at[f]) / effort[f];
      if (!(share <= worst)) worst = std::isnan(share) ? std::numeric_limits<double>::infinity() : share;
    }
  }
  return worst;
}

}  // namespace proof
