#include "step.hpp"

namespace banded {

Step best_step(Program& program, const double* lower, const double* upper, double regularisation,
               const Options& options) {
  const std::vector<int>& columns = program.columns();
  std::vector<double> low(program.size()), high(program.size()), change(columns.size(), 0.0);
  for (std::size_t variable = 0; variable < columns.size(); ++variable) {
    if (columns[variable] < 0) continue;
    low[columns[variable]] = lower[variable];
    high[columns[variable]] = upper[variable];
  }
  program.assemble(regularisation);
  Solution solution = InteriorPoint(program, low.data(), high.data(), options).solve();
  const std::vector<double> still(program.hessian.room(), 0.0);
  const double reduction = program.objective(still.data()) - program.objective(solution.x.data());
  for (std::size_t variable = 0; variable < columns.size(); ++variable) {
    if (columns[variable] >= 0) change[variable] = solution.x[columns[variable]];
  }
  return {solution.outcome, solution.iterations, std::move(change), reduction, std::move(solution.multiplier)};
}

}  // namespace banded
