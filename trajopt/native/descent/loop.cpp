#include "loop.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "../banded/step.hpp"

namespace descent {

void Region::resize(double ratio) {
  if (!accepts(ratio)) {
    radius *= shrink;
  } else if (ratio >= good) {
    radius = std::min(radius * grow, largest);
  }
}

namespace {

// Tells the watch of what is new, not after every step.
class Reporter {
 public:
  Reporter(const Watch& watch, const std::vector<Entry>& log) : watch_(watch), log_(log) {}

  void noted() {
    const auto now = std::chrono::steady_clock::now();
    const bool used_up = watch_.configurations >= 0 && log_.back().work.configurations >= watch_.configurations;
    if (used_up || std::chrono::duration<double>(now - since_).count() >= watch_.seconds) rest();
  }

  void rest() {
    if (told_ == log_.size()) return;
    const std::size_t first = told_;
    told_ = log_.size();
    watch_.tell(log_.data() + first, told_ - first);
    since_ = std::chrono::steady_clock::now();
  }

 private:
  const Watch& watch_;
  const std::vector<Entry>& log_;
  std::size_t told_ = 0;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
};

// The best step within the region and the bounds.
banded::Step step_within(const Program& program, banded::Program& quadratic, const Point& at, double radius,
                         double accuracy, const Options& options) {
  const std::size_t variables = at.x.size(), joints = program.scale().size();
  std::vector<double> lower(variables), upper(variables);
  for (std::size_t variable = 0; variable < variables; ++variable) {
    const double box = radius * program.scale()[variable % joints];
    lower[variable] = std::max(-box, program.lower()[variable] - at.x[variable]);
    upper[variable] = std::min(box, program.upper()[variable] - at.x[variable]);
  }
  banded::Options inner;
  inner.accuracy = accuracy;
  inner.max_iterations = options.qp_iterations;
  return banded::best_step(quadratic, lower.data(), upper.data(), options.regularisation, inner);
}

// Whether the violation would not fall to the loosest tolerance in time, if it fell at the rate of the last steps.
bool hopeless(const Program& program, const std::vector<double>& violations, const Options& options, int left) {
  const auto window = static_cast<std::size_t>(options.window);
  if (window == 0 || violations.size() <= window) return false;
  double tolerance = 0.0;
  for (const Part& part : program.parts())
    if (part.role.bounded()) tolerance = std::max(tolerance, part.role.tolerance);
  const double now = violations.back(), before = violations[violations.size() - 1 - window];
  return now > tolerance && now * std::pow(now / before, static_cast<double>(left) / options.window) > tolerance;
}

Ending walk(Program& program, Descent& descent, const Options& options, const Program::Ask& ask,
            Reporter& reporter) {
  banded::Program quadratic = program.quadratic(*descent.at, options.penalty);
  std::vector<double> violations = options.violations;
  while (static_cast<int>(descent.log.size()) < options.steps) {
    const Point& at = *descent.at;
    const double now = at.merit(options.penalty);
    if (!std::isfinite(now)) return Ending::kNonFinite;
    const double enough = std::max(options.relative_gain * now, options.absolute_gain);
    const banded::Step step =
        step_within(program, quadratic, at, descent.region.radius, options.accuracy * enough, options);
    if (step.outcome == banded::Outcome::kFailed) {
      if (++descent.failures > options.failures) return Ending::kQpFailed;
      descent.region.radius *= descent.region.shrink;
      continue;
    }
    if (step.reduction < enough) return Ending::kConverged;
    std::vector<double> moved = at.x;
    for (std::size_t variable = 0; variable < moved.size(); ++variable) moved[variable] += step.change[variable];
    const std::shared_ptr<const Point> trial = program.at(std::move(moved), ask);
    const double ratio = (now - trial->merit(options.penalty)) / step.reduction;
    const bool accepted = descent.region.accepts(ratio);
    descent.region.resize(ratio);
    if (accepted) descent.at = trial;
    descent.log.push_back({descent.at->cost, descent.at->violation, descent.at->merit(options.penalty),
                           descent.region.radius, accepted, quadratic.row_count(), step.iterations,
                           program.work()});
    violations.push_back(descent.at->violation);
    reporter.noted();
    if (accepted && descent.at->feasible && options.until_feasible) return Ending::kConverged;
    const int left = options.steps - static_cast<int>(descent.log.size());
    if (!descent.at->feasible && hopeless(program, violations, options, left)) return Ending::kGivenUp;
    if (descent.region.collapsed()) return Ending::kTrustRegionCollapsed;
    if (accepted) quadratic = program.quadratic(*descent.at, options.penalty);
  }
  return Ending::kMaxIterations;
}

}  // namespace

Ending descend(Program& program, Descent& descent, const Options& options, const Program::Ask& ask,
              const Watch& watch) {
  Reporter reporter(watch, descent.log);
  const Ending ending = walk(program, descent, options, ask, reporter);
  reporter.rest();
  return ending;
}

}  // namespace descent
