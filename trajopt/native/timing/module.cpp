// Binding of the core that retimes a path: see timer.hpp, and passes.hpp, barrier.hpp, extremes.hpp for its loops,
// which are bound by themselves so that each can be compared with the same in plain Python.
//
// The interpreter's lock is released, but for the moments in which a function of Python is asked for torques, speeds
// of tools, or how far bodies move.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <string>

#include "../arrays.hpp"
#include "../gil.hpp"
#include "../leaks.hpp"
#include "joint_stop.hpp"
#include "path_stop.hpp"
#include "stopping.hpp"
#include "timer.hpp"
#include "tracking.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using arrays::Block, arrays::expect, arrays::hand_over, arrays::Matrix, arrays::Numpy, arrays::Vector;
using timing::Numbers, timing::Table;

namespace {

Numbers copied(const Vector<double>& values) { return Numbers(values.data(), values.data() + values.size()); }

Table copied(const Matrix<double>& values) {
  return Table(values.shape(0), values.shape(1), Numbers(values.data(), values.data() + values.size()));
}

Numpy<double> handed(const Table& table) { return hand_over(table.values, {table.rows, table.columns}); }

// What a function of Python returned cannot be used.
struct Refused {
  std::string name, what;
};

// A function of Python that is asked for an array of numbers.
class Asked {
 public:
  Asked(nb::callable function, const char* name) : function_(std::move(function)), name_(name) {}
  Asked(const Asked&) = delete;

  // Numbers of a shape; what the function throws passes through.
  template <typename... Tables>
  Numbers operator()(const std::vector<std::size_t>& shape, const Tables&... tables) const {
    const gil::Taken lock;
    nb::ndarray<const double, nb::c_contig, nb::device::cpu> found;
    if (!nb::try_cast(gil::call(function_, handed(tables)...), found)) throw Refused{name_, "returned no array of numbers"};
    std::vector<std::size_t> returned;
    for (std::size_t axis = 0; axis < found.ndim(); ++axis) returned.push_back(found.shape(axis));
    if (returned != shape) throw Refused{name_, "returned an array " + written(returned) + ", not " + written(shape)};
    Numbers values(found.data(), found.data() + found.size());
    for (const double each : values)
      if (!std::isfinite(each)) throw Refused{name_, "returned a number that is not finite"};
    return values;
  }

 private:
  static std::string written(const std::vector<std::size_t>& shape) {
    std::string text;
    for (const std::size_t length : shape) text += (text.empty() ? "" : " x ") + std::to_string(length);
    return text;
  }

