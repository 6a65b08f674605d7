// The passes against the trapezoid of one joint, extremes against dense samples, the barrier against its limits.
#include "check.hpp"
#include "reachability/barrier.hpp"
#include "reachability/extremes.hpp"
#include "reachability/passes.hpp"

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

TEST(the_barrier_ends_within_all_limits_and_no_slower_than_it_began) {
  std::mt19937 rng(5);
  for (int trial = 0; trial < 40; ++trial) {
    const std::size_t blocks = std::size_t(whole(rng, 3, 30)), linear = std::size_t(whole(rng, 0, 4));
    const std::size_t jerks = 2 * std::size_t(whole(rng, 1, 3)), columns = linear + jerks;
    std::vector<double> weight(blocks + 2), bound(blocks + 2), rows(blocks * columns * 3), above(blocks * linear);
    std::vector<double> below(blocks * linear), jerk(blocks * jerks), speed(blocks * 6, 0.0), z(blocks + 2, 1.0);
    for (double& each : weight) each = uniform(rng, 0.5, 1.5);
    for (double& each : bound) each = uniform(rng, 0.1, 4.0);
    for (double& each : rows) each = uniform(rng, -1.0, 1.0);
    for (auto* limits : {&above, &below, &jerk}) {
      for (double& each : *limits) each = uniform(rng, 0.1, 2.0);
    }
    for (std::size_t i = 0; i < blocks; ++i) {
      const double part = uniform(rng, 0.2, 0.8);
      speed[6 * i] = 1.0 - part, speed[6 * i + 1] = part, speed[6 * i + 4] = 1.0 - part, speed[6 * i + 5] = part;
    }
    const barrier::Program program{weight.data(), bound.data(), rows.data(), above.data(), below.data(),
                                   jerk.data(),   speed.data(), blocks,      linear,       jerks};
    int steps = 0;
    barrier::State start, end;
    start.z = z;
    CHECK(barrier::scale_inside(program, start));
    end.z = barrier::minimise(program, z, 0.3, 3e-3, steps);
    barrier::evaluate(program, end);
    CHECK(end.inside && steps > 0);
    CHECK(end.z[0] == end.z[1] && end.z[blocks] == end.z[blocks + 1]);
    CHECK(end.duration <= start.duration * (1.0 + 1e-9));
  }
}

TEST(the_barrier_ends_where_no_speed_is_within_the_limits) {
  const std::size_t blocks = 3;
  const std::vector<double> weight(blocks + 2, 1.0), bound(blocks + 2, 4.0), rows(blocks * 3 * 3, 0.1);
  std::vector<double> above(blocks, 1.0), below(blocks, 1.0), jerk(blocks * 2, 1.0), speed(blocks * 6, 0.5);
  const std::vector<double> z(blocks + 2, 1.0);
  const barrier::Program program{weight.data(), bound.data(), rows.data(), above.data(), below.data(),
                                 jerk.data(),   speed.data(), blocks,      1,            2};
  int steps = 0;
  CHECK(!barrier::minimise(program, z, 0.3, 3e-3, steps).empty() && steps > 0);
  for (const double limit : {-0.1, 0.0, std::nan("")}) {
    above[1] = limit;
    CHECK(barrier::minimise(program, z, 0.3, 3e-3, steps).empty() && steps == 0);
  }
}
