// The passes against the trapezoid of one joint, extremes against dense samples, the barrier against its limits, splines
// against de Boor's triangle, and whole timings against their limits.
#include "check.hpp"
#include "timing/timer.hpp"

using check::uniform, check::whole;

TEST(a_joint_with_an_acceleration_limit_speeds_up_and_slows_down) {
  const std::size_t points = 41;
  const std::vector<double> distance(points, 1.0 / points), a(points, 1.0), zero(points, 0.0), limit(points, 2.0);
  const std::vector<double> bound(points + 1, 1e3);
  const auto y = passes::fastest({distance.data(), a.data(), zero.data(), zero.data(), limit.data(), bound.data(),
                                  points, 1});
  CHECK(y.front() == 0.0 && y.back() == 0.0);
  for (std::size_t i = 0; i <= points; ++i) {
    const double s = double(i) / points;
    CHECK_NEAR(y[i], 2.0 * 2.0 * std::min(s, 1.0 - s), 1e-9);
  }
}

TEST(profiles_keep_every_half_plane_whatever_the_limits) {
  std::mt19937 rng(3);
  for (int trial = 0; trial < 200; ++trial) {
    const std::size_t points = std::size_t(whole(rng, 2, 40)), columns = std::size_t(whole(rng, 0, 8));
    std::vector<double> distance(points), a(points * columns), b(a), c(a), limit(a), bound(points + 1);
    for (double& each : distance) each = std::pow(10.0, uniform(rng, -3.0, -1.0));
    for (std::size_t i = 0; i < a.size(); ++i) {
      a[i] = uniform(rng, 0.0, 1.0) < 0.2 ? 1e-17 * uniform(rng, -1.0, 1.0) : uniform(rng, -1.0, 1.0);
      b[i] = uniform(rng, -1.0, 1.0), c[i] = uniform(rng, -0.5, 0.5), limit[i] = uniform(rng, 0.6, 2.0);
    }
    for (double& each : bound) each = uniform(rng, 0.0, 1.0) < 0.1 ? 0.0 : uniform(rng, 0.0, 3.0);
    const passes::Course course{distance.data(), a.data(),     b.data(), c.data(),
                                limit.data(),    bound.data(), points,   columns};
    const auto y = passes::fastest(course);
    for (std::size_t i = 0; i < points; ++i) {
      CHECK(y[i] >= 0.0 && y[i] <= bound[i]);
      passes::half_planes(course, i, [&](double next, double previous, double room) {
        const double size = std::abs(next) * y[i + 1] + std::abs(previous) * y[i];
        CHECK(next * y[i + 1] + previous * y[i] <= room + 1e-7 * size + 1e-12);
      });
    }
  }
}

TEST(extremes_of_quintics_are_those_of_dense_samples) {
  std::mt19937 rng(4);
  for (int trial = 0; trial < 300; ++trial) {
    double c[6];
    for (double& each : c) each = uniform(rng, 0.0, 1.0) < 0.2 ? 0.0 : uniform(rng, -1.0, 1.0);
    const double width = std::pow(10.0, uniform(rng, -1.0, 0.5));
    const auto found = extremes::of_piece(c, 1, width);
    double speed = 0.0, low = INFINITY, high = -INFINITY;
    for (int i = 0; i <= 2000; ++i) {
      const double t = width * i / 2000;
      const double v = c[4] + t * (2 * c[3] + t * (3 * c[2] + t * (4 * c[1] + t * 5 * c[0])));
      const double acceleration = 2 * c[3] + t * (6 * c[2] + t * (12 * c[1] + t * 20 * c[0]));
      speed = std::max(speed, std::abs(v)), low = std::min(low, acceleration), high = std::max(high, acceleration);
    }
    const double size = 1.0 + speed + std::abs(low) + std::abs(high);
    CHECK(found.speed >= speed - 1e-9 * size && found.speed <= speed + 1e-3 * size);
    CHECK(found.low <= low + 1e-9 * size && found.low >= low - 1e-3 * size);
    CHECK(found.high >= high - 1e-9 * size && found.high <= high + 1e-3 * size);
  }
}

