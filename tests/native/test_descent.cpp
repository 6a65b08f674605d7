// Descents of a point past a disc: distances are known in closed form, so no robot is needed.
#include <Eigen/Geometry>

#include "check.hpp"
#include "descent/loop.hpp"

using namespace descent;
using check::uniform;

namespace {

constexpr int kKnots = 9;

// A point in the plane and a disc around the origin; the one pair.
struct Disc : robot::RobotQuery {
  int positions() const override { return 2; }
  int joints() const override { return 2; }
  int pairs() const override { return 1; }
  robot::Near near(const double* positions, int samples, const std::vector<double>& reach,
                    const std::vector<double>&) override {
    sample.clear(), pair.clear(), distance.clear(), jacobian.clear();
    for (int each = 0; each < samples; ++each) {
      const double x = positions[2 * each], y = positions[2 * each + 1], away = std::hypot(x, y);
      ++work_.distances;
      if (away - 0.4 >= reach[0]) continue;
      sample.push_back(each), pair.push_back(0), distance.push_back(broken ? NAN : away - 0.4);
      jacobian.insert(jacobian.end(), {x / away, y / away});
    }
    return {pair.size(), sample.data(), pair.data(), distance.data(), jacobian.data()};
  }
  void see(const robot::View&, const double* positions, robot::Seen& seen) override {
    seen.point = {positions[0], positions[1], 0.0};
    seen.rotation.setIdentity();
    seen.point_rate.setIdentity(3, 2);
    seen.spin.setZero(3, 2);
  }
  robot::Work work() const override { return work_; }

  bool broken = false;
  robot::Work work_;
  std::vector<std::int64_t> sample, pair;
  std::vector<double> distance, jacobian;
};

// First differences of the knots, and the distance at every knot; a last part is asked for.
Program past(Disc& disc, double margin) {
  Variables variables{2, {}, {}};
  std::vector<double> lower, upper;
  Linear steps{2, {}, {}, {}};
  Samples samples{1, {}, {}, {}};
  for (int knot = 0; knot < kKnots; ++knot) {
    const bool inner = knot > 0 && knot + 1 < kKnots;
    const double along = -1.0 + 2.0 * knot / (kKnots - 1);
    variables.knot_moves.push_back(inner);
    samples.knot.push_back(knot), samples.weight.push_back(1.0), samples.place.push_back(knot);
    for (const double fixed : {along, 0.05}) {
      variables.moves.push_back(inner);
      lower.push_back(inner ? -2.0 : fixed), upper.push_back(inner ? 2.0 : fixed);
    }
    for (int joint = 0; joint < 2 && knot + 1 < kKnots; ++joint) {
      steps.constant.push_back(0.0);
      steps.knot.insert(steps.knot.end(), {knot, knot + 1});
      for (const double factor : {-1.0, 1.0}) {
        for (int other = 0; other < 2; ++other) steps.jacobian.push_back(other == joint ? factor : 0.0);
      }
    }
  }
  Program program(variables, lower, upper, {1.0, 1.0}, disc);
  const std::vector<double> ones(steps.constant.size(), 1.0);
  program.add({{Kind::kSquared, ones, {}, {}}, steps});
  Margins margins{{margin}, {}, {}, {}, {}, {}, {}, {}};
  program.add({{Kind::kBounded, {}, {0.0}, {INFINITY}, 1e-3}, Distances{samples, {margin + 0.3}, {1.0}, margins}});
  program.add({{Kind::kHinge, {}, {}, {}}, Outside{0}});
  return program;
}

// One row, the height of the middle knot above 10: it costs nothing.
Answer height(const double* x) {
  Answer answer;
  Rows rows;
  rows.value = {x[2 * (kKnots / 2) + 1] - 10.0};
  rows.new_jacobian = {0.0, 1.0}, rows.new_knot = {kKnots / 2}, rows.new_weight = {1.0};
  rows.settle(1);
  answer.rows.push_back(std::move(rows));
  answer.configurations = 3;
  return answer;
}

const Region kRegion{1.0, 1e-4, 1.0, 0.1, 0.5, 2.0, 0.3};
Options options(double penalty, int steps) { return {penalty, 1e-4, 1e-6, 0.2, 1e-9, 60, steps, 3, false}; }

std::vector<double> straight() {
  std::vector<double> x;
  for (int knot = 0; knot < kKnots; ++knot) x.insert(x.end(), {-1.0 + 2.0 * knot / (kKnots - 1), 0.05});
  return x;
}

}  // namespace

TEST(a_point_goes_around_a_disc_with_a_merit_that_never_rises) {
  Disc disc;
  Program program = past(disc, 0.1);
  Descent run{program.at(straight(), height), kRegion, 0, {}};
  CHECK(!run.at->feasible);
  std::size_t told = 0;
  const Watch watch{[&](const Entry* entries, std::size_t count) { told += count, CHECK(entries->work.configurations > 0); },
                    1e9, -1};
  CHECK(descend(program, run, options(50.0, 100), height, watch) == Ending::kConverged);
  CHECK(run.at->feasible && told == run.log.size() && told > 2);
  double before = INFINITY;
  for (const Entry& entry : run.log) {
    CHECK(entry.merit <= before + 1e-12);
    CHECK_NEAR(entry.merit, entry.cost + 50.0 * entry.violation, 1e-12);
    before = entry.merit;
  }
  for (int knot = 0; knot < kKnots; ++knot) CHECK(std::hypot(run.at->x[2 * knot], run.at->x[2 * knot + 1]) > 0.499);
  // Nine knots measured and three configurations asked for at every point.
  CHECK(program.work().configurations == static_cast<std::int64_t>(12 * (run.log.size() + 1)));
  CHECK(program.work().distances == disc.work_.distances);
}