  nb::callable function_;
  const char* name_;
};

// Torques of the joints with these places only.
timing::Torques torques_by(const Asked& function, const std::vector<std::size_t>& joints) {
  return [&](const Table& q, const Table& v, const Table& a) {
    const Table all(q.rows, q.columns, function({q.rows, q.columns}, q, v, a));
    Table found(q.rows, joints.size());
    for (std::size_t row = 0; row < q.rows; ++row)
      for (std::size_t column = 0; column < joints.size(); ++column) found[row][column] = all[row][joints[column]];
    return found;
  };
}

// What came of retiming: the timing, and the smooth path.
struct Retimed {
  timing::Timed timed;
  Numbers knots;
  Table control;
  double deviation;
};

using Each = Vector<double>;
using Function = std::optional<nb::callable>;

// Positions: lower and upper; limits: velocity, acceleration, jerk and effort, infinite where there is none.
Retimed retime(const Matrix<double>& knots, const std::tuple<Each, Each>& positions,
               const std::tuple<Each, Each, Each, Each>& limits, const Function& inverse_dynamics, const Each& tools,
               const Function& speeds, const Function& deviation, double tolerance, std::size_t points, int passes,
               double remainder, double shortest, double longest) {
  const auto& [lower, upper] = positions;
  const auto& [velocity, acceleration, jerk, effort] = limits;
  for (const Each* each : {&lower, &upper, &velocity, &acceleration, &jerk, &effort})
    expect(each->size() == knots.shape(1), "one limit for each joint");
  expect(knots.shape(0) >= 2, "two knots at least");
  expect(speeds.has_value() == (tools.size() > 0), "limits of tools with their speeds, and only then");
  timing::Limits all{copied(velocity), copied(acceleration), copied(jerk), {}, {}, {}, copied(tools)};
  std::optional<Asked> torques, moving, moved;
  std::vector<std::size_t> limited;
  if (inverse_dynamics) {
    torques.emplace(*inverse_dynamics, "inverse_dynamics");
    for (std::size_t joint = 0; joint < effort.size(); ++joint)
      if (std::isfinite(effort(joint))) limited.push_back(joint), all.torque.push_back(effort(joint));
    if (!limited.empty()) all.torques = torques_by(*torques, limited);
  }
  if (speeds) {
    moving.emplace(*speeds, "tools.speeds");
    all.speeds = [&](const Table& q, const Table& v) {
      return Table(q.rows, tools.size(), (*moving)({q.rows, tools.size()}, q, v));
    };
  }
  timing::Deviation bound;
  if (deviation) {
    moved.emplace(*deviation, "deviation");
    bound = [&](const Table& smooth, const Table& straight) { return (*moved)({smooth.rows}, smooth, straight); };
  }
  const Table corners = copied(knots);
  const Numbers least = copied(lower), most = copied(upper);
  gil::Released released;
  const auto smoothing = timing::smooth(timing::polyline(corners, all.velocity), least, most, bound, tolerance);
  const timing::Options options{points, passes, remainder, shortest, longest};
  return {timing::Timer(smoothing.path, std::move(all), options).run(), smoothing.path.knots, smoothing.path.control,
          smoothing.deviation};
}

Numpy<double> fastest(const Vector<double>& distance, const Matrix<double>& a, const Matrix<double>& b,
                      const Matrix<double>& c, const Matrix<double>& limit, const Vector<double>& bound) {
  const std::size_t points = a.shape(0), columns = a.shape(1);
  for (const auto* other : {&b, &c, &limit})
    expect(other->shape(0) == points && other->shape(1) == columns, "a, b, c and limit must have one shape");
  expect(distance.shape(0) == points && bound.shape(0) == points + 1,
         "distance must have as many rows as a, bound one more");
  return hand_over(passes::fastest({distance.data(), a.data(), b.data(), c.data(), limit.data(), bound.data(), points,
                                    columns}),
                   {points + 1});
}

std::tuple<Numpy<double>, int> minimise(const Vector<double>& weight, const Vector<double>& bound,
                                        const Block<double>& rows, const Matrix<double>& above,
                                        const Matrix<double>& below, const Matrix<double>& jerk,
                                        const Block<double>& speed, const Vector<double>& z, double first_gap,
                                        double gap) {
  const std::size_t blocks = rows.shape(0), linear = above.shape(1), jerks = jerk.shape(1);
  expect(rows.shape(1) == linear + jerks && rows.shape(2) == 3 && jerks % 2 == 0 && below.shape(1) == linear &&
             speed.shape(1) == 2 && speed.shape(2) == 3,
         "rows must be (blocks, above's columns + jerk's, 3), speed (blocks, 2, 3)");
  for (const std::size_t rows_of : {above.shape(0), below.shape(0), jerk.shape(0), speed.shape(0)})
    expect(rows_of == blocks, "tables must have a row for each block");
  for (const auto* column : {&weight, &bound, &z})
    expect(column->shape(0) == blocks + 2, "columns must have two rows more than blocks");
  barrier::Program program(blocks, linear, jerks / 2);
  program.weight = copied(weight), program.bound = copied(bound);
  for (std::size_t i = 0; i < blocks; ++i) {
    for (std::size_t j = 0; j < linear; ++j)
      program.above[j * program.stride + i] = above(i, j), program.below[j * program.stride + i] = below(i, j);
    for (std::size_t j = 0; j < jerks; ++j) program.jerk[j * program.stride + i] = jerk(i, j);
    for (std::size_t place = 0; place < 3; ++place) {
      for (std::size_t j = 0; j < linear + jerks; ++j) program.row(j, place, i) = rows(i, j, place);
      for (std::size_t end = 0; end < 2; ++end) program.speed_row(end, place, i) = speed(i, end, place);
    }
  }
  int steps = 0;
  Numbers found = barrier::minimise(program, copied(z), first_gap, gap, steps);
  const std::size_t count = found.size();
  return {hand_over(std::move(found), {count}), steps};
}

auto motion_extremes(const Block<double>& coefficients, const Vector<double>& widths) {
  const std::size_t pieces = coefficients.shape(1), joints = coefficients.shape(2), count = pieces * joints;
  expect(coefficients.shape(0) == 6 && widths.shape(0) == pieces,
         "coefficients must be (6, pieces, joints), widths (pieces,)");
  Table speed(pieces, joints), low(pieces, joints), high(pieces, joints);
  for (std::size_t i = 0; i < count; ++i) {
    const auto found = extremes::of_piece(coefficients.data() + i, count, widths.data()[i / joints]);
    speed.values[i] = found.speed, low.values[i] = found.low, high.values[i] = found.high;
  }
  return std::make_tuple(handed(speed), handed(low), handed(high));
}

auto brake(const Vector<double>& times, const Block<double>& coefficients, const Vector<double>& acceleration,
           const Vector<double>& jerk, double ramp, double begin, double share, double kept, double step) {
  const std::size_t pieces = coefficients.shape(1), joints = coefficients.shape(2);
  expect(coefficients.shape(0) == 6 && pieces > 0 && times.shape(0) == pieces + 1,
         "coefficients must be (6, pieces, joints), times (pieces + 1,)");
  expect(acceleration.shape(0) == joints && jerk.shape(0) == joints, "limits must have one value for each joint");
  const stopping::Motion motion{times.data(), coefficients.data(), pieces, joints};
  const stopping::Limits limits{acceleration.data(), jerk.data(), ramp, share, kept};
  stopping::Braking found = stopping::brake(motion, limits, begin, step);
  const std::size_t count = found.clock.size();
  Numbers rows;
  rows.reserve(3 * count);
  for (const auto* column : {&found.clock, &found.rate, &found.slope}) rows.insert(rows.end(), column->begin(), column->end());
  return std::make_tuple(hand_over(std::move(rows), {3, count}), found.last);
}

// States of joints, (3, n), with limits, (5, n): rows of least and largest positions, velocities, accelerations and jerks.
struct Joints {
  std::vector<stopping::Moving> moving;
  std::vector<stopping::JointLimit> limits;

