// Rows of motions whose samples have times: distances from a disc that time moves, and torques of a linear system.
#include <memory>

#include "check.hpp"
#include "descent/points.hpp"

using namespace descent;
using check::uniform;

namespace {

// A point in the plane, and a disc that a third joint slides along x; the second pair is never near.
struct SlidingDisc : robot::RobotQuery {
  int positions() const override { return 3; }
  int joints() const override { return 3; }
  int pairs() const override { return 2; }
  robot::Near near(const double* positions, int samples, const std::vector<double>& reach,
                    const std::vector<double>&) override {
    sample.clear(), pair.clear(), distance.clear(), jacobian.clear();
    for (int each = 0; each < samples; ++each) {
      const double x = positions[3 * each] - positions[3 * each + 2], y = positions[3 * each + 1];
      const double away = std::hypot(x, y);
      ++work_.distances;
      if (away - 0.4 >= reach[0]) continue;
      sample.push_back(each), pair.push_back(0), distance.push_back(away - 0.4);
      jacobian.insert(jacobian.end(), {x / away, y / away, -x / away});
    }
    return {pair.size(), sample.data(), pair.data(), distance.data(), jacobian.data()};
  }
  void see(const robot::View&, const double*, robot::Seen&) override {}
  robot::Work work() const override { return work_; }

  robot::Work work_;
  std::vector<std::int64_t> sample, pair;
  std::vector<double> distance, jacobian;
};

// What the program itself is over; it has no part that asks it.
struct Alone : SlidingDisc {
  int positions() const override { return 2; }
};

// Torques that are linear in position, velocity and acceleration.
struct LinearDynamics : robot::RobotDynamics {
  double by[3][4];

  int dofs() const override { return 2; }
  void torques(const double* q, const double* v, const double* a, double* torque) override {
    const double* states[] = {q, v, a};
    for (int joint = 0; joint < 2; ++joint) {
      torque[joint] = 0.0;
      for (int order = 0; order < 3; ++order) {
        for (int other = 0; other < 2; ++other) torque[joint] += by[order][2 * joint + other] * states[order][other];
      }
    }
  }
  void slopes(const double*, const double*, const double*, double* q, double* v, double* a) override {
    double* made[] = {q, v, a};
    for (int order = 0; order < 3; ++order) std::copy_n(by[order], 4, made[order]);
  }
};

constexpr int kKnots = 6;

Variables all_but_the_first() {
  Variables variables{2, {}, {}};
  for (int knot = 0; knot < kKnots; ++knot) {
    variables.knot_moves.push_back(knot > 0);
    variables.moves.insert(variables.moves.end(), 2, knot > 0);
  }
  return variables;
}

Program empty(robot::RobotQuery& query) {
  const std::vector<double> ones(2 * kKnots, 1.0);
  return Program(all_but_the_first(), std::vector<double>(2 * kKnots, -9.0), ones, {1.0, 1.0}, query);
}

Answer none(const double*) { return {}; }

// Every two neighbouring knots, with weights of each.
Samples between(std::mt19937& rng) {
  Samples samples{2, {}, {}, {}};
  for (int knot = 0; knot + 1 < kKnots; ++knot) {
    samples.knot.insert(samples.knot.end(), {knot, knot + 1});
    samples.weight.insert(samples.weight.end(), {uniform(rng, 0.2, 0.8), uniform(rng, 0.2, 0.8)});
    samples.place.push_back(knot + 0.5);
  }
  return samples;
}

// Derivatives of all rows against differences; the rows must not come and go within the step.
void check_slopes(Program& program, const std::vector<double>& x) {
  constexpr double kStep = 1e-6;
  const auto at = program.at(x, none);
  const Rows& rows = at->rows[0];
  for (std::size_t variable = 0; variable < x.size(); ++variable) {
    std::vector<double> more = x, less = x;
    more[variable] += kStep, less[variable] -= kStep;
    const auto after = program.at(more, none), before = program.at(less, none);
    for (int row = 0; row < rows.count(); ++row) {
      double slope = 0.0;
      for (int k = 0; k < rows.stencil; ++k) {
        const std::size_t place = row * rows.stencil + k;
        if (rows.knot[place] == static_cast<std::int64_t>(variable / 2)) slope += rows.jacobian[2 * place + variable % 2];
      }
      CHECK_NEAR((after->rows[0].value[row] - before->rows[0].value[row]) / (2.0 * kStep), slope, 1e-6);
    }
  }
}

}  // namespace