namespace {

barrier::Program random_program(std::mt19937& rng, std::size_t blocks, std::size_t linear, std::size_t half) {
  barrier::Program program(blocks, linear, half);
  for (double& each : program.weight) each = uniform(rng, 0.5, 1.5);
  for (double& each : program.bound) each = uniform(rng, 0.1, 4.0);
  for (std::size_t i = 0; i < blocks; ++i) {
    for (std::size_t place = 0; place < 3; ++place)
      for (std::size_t j = 0; j < program.columns(); ++j) program.row(j, place, i) = uniform(rng, -1.0, 1.0);
    for (auto* limits : {&program.above, &program.below, &program.jerk})
      for (std::size_t j = 0; j * program.stride < limits->size(); ++j)
        (*limits)[j * program.stride + i] = uniform(rng, 0.1, 2.0);
    for (std::size_t end = 0; end < 2; ++end) {
      const double part = uniform(rng, 0.2, 0.8);
      program.speed_row(end, end, i) = 1.0 - part, program.speed_row(end, end + 1, i) = part;
    }
  }
  return program;
}

}  // namespace

TEST(the_barrier_ends_within_all_limits_and_no_slower_than_it_began) {
  std::mt19937 rng(5);
  for (int trial = 0; trial < 40; ++trial) {
    const std::size_t blocks = std::size_t(whole(rng, 3, 30));
    const auto program = random_program(rng, blocks, std::size_t(whole(rng, 0, 4)), std::size_t(whole(rng, 1, 3)));
    int steps = 0;
    barrier::State start, end;
    start.z = barrier::Numbers(blocks + 2, 1.0);
    CHECK(barrier::scale_inside(program, start));
    end.z = barrier::minimise(program, barrier::Numbers(blocks + 2, 1.0), 0.3, 3e-3, steps);
    CHECK(end.z.size() == blocks + 2);
    barrier::evaluate(program, end);
    CHECK(end.inside && steps > 0);
    CHECK(end.z[0] == end.z[1] && end.z[blocks] == end.z[blocks + 1]);
    CHECK(end.duration <= start.duration * (1.0 + 1e-9));
  }
}

TEST(the_sum_of_logarithms_is_that_of_all_distances) {
  std::mt19937 rng(6);
  const std::size_t blocks = 13;
  auto program = random_program(rng, blocks, 3, 2);
  for (double& each : program.rows) each *= 0.1;
  for (double& each : program.bound) each = 1.5;
  barrier::State state;
  state.z = barrier::Numbers(blocks + 2, 0.7);
  barrier::evaluate(program, state);
  CHECK(state.inside);
  double sum = 0.0;
  for (std::size_t i = 0; i < blocks + 2; ++i) sum += std::log(program.bound[i] - state.z[i]);
  for (std::size_t j = 0; j < program.columns(); ++j)
    for (std::size_t i = 0; i < blocks; ++i)
      sum += std::log(state.above[j * program.stride + i]) + std::log(state.below[j * program.stride + i]);
  CHECK_NEAR(state.barrier, sum, 1e-10 * std::abs(sum));
}

TEST(the_barrier_ends_where_no_speed_is_within_the_limits) {
  std::mt19937 rng(7);
  auto program = random_program(rng, 3, 1, 1);
  for (std::size_t place = 0; place < 3; ++place) program.row(0, place, 1) = 0.1;
  int steps = 0;
  CHECK(!barrier::minimise(program, barrier::Numbers(5, 1.0), 0.3, 3e-3, steps).empty() && steps > 0);
  for (const double limit : {-0.1, 0.0, std::nan("")}) {
    program.above[1] = limit;
    CHECK(barrier::minimise(program, barrier::Numbers(5, 1.0), 0.3, 3e-3, steps).empty() && steps == 0);
  }
}

