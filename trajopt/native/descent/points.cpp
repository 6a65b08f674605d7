#include "points.hpp"

#include <algorithm>
#include <cmath>

namespace descent {

Program::Program(Variables variables, std::vector<double> lower, std::vector<double> upper, std::vector<double> scale,
                 robot::RobotQuery& query)
    : variables_(std::move(variables)),
      lower_(std::move(lower)),
      upper_(std::move(upper)),
      scale_(std::move(scale)),
      query_(query) {}

robot::Work Program::asked() const {
  robot::Work sum = query_.work();
  for (const Part& part : parts_) {
    if (const auto* timed = std::get_if<DistancesInTime>(&part.rows)) {
      const robot::Work work = timed->among->work();
      sum.bounds += work.bounds;
      sum.distances += work.distances;
    }
  }
  return sum;
}

std::shared_ptr<const Point> Program::at(std::vector<double> x, const Ask& ask) {
  auto point = std::make_shared<Point>();
  point->x = std::move(x);
  const robot::Work before = asked();
  Answer answer;
  if (std::any_of(parts_.begin(), parts_.end(), [](const Part& part) { return std::holds_alternative<Outside>(part.rows); })) {
    answer = ask(point->x.data());
    work_.configurations += answer.configurations;
  }
  for (const Part& part : parts_) {
    Rows rows;
    if (const auto* linear = std::get_if<Linear>(&part.rows)) {
      linear->evaluate(variables_, part.role, point->x.data(), rows);
    } else if (const auto* distances = std::get_if<Distances>(&part.rows)) {
      distances->evaluate(variables_, part.role, query_, point->x.data(), rows);
      work_.configurations += distances->samples.count();
    } else if (const auto* timed = std::get_if<DistancesInTime>(&part.rows)) {
      timed->evaluate(variables_, part.role, point->x.data(), rows);
      work_.configurations += timed->samples.count();
    } else if (const auto* torques = std::get_if<Torques>(&part.rows)) {
      torques->evaluate(variables_, part.role, point->x.data(), rows);
    } else if (const auto* frames = std::get_if<Frames>(&part.rows)) {
      frames->evaluate(variables_, part.role, query_, point->x.data(), rows);
      work_.configurations += frames->configurations;
    } else {
      rows = std::move(answer.rows.at(std::get<Outside>(part.rows).number));
    }
    if (part.role.bounded()) {
      for (int row = 0; row < rows.count(); ++row) {
        const double violation = rows.violation(row);
        point->violation += violation;
        if (!(violation <= part.role.tolerance)) point->feasible = false;
      }
    } else {
      point->cost += rows.cost(part.role.kind);
    }
    point->rows.push_back(std::move(rows));
  }
  point->kept = std::move(answer.kept);
  const robot::Work after = asked();
  work_.bounds += after.bounds - before.bounds;
  work_.distances += after.distances - before.distances;
  return point;
}

// Squared costs, then the bounds, then the costs with a kink: as rows are added, so sums are rounded.
banded::Program Program::quadratic(const Point& point, double penalty) const {
  banded::Program program(variables_.joints, variables_.moves);
  const auto each = [&](auto&& take) {
    for (std::size_t part = 0; part < parts_.size(); ++part) {
      take(parts_[part].role.kind, point.rows[part], point.rows[part].stencils(variables_.joints));
    }
  };
  each([&](Kind kind, const Rows& rows, const banded::Stencils& stencils) {
    if (kind == Kind::kSquared) program.add_squared(stencils, rows.weight);
  });
  each([&](Kind kind, const Rows& rows, const banded::Stencils& stencils) {
    const std::vector<double> penalties(rows.count(), penalty);
    if (kind == Kind::kBounded) program.add_excess(stencils, rows.lower, rows.upper, penalties.data());
  });
  each([&](Kind kind, const Rows& rows, const banded::Stencils& stencils) {
    if (kind != Kind::kAbsolute && kind != Kind::kHinge) return;
    const std::vector<double> zeros(rows.count(), 0.0);
    const std::vector<double> lower(rows.count(), kind == Kind::kAbsolute ? 0.0 : -INFINITY);
    program.add_excess(stencils, lower.data(), zeros.data(), rows.weight);
  });
  return program;
}

}  // namespace descent