  Joints(const Matrix<double>& begin, const Matrix<double>& most) {
    const std::size_t joints = begin.shape(1);
    expect(begin.shape(0) == 3 && most.shape(0) == 5 && most.shape(1) == joints, "begin must be (3, n), limits (5, n)");
    const double *b = begin.data(), *l = most.data(), nothing = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < joints; ++j) {
      moving.push_back({b[j], b[joints + j], b[2 * joints + j]});
      limits.push_back({l[j], l[joints + j], l[2 * joints + j], l[3 * joints + j], l[4 * joints + j]});
      const auto& [position, velocity, acceleration] = moving.back();
      expect(std::abs(position) < nothing && std::abs(velocity) < nothing && std::abs(acceleration) < nothing &&
                 limits.back().acceleration > 0.0 && limits.back().jerk > 0.0 && limits.back().jerk < nothing,
             "states must be finite, and accelerations and jerks limited");
    }
  }
};

// Positions, velocities and accelerations, (3, k, n).
Numpy<double> in_orders(const std::vector<stopping::Moving>& rows, std::size_t joints) {
  const std::size_t size = rows.size();
  Numbers values(3 * size);
  for (std::size_t i = 0; i < size; ++i)
    values[i] = rows[i].position, values[size + i] = rows[i].velocity, values[2 * size + i] = rows[i].acceleration;
  return hand_over(std::move(values), {3, size / joints, joints});
}

// How joints come to rest: times, (k,), and states, (3, k, n).
auto stop_from(const Matrix<double>& begin, const Matrix<double>& limits, double tick, double excess) {
  const Joints joints(begin, limits);
  const stopping::JointStop found = stopping::stop_from(joints.moving, joints.limits, tick, excess);
  Numbers times;
  for (const long each : found.ticks) times.push_back(tick * static_cast<double>(each));
  const std::size_t count = times.size();
  return std::make_tuple(hand_over(std::move(times), {count}), in_orders(found.rows, begin.shape(1)));
}