TEST(a_watch_is_told_after_the_step_that_uses_up_what_it_allows_and_its_exception_ends_the_descent) {
  Disc disc;
  Program program = past(disc, 0.1);
  Descent run{program.at(straight(), height), kRegion, 0, {}};
  struct Enough {};
  const Watch watch{[](const Entry*, std::size_t) { throw Enough(); }, 1e9, 12 * 3};
  bool ended = false;
  try {
    descend(program, run, options(50.0, 100), height, watch);
  } catch (const Enough&) {
    ended = true;
  }
  CHECK(ended && run.log.size() == 2);  // two steps, after the first point
}

TEST(steps_end_at_their_number_and_what_is_no_number_ends_all) {
  Disc disc;
  Program program = past(disc, 0.1);
  const Watch watch{[](const Entry*, std::size_t) {}, 0.0, -1};
  Descent run{program.at(straight(), height), kRegion, 0, {}};
  CHECK(descend(program, run, options(50.0, 2), height, watch) == Ending::kMaxIterations);
  CHECK(run.log.size() == 2);
  disc.broken = true;
  Descent other{program.at(straight(), height), kRegion, 0, {}};
  CHECK(std::isnan(other.at->violation) && !other.at->feasible);
  CHECK(descend(program, other, options(50.0, 9), height, watch) == Ending::kNonFinite);
}

TEST(a_linear_part_is_what_its_rows_say_anywhere) {
  Disc disc;
  Program program = past(disc, 0.1);
  std::mt19937 rng(4);
  std::vector<double> x(2 * kKnots);
  for (double& each : x) each = uniform(rng, -1.0, 1.0);
  const auto point = program.at(x, height);
  double cost = 0.0;
  for (int knot = 0; knot + 1 < kKnots; ++knot) {
    for (int joint = 0; joint < 2; ++joint) {
      const double step = x[2 * knot + 2 + joint] - x[2 * knot + joint];
      CHECK_NEAR(point->rows[0].value[2 * knot + joint], step, 1e-15);
      cost += step * step;
    }
  }
  CHECK_NEAR(point->cost, cost, 1e-12);
}

// What is seen after a small motion: three numbers move the point, three turn the frame.
robot::Seen moved(const robot::Seen& seen, const Eigen::Matrix<double, 6, 1>& by) {
  robot::Seen after = seen;
  after.point += by.head<3>();
  const Eigen::Vector3d turn = by.tail<3>();
  if (turn.norm() > 0.0) after.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * seen.rotation;
  return after;
}

TEST(rates_of_terms_of_frames_are_those_of_small_motions) {
  std::mt19937 rng(11);
  const auto vector = [&] { return Vector3(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1)); };
  const auto rotation = [&] {
    return Matrix3(Eigen::AngleAxisd(uniform(rng, -3, 3), vector().normalized()).toRotationMatrix());
  };
  for (int trial = 0; trial < 40; ++trial) {
    AxisAngle axis;
    axis.axis = vector().normalized(), axis.direction = vector().normalized(), axis.across = Vector3::UnitX();
    FramePlacement vectors, angles;
    vectors.rotation = rotation(), vectors.translation = vector(), vectors.euler = false;
    angles.rotation = rotation(), angles.translation = vector(), angles.euler = true;
    PointDistance apart;
    apart.from = vector();
    ViewAngle view;
    view.origin = vector(), view.axis = vector().normalized(), view.across = Vector3::UnitX();
    ViewDistance away;
    away.origin = vector();
    PointInRegion region;
    for (const Shape shape : {Shape::kBox, Shape::kSphere, Shape::kCylinder, Shape::kHalfSpace}) {
      region.members.push_back({shape, {0.2, 0.2, 0.3}, rotation(), 2.0 * vector()});
    }
    robot::Seen seen;
    seen.point = vector(), seen.rotation = rotation();
    seen.point_rate.setZero(3, 6), seen.spin.setZero(3, 6);
    seen.point_rate.leftCols<3>().setIdentity(), seen.spin.rightCols<3>().setIdentity();
    for (const FrameTerm* term : std::vector<const FrameTerm*>{&axis, &vectors, &angles, &apart, &view, &away, &region}) {
      Components at, more, less;
      term->evaluate(seen, at);
      for (int k = 0; k < 6; ++k) {
        Eigen::Matrix<double, 6, 1> step = Eigen::Matrix<double, 6, 1>::Zero();
        step[k] = 1e-6;
        more.clear(), less.clear();
        term->evaluate(moved(seen, step), more);
        term->evaluate(moved(seen, -step), less);
        for (auto a = at.begin(), b = more.begin(), c = less.begin(); a != at.end(); ++a, ++b, ++c) {
          CHECK(a->number < term->components() && b->number == a->number);
          const double slope = (b->value - c->value) / 2e-6;
          if (std::abs(slope) < 20.0) CHECK_NEAR(a->rate[k], slope, 1e-5 * (1.0 + slope * slope));
        }
      }
    }
  }
}