TEST(splines_are_what_the_triangle_of_de_boor_gives_at_every_argument) {
  std::mt19937 rng(8);
  for (int trial = 0; trial < 20; ++trial) {
    const std::size_t degree = std::size_t(whole(rng, 3, 4)), pieces = std::size_t(whole(rng, 1, 6));
    timing::Numbers knots{0.0};
    for (std::size_t i = 0; i < pieces; ++i) knots.push_back(knots.back() + uniform(rng, 0.1, 1.0));
    timing::Table control(pieces + degree, 1);
    for (double& each : control.values) each = uniform(rng, -1.0, 1.0);
    const timing::Polynomials spline(knots, control, degree);
    const auto knot = [&](std::size_t i) { return knots[i < degree ? 0 : std::min(i - degree, pieces)]; };
    for (int sample = 0; sample < 50; ++sample) {
      const double x = uniform(rng, 0.0, knots.back());
      std::size_t last = degree;
      while (last + 1 < degree + pieces && knot(last + 1) <= x) ++last;
      std::vector<double> value(control.values.begin() + (last - degree), control.values.begin() + last + 1);
      for (std::size_t level = 1; level <= degree; ++level)
        for (std::size_t i = degree; i >= level; --i) {
          const double begin = knot(last - degree + i), part = (x - begin) / (knot(last + 1 + i - level) - begin);
          value[i] = (1.0 - part) * value[i - 1] + part * value[i];
        }
      CHECK_NEAR(spline(x), value[degree], 1e-12);
      // Each derivative is that of the one before.
      double here[5], after[5];
      const double step = 1e-6;
      spline(x, degree, here), spline(std::min(x + step, knots.back()), degree, after);
      if (x + step < knots.back() && knot(last + 1) > x + step)
        for (std::size_t order = 0; order < degree; ++order)
          CHECK_NEAR((after[order] - here[order]) / step, (here[order + 1] + after[order + 1]) / 2.0,
                     1e-4 * (1.0 + std::abs(here[order + 1])));
    }
  }
}

TEST(a_path_is_timed_within_all_limits_from_rest_to_rest) {
  std::mt19937 rng(9);
  for (int trial = 0; trial < 12; ++trial) {
    const std::size_t joints = std::size_t(whole(rng, 1, 4)), count = std::size_t(whole(rng, 2, 6));
    timing::Table knots(count, joints);
    for (double& each : knots.values) each = uniform(rng, -1.0, 1.0);
    const timing::Numbers velocity(joints, 2.0), far(joints, 10.0), near(joints, -10.0);
    const double jerk = trial % 2 == 0 ? 60.0 : INFINITY;
    const timing::Limits limits{velocity, timing::Numbers(joints, 8.0), timing::Numbers(joints, jerk), {}, {}, {}, {}};
    const auto smoothing = timing::smooth(timing::polyline(knots, velocity), near, far, {}, 5e-3);
    CHECK(smoothing.deviation <= 5e-3);
    const auto timed = timing::Timer(smoothing.path, limits, {60, 8, 1e-3, 1e-2, 1e6}).run();
    CHECK(timed.outcome == timing::Outcome::kTimed);
    const auto& motion = timed.motion;
    for (std::size_t joint = 0; joint < joints; ++joint) {
      CHECK(motion.v[0][joint] == 0.0 && motion.v[motion.pieces()][joint] == 0.0);
      CHECK(motion.q[motion.pieces()][joint] == knots[count - 1][joint]);
    }
    timing::States state(1, joints);
    for (std::size_t piece = 0; piece < motion.pieces(); ++piece)
      for (int part = 0; part <= 4; ++part) {
        state.within(0, motion, piece, part / 4.0);
        for (std::size_t joint = 0; joint < joints; ++joint)
          CHECK(std::abs(state.v[0][joint]) <= 2.0 && std::abs(state.a[0][joint]) <= 8.0);
      }
  }
}