// A motion of constant jerks between times, (k + 1,), near targets, (m, n), that are due at some of them, with the first of
// some weights that keeps the first `counted`, or else most of them: states, (3, k + 1, n), jerks, (k, n), and the number kept.
auto track(const Matrix<double>& begin, const Vector<double>& times, const Vector<std::int64_t>& due,
           const Matrix<double>& targets, std::size_t counted, const Vector<double>& weights, const Matrix<double>& limits) {
  const Joints joints(begin, limits);
  const std::size_t count = times.size() - 1;
  expect(targets.shape(0) == due.size() && targets.shape(1) == begin.shape(1), "targets must be (m, n), one for each due");
  for (std::size_t k = 0; k < count; ++k) expect(times(k) < times(k + 1), "times must increase");
  std::vector<std::size_t> at;
  for (std::size_t k = 0; k < due.size(); ++k) {
    expect(due(k) > (k ? due(k - 1) : 0) && due(k) <= static_cast<std::int64_t>(count), "due must increase from 1 to k");
    at.push_back(static_cast<std::size_t>(due(k)));
  }
  expect(weights.size() > 0 && *std::min_element(weights.data(), weights.data() + weights.size()) > 0.0,
         "the weights must be above 0");
  const Numbers moments = copied(times);
  tracking::Tracked found;
  for (std::size_t i = 0; i < weights.size() && (i == 0 || found.kept < counted); ++i) {
    tracking::Tracked next =
        tracking::track(joints.moving, moments, at, targets.data(), counted, weights(i), joints.limits);
    if (i == 0 || next.kept > found.kept) found = std::move(next);
  }
  return std::make_tuple(in_orders(found.rows, begin.shape(1)),
                         hand_over(std::move(found.jerks), {count, begin.shape(1)}), found.kept);
}

// Stops of a motion along its own path, tabulated when they are first asked for.
class Stops {
 public:
  Stops(const Vector<double>& times, const Block<double>& coefficients, const Vector<double>& acceleration,
        const Vector<double>& jerk, Numbers shares, std::vector<std::size_t> every, double ramp, double kept,
        double step, double moment, double excess)
      : joints_(coefficients.shape(2)),
        stops_(copied(times), Numbers(coefficients.data(), coefficients.data() + coefficients.size()),
               copied(acceleration), copied(jerk),
               {std::move(shares), std::move(every), ramp, kept, step, moment, excess}) {
    expect(coefficients.shape(0) == 6 && coefficients.shape(1) > 0 && times.shape(0) == coefficients.shape(1) + 1,
           "coefficients must be (6, pieces, joints), times (pieces + 1,)");
    expect(acceleration.shape(0) == joints_ && jerk.shape(0) == joints_, "limits must have one value for each joint");
  }

  nb::object earliest(double time, double after) {
    auto found = stops_.earliest(time, after);
    if (!found) return nb::none();
    auto& [points, leaves] = *found;
    const std::size_t count = points.times.size();
    const auto rows = [&](Numbers& values) { return nb::cast(hand_over(std::move(values), {count, joints_})); };
    return nb::make_tuple(nb::cast(hand_over(std::move(points.times), {count})), rows(points.positions),
                          rows(points.velocities), rows(points.accelerations), leaves);
  }

 private:
  std::size_t joints_;
  stopping::PathStops stops_;
};

}  // namespace

