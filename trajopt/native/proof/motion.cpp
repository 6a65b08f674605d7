#include "motion.hpp"

#include <cmath>

namespace proof {

namespace {

// Bounds of the group's joints carried over to the arm's; the world comes first.
std::vector<double> carried(const Eigen::MatrixXd& expand, const Eigen::VectorXd& group) {
  std::vector<double> result(size_t(expand.rows()) + 1, 0.0);
  Eigen::Map<Eigen::VectorXd>(result.data() + 1, expand.rows()) = expand.cwiseAbs() * group;
  return result;
}

Eigen::VectorXd largest_size(const Curve& curve, double begin, double end) {
  Eigen::VectorXd low(curve.functions), high(curve.functions);
  curve.range(begin, end, low.data(), high.data());
  return high.cwiseMax(-low);
}

}  // namespace

std::vector<double> Motion::joints(double time) const {
  Eigen::VectorXd group(position.functions);
  position.evaluate(time, group.data());
  std::vector<double> result(size_t(expand.rows()));
  Eigen::Map<Eigen::VectorXd>(result.data(), expand.rows()) = expand * group + offset;
  return result;
}

JointBounds Motion::bounds(double begin, double end) const {
  Eigen::VectorXd low(position.functions), high(position.functions), middle(position.functions);
  position.range(begin, end, low.data(), high.data());
  position.evaluate((begin + end) / 2.0, middle.data());
  return {carried(expand, (high - middle).cwiseMax(middle - low)), carried(expand, largest_size(velocity, begin, end)),
          carried(expand, largest_size(acceleration, begin, end))};
}

}  // namespace proof