TEST(distances_from_what_time_moves_are_those_at_the_time_of_each_sample) {
  std::mt19937 rng(3);
  Alone alone;
  SlidingDisc among;
  Program program = empty(alone);
  Samples samples = between(rng);
  const std::vector<double> when{0.0, 0.5, 1.0, 1.5, 2.0}, driven{0.0, 0.1, 0.2, 0.3, 0.4};
  // There from 0.5 s to 1.5 s, known to within 1 cm + 2 cm/s t + 4 cm/s^2 t^2 / 2.
  program.add({{Kind::kBounded, {}, {0.0}, {INFINITY}, 1e-3},
               DistancesInTime{samples, when, driven, &among, {9.0, -INFINITY}, {0.05, 0.0}, {0.5, 0.0}, {1.5, 9.0},
                               {0.01, 0.0}, {0.02, 0.0}, {0.04, 0.0}}});
  std::vector<double> x(2 * kKnots);
  for (double& each : x) each = uniform(rng, 0.5, 1.0);
  const auto point = program.at(x, none);
  const Rows& rows = point->rows[0];
  CHECK(rows.count() == 3);
  for (int row = 0; row < rows.count(); ++row) {
    const int sample = row + 1;
    double at[2] = {0.0, 0.0};
    for (int k = 0; k < 2; ++k) {
      for (int joint = 0; joint < 2; ++joint) at[joint] += samples.weight[2 * sample + k] * x[2 * (sample + k) + joint];
    }
    const double time = when[sample], off = 0.01 + 0.02 * time + 0.02 * time * time;
    CHECK_NEAR(rows.value[row], std::hypot(at[0] - driven[sample], at[1]) - 0.4 - off - 0.05, 1e-12);
    CHECK_NEAR(rows.place[row], sample + 0.5, 0.0);
  }
  check_slopes(program, x);
  CHECK(program.work().distances == among.work_.distances);
  CHECK(program.work().configurations == among.work_.distances);
}

TEST(torques_have_rows_where_a_joint_needs_much) {
  std::mt19937 rng(8);
  Alone alone;
  LinearDynamics dynamics;
  for (auto& order : dynamics.by) {
    for (double& each : order) each = uniform(rng, -1.0, 1.0);
  }
  std::vector<double> x(2 * kKnots);
  for (double& each : x) each = uniform(rng, -1.0, 1.0);
  const Samples moments = between(rng);
  std::vector<double> velocity, acceleration;
  for (std::size_t each = 0; each < moments.weight.size(); ++each) {
    velocity.push_back(uniform(rng, -3.0, 3.0));
    acceleration.push_back(uniform(rng, -9.0, 9.0));
  }
  const auto rows_from = [&](double listed, double effort) {
    auto program = std::make_unique<Program>(empty(alone));
    program->add({{Kind::kBounded, {}, {-1.0}, {1.0}, 1e-3},
                  Torques{moments, velocity, acceleration, &dynamics, {2.0, effort}, listed}});
    return program;
  };
  const auto every = rows_from(0.0, 3.0);
  CHECK(every->at(x, none)->rows[0].count() == 2 * (kKnots - 1));
  check_slopes(*every, x);
  // A joint without a limit has none, and one that needs little has none there.
  const auto limited = rows_from(0.0, INFINITY)->at(x, none);
  CHECK(limited->rows[0].count() == kKnots - 1);
  for (std::int64_t joint : limited->rows[0].component) CHECK(joint == 0);
  const auto all = every->at(x, none), some = rows_from(1.0, 3.0)->at(x, none);
  int much = 0;
  for (double share : all->rows[0].value) much += std::abs(share) >= 1.0;
  CHECK(some->rows[0].count() == much && much > 0 && much < 2 * (kKnots - 1));
}