NB_MODULE(timing, m) {
  leaks::settle();
  nb::register_exception_translator(
      [](const std::exception_ptr& thrown, void*) {
        const auto refuse = [](const std::string& name, const std::string& what) {
          const nb::object error = nb::module_::import_("trajopt.values.errors").attr("ShapeError");
          PyErr_SetObject(error.ptr(), error(name, what).ptr());
        };
        try {
          std::rethrow_exception(thrown);
        } catch (const Refused& refused) {
          refuse(refused.name, refused.what);
        } catch (const std::overflow_error& overflow) {
          refuse("path", overflow.what());
        }
      },
      nullptr);
  nb::enum_<timing::Outcome>(m, "Outcome")
      .value("TIMED", timing::Outcome::kTimed)
      .value("GRAVITY_TOO_STRONG", timing::Outcome::kGravityTooStrong)
      .value("TOO_LONG", timing::Outcome::kTooLong)
      .value("NOTHING_FITS", timing::Outcome::kNothingFits)
      .value("EXCEEDED", timing::Outcome::kExceeded);
  nb::enum_<timing::Kind>(m, "Kind")
      .value("VELOCITY", timing::Kind::kVelocity)
      .value("TOOL_SPEED", timing::Kind::kToolSpeed)
      .value("ACCELERATION", timing::Kind::kAcceleration)
      .value("TORQUE", timing::Kind::kTorque)
      .value("JERK", timing::Kind::kJerk);
  const auto owned = nb::rv_policy::move;  // every call makes an array of its own
  const auto numbers = [](const Numbers& values) { return hand_over(values, {values.size()}); };
  nb::class_<Retimed>(m, "Retimed")
      .def_prop_ro("outcome", [](const Retimed& found) { return found.timed.outcome; })
      .def_prop_ro("kind", [](const Retimed& found) { return found.timed.limit.kind; })
      .def_prop_ro("column", [](const Retimed& found) { return found.timed.limit.place; })
      .def_prop_ro("place", [](const Retimed& found) { return found.timed.place; })
      .def_prop_ro("value", [](const Retimed& found) { return found.timed.value; })
      .def_prop_ro("times", [numbers](const Retimed& found) { return numbers(found.timed.motion.times); }, owned)
      .def_prop_ro("positions", [](const Retimed& found) { return handed(found.timed.motion.q); }, owned)
      .def_prop_ro("velocities", [](const Retimed& found) { return handed(found.timed.motion.v); }, owned)
      .def_prop_ro("accelerations", [](const Retimed& found) { return handed(found.timed.motion.a); }, owned)
      .def_prop_ro("parameters", [numbers](const Retimed& found) { return numbers(found.timed.s); }, owned)
      .def_prop_ro("added", [](const Retimed& found) { return found.timed.added; })
      .def_prop_ro("passes", [](const Retimed& found) { return found.timed.passes; })
      .def_prop_ro("binding", [](const Retimed& found) { return found.timed.binding; })
      .def_prop_ro("knots", [numbers](const Retimed& found) { return numbers(found.knots); }, owned)
      .def_prop_ro("control", [](const Retimed& found) { return handed(found.control); }, owned)
      .def_ro("deviation", &Retimed::deviation);
  m.def("retime", &retime, "knots"_a, "positions"_a, "limits"_a, "inverse_dynamics"_a.none(), "tools"_a, "speeds"_a.none(),
        "deviation"_a.none(), "tolerance"_a, "points"_a, "passes"_a, "remainder"_a, "shortest"_a, "longest"_a);
  m.def("fastest", &fastest, "distance"_a, "a"_a, "b"_a, "c"_a, "limit"_a, "bound"_a);
  m.def("minimise", &minimise, "weight"_a, "bound"_a, "rows"_a, "above"_a, "below"_a, "jerk"_a, "speed"_a, "z"_a,
        "first_gap"_a, "gap"_a);
  m.def("brake", &brake, "times"_a, "coefficients"_a, "acceleration"_a, "jerk"_a, "ramp"_a, "begin"_a, "share"_a,
        "kept"_a, "step"_a);
  m.def("stop_from", &stop_from, "begin"_a, "limits"_a, "tick"_a, "excess"_a);
  m.def("track", &track, "begin"_a, "times"_a, "due"_a, "targets"_a, "counted"_a, "weights"_a, "limits"_a);
  nb::class_<Stops>(m, "Stops")
      .def(nb::init<const Vector<double>&, const Block<double>&, const Vector<double>&, const Vector<double>&, Numbers,
                    std::vector<std::size_t>, double, double, double, double, double>(),
           "times"_a, "coefficients"_a, "acceleration"_a, "jerk"_a, "shares"_a, "every"_a, "ramp"_a, "kept"_a,
           "step"_a, "moment"_a, "excess"_a)
      .def("earliest", &Stops::earliest, "time"_a, "after"_a);
  m.def("motion_extremes", &motion_extremes, "coefficients"_a, "widths"_a);
}
