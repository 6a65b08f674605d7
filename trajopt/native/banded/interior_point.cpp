#include "interior_point.hpp"

#include <algorithm>
#include <cmath>

namespace banded {

namespace {

constexpr double kBackOff = 0.995;  // of the longest step that keeps all slacks positive

// Plain sums: vectors of variables or rows have no padding that could be trusted.
double inner(const std::vector<double>& a, const std::vector<double>& b, int length) {
  double sum = 0.0;
  for (int k = 0; k < length; ++k) sum += a[k] * b[k];
  return sum;
}

FOR_SEVERAL_PROCESSORS
double steepest_of(const std::vector<double>& value, const std::vector<double>& change, double sign, int length,
                   double floor) {
  return steepest(value.data(), change.data(), sign, length, floor);
}

// y += sum of factor_i row_i.
FOR_SEVERAL_PROCESSORS
void add_rows(const Runs& rows, const double* factor, double* y) {
  for (int row = 0; row < rows.count(); ++row) {
    add_scaled(factor[row], rows.run(row), y + rows.first[row], rows.length[row]);
  }
}

// y_i = row_i x.
FOR_SEVERAL_PROCESSORS
void multiply_rows(const Runs& rows, const double* x, double* y) {
  for (int row = 0; row < rows.count(); ++row) y[row] = dot(rows.run(row), x + rows.first[row], rows.length[row]);
}

}  // namespace

InteriorPoint::InteriorPoint(const Program& program, const double* lower, const double* upper, const Options& options)
    : program_(program),
      lower_(lower),
      upper_(upper),
      options_(options),
      size_(program.size()),
      rows_(program.rows.count()) {
  for (auto* vector : {&x_, &to_lower_, &to_upper_, &z_lower_, &z_upper_, &stationarity_, &product_, &dx_, &dz_lower_,
                       &dz_upper_, &targets_.lower, &targets_.upper}) {
    vector->assign(program.hessian.room(), 0.0);
  }
  for (auto* vector : {&excess_, &s_, &t_, &lambda_, &nu_, &weight_, &ds_, &dt_, &dlambda_, &targets_.below,
                       &targets_.above}) {
    vector->assign(rows_, 0.0);
  }
}

Solution InteriorPoint::solve() {
  Solution solution;
  start();
  residuals();
  for (; solution.iterations < options_.max_iterations; ++solution.iterations) {
    if (error_bound() <= options_.accuracy) {
      solution.outcome = Outcome::kSolved;
      break;
    }
    factorise();
    const double now = gap();
    const int products = 2 * (size_ + rows_);
    aim(0.0, false);
    direction();
    const double predicted = gap_after(longest_step());
    const double ratio = predicted / now;
    aim(ratio * ratio * ratio * now / products, true);
    direction();
    take(std::min(1.0, kBackOff * longest_step()));
    residuals();
    if (!std::isfinite(gap())) break;
  }
  if (solution.iterations == options_.max_iterations) solution.outcome = Outcome::kInaccurate;
  solution.x = x_;
  solution.multiplier = lambda_;
  return solution;
}

// Well inside all bounds; slacks so that both products of a row are equal.
void InteriorPoint::start() {
  double sum = 0.0;
  for (int j = 0; j < size_; ++j) {
    const double inside = options_.start * (upper_[j] - lower_[j]);
    x_[j] = std::clamp(0.0, lower_[j] + inside, upper_[j] - inside);
    to_lower_[j] = x_[j] - lower_[j];
    to_upper_[j] = upper_[j] - x_[j];
  }
  multiply_rows(program_.rows, x_.data(), excess_.data());
  for (int row = 0; row < rows_; ++row) {
    const double excess = excess_[row] - program_.bound[row];
    t_[row] = std::max(excess, 0.0) + options_.start;
    s_[row] = std::max(-excess, 0.0) + options_.start;
    const double share = t_[row] / (t_[row] + s_[row]);
    lambda_[row] = program_.penalty[row] * share;
    nu_[row] = program_.penalty[row] - lambda_[row];
    sum += lambda_[row] * s_[row];
  }
  const double centre = rows_ > 0 ? sum / rows_ : options_.start;
  for (int j = 0; j < size_; ++j) {
    z_lower_[j] = centre / to_lower_[j];
    z_upper_[j] = centre / to_upper_[j];
  }
}

void InteriorPoint::residuals() {
  program_.hessian.multiply(x_.data(), product_.data());
  for (int j = 0; j < size_; ++j) {
    stationarity_[j] = product_[j] + program_.gradient[j] - z_lower_[j] + z_upper_[j];
  }
  add_rows(program_.rows, lambda_.data(), stationarity_.data());
  multiply_rows(program_.rows, x_.data(), excess_.data());
  for (int row = 0; row < rows_; ++row) excess_[row] -= program_.bound[row];
}

double InteriorPoint::gap() const {
  return inner(z_lower_, to_lower_, size_) + inner(z_upper_, to_upper_, size_) + inner(lambda_, s_, rows_) +
         inner(nu_, t_, rows_);
}

// By how much the objective exceeds its least value, at most: the duality gap, and what is left of the gradient
// times the way that any variable could still go.
double InteriorPoint::error_bound() const {
  double bound = gap();
  for (int j = 0; j < size_; ++j) bound += std::abs(stationarity_[j]) * (upper_[j] - lower_[j]);
  return bound;
}

void InteriorPoint::factorise() {
  system_ = program_.hessian;
  for (int j = 0; j < size_; ++j) {
    system_.column(j)[0] += z_lower_[j] / to_lower_[j] + z_upper_[j] / to_upper_[j];
  }
  for (int row = 0; row < rows_; ++row) weight_[row] = 1.0 / (s_[row] / lambda_[row] + t_[row] / nu_[row]);
  system_.add_outers(program_.rows, weight_.data());
  system_.factorise();
}

void InteriorPoint::aim(double target, bool corrected) {
  for (int j = 0; j < size_; ++j) {
    targets_.lower[j] = target - (corrected ? dz_lower_[j] * dx_[j] : 0.0);
    targets_.upper[j] = target + (corrected ? dz_upper_[j] * dx_[j] : 0.0);
  }
  for (int row = 0; row < rows_; ++row) {
    targets_.below[row] = target - (corrected ? dlambda_[row] * ds_[row] : 0.0);
    targets_.above[row] = target + (corrected ? dlambda_[row] * dt_[row] : 0.0);
  }
}

void InteriorPoint::direction() {
  std::vector<double>& scaled = dlambda_;  // w (excess + below / lambda - above / nu), before row dx is known
  for (int row = 0; row < rows_; ++row) {
    const double shift = targets_.below[row] / lambda_[row] - targets_.above[row] / nu_[row];
    scaled[row] = -weight_[row] * (excess_[row] + shift);
  }
  for (int j = 0; j < size_; ++j) {
    dx_[j] = -stationarity_[j] + targets_.lower[j] / to_lower_[j] - z_lower_[j] - targets_.upper[j] / to_upper_[j] +
             z_upper_[j];
  }
  add_rows(program_.rows, scaled.data(), dx_.data());
  system_.solve(dx_.data());
  multiply_rows(program_.rows, dx_.data(), ds_.data());
  for (int row = 0; row < rows_; ++row) {
    const double change = weight_[row] * ds_[row] - scaled[row];
    dlambda_[row] = change;
    ds_[row] = (targets_.below[row] - s_[row] * change) / lambda_[row] - s_[row];
    dt_[row] = (targets_.above[row] + t_[row] * change) / nu_[row] - t_[row];
  }
  for (int j = 0; j < size_; ++j) {
    dz_lower_[j] = (targets_.lower[j] - z_lower_[j] * dx_[j]) / to_lower_[j] - z_lower_[j];
    dz_upper_[j] = (targets_.upper[j] + z_upper_[j] * dx_[j]) / to_upper_[j] - z_upper_[j];
  }
}

double InteriorPoint::longest_step() const {
  double slope = kBackOff;  // of what vanishes first
  slope = steepest_of(to_lower_, dx_, 1.0, size_, slope);
  slope = steepest_of(to_upper_, dx_, -1.0, size_, slope);
  slope = steepest_of(z_lower_, dz_lower_, 1.0, size_, slope);
  slope = steepest_of(z_upper_, dz_upper_, 1.0, size_, slope);
  slope = steepest_of(s_, ds_, 1.0, rows_, slope);
  slope = steepest_of(t_, dt_, 1.0, rows_, slope);
  slope = steepest_of(lambda_, dlambda_, 1.0, rows_, slope);
  return 1.0 / steepest_of(nu_, dlambda_, -1.0, rows_, slope);
}

double InteriorPoint::gap_after(double step) const {
  double sum = 0.0;
  for (int j = 0; j < size_; ++j) {
    sum += (z_lower_[j] + step * dz_lower_[j]) * (to_lower_[j] + step * dx_[j]);
    sum += (z_upper_[j] + step * dz_upper_[j]) * (to_upper_[j] - step * dx_[j]);
  }
  for (int row = 0; row < rows_; ++row) {
    sum += (lambda_[row] + step * dlambda_[row]) * (s_[row] + step * ds_[row]);
    sum += (nu_[row] - step * dlambda_[row]) * (t_[row] + step * dt_[row]);
  }
  return sum;
}

void InteriorPoint::take(double step) {
  for (int j = 0; j < size_; ++j) {
    x_[j] += step * dx_[j];
    to_lower_[j] += step * dx_[j];
    to_upper_[j] -= step * dx_[j];
    z_lower_[j] += step * dz_lower_[j];
    z_upper_[j] += step * dz_upper_[j];
  }
  for (int row = 0; row < rows_; ++row) {
    s_[row] += step * ds_[row];
    t_[row] += step * dt_[row];
    lambda_[row] += step * dlambda_[row];
    nu_[row] -= step * dlambda_[row];
  }
}

}  // namespace banded
