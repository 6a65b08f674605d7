#include "step.hpp"

namespace banded {

Step best_step(Program& program, const double* lower, const double* upper, double regularisation,
               const Options& options) {
  program.assemble(regularisation);
  const std::vector<int>& lanes = program.lanes();
  Eights low(program.variable_groups()), high(program.variable_groups());
  for (std::size_t variable = 0; variable < lanes.size(); ++variable) {
    if (lanes[variable] < 0) continue;
    numbers(low)[lanes[variable]] = lower[variable];
    numbers(high)[lanes[variable]] = upper[variable];
  }
  const Solution solution = best(program, low, high, options);
  Step step{solution.outcome, solution.iterations, std::vector<double>(lanes.size(), 0.0), solution.reduction};
  for (std::size_t variable = 0; variable < lanes.size(); ++variable) {
    if (lanes[variable] >= 0) step.change[variable] = numbers(solution.x)[lanes[variable]];
  }
  return step;
}

}  // namespace banded
