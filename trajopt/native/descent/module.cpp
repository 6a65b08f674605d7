// Binding of programs over knots, and of descents on them.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "../gil.hpp"
#include "../leaks.hpp"
#include "binding.hpp"
#include "loop.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace descent;
using arrays::Block, arrays::expect, arrays::hand_over, arrays::Matrix, arrays::Vector;
using SharedPoint = std::shared_ptr<Point>;

void bind_frame_terms(nb::module_& m);
void bind_what_changes(nb::class_<Program>& program);

namespace {

constexpr auto kOwned = nb::rv_policy::automatic;  // arrays that are handed over belong to nothing else

Role cost(Kind kind, const Vector<double>& weight) { return {kind, copied(weight), {}, {}, 0.0}; }

Role bounds(const Vector<double>& lower, const Vector<double>& upper, double tolerance) {
  return {Kind::kBounded, {}, copied(lower), copied(upper), tolerance};
}

void make_program(Program* made, const Matrix<double>& lower, const Matrix<double>& upper, const Vector<double>& scale,
                  robot::RobotQuery& query) {
  const std::size_t knots = lower.shape(0), joints = lower.shape(1);
  expect(upper.shape(0) == knots && upper.shape(1) == joints && scale.shape(0) == joints, "bounds of the same variables");
  expect(static_cast<int>(joints) == query.positions(), "one variable for each joint of the group");
  Variables variables;
  variables.joints = static_cast<int>(joints);
  variables.knot_moves.assign(knots, 0);
  for (std::size_t variable = 0; variable < lower.size(); ++variable) {
    const bool moves = lower.data()[variable] < upper.data()[variable];
    variables.moves.push_back(moves);
    if (moves) variables.knot_moves[variable / joints] = 1;
  }
  new (made) Program(std::move(variables), copied(lower), copied(upper), copied(scale), query);
}

void expect_stencils(const Program& program, std::size_t rows, const Block<double>& jacobian,
                     const Matrix<std::int64_t>& knots) {
  expect(jacobian.shape(0) == rows && knots.shape(0) == rows && knots.shape(1) == jacobian.shape(1),
         "as many values and stencils as rows");
  expect(static_cast<int>(jacobian.shape(2)) == program.variables().joints, "one derivative for each joint");
  expect_knots(program, knots);
}

void add_linear(Program& program, const Role& role, const Vector<double>& constant, const Block<double>& jacobian,
                const Matrix<std::int64_t>& knots) {
  expect_stencils(program, constant.shape(0), jacobian, knots);
  expect_numbers(role, constant.shape(0), false);
  program.add({role, Linear{static_cast<int>(knots.shape(1)), copied(constant), copied(jacobian), copied(knots)}});
}

void add_distances(Program& program, const Role& role, const Matrix<std::int64_t>& knots, const Matrix<double>& weight,
                   const Vector<double>& place, const Vector<double>& reach, const Vector<double>& factor,
                   const Margins& margins) {
  const std::size_t pairs = program.robot().pairs();
  expect(reach.shape(0) == pairs && factor.shape(0) == pairs && margins.full.size() == pairs, "numbers for each pair");
  expect_numbers(role, pairs, true);
  Samples along = samples_of(program, knots, weight, place);
  program.add({role, Distances{std::move(along), copied(reach), copied(factor), margins}});
}

void add_frames(Program& program, const Role& role, const Matrix<std::int64_t>& knots, const Matrix<double>& weight,
                const Vector<double>& place, const robot::View& view, const std::shared_ptr<FrameTerm>& term,
                std::int64_t configurations) {
  const int joints = program.robot().joints();
  expect(0 <= view.joint && view.joint < joints && 0 <= view.base && view.base < joints, "joints of the robot");
  Samples along = samples_of(program, knots, weight, place);
  expect_numbers(role, static_cast<std::size_t>(along.count()) * term->components(), true);
  program.add({role, Frames{std::move(along), view, term, configurations}});
}

void add_outside(Program& program, const Role& role) {
  std::size_t number = 0;
  for (const auto& part : program.parts()) number += std::holds_alternative<Outside>(part.rows);
  program.add({role, Outside{number}});
}

Margins* tapered(const Vector<double>& full, const Vector<double>& required, const Vector<double>& at_start,
                 const Vector<double>& at_end, const Vector<double>& contact_until, const Vector<double>& contact_from,
                 const Vector<double>& depth, const Vector<bool>& gives, double last, double taper, double share) {
  for (const auto* each : {&required, &at_start, &at_end, &contact_until, &contact_from, &depth}) {
    expect(each->shape(0) == full.shape(0), "numbers for each pair");
  }
  expect(gives.shape(0) == full.shape(0), "numbers for each pair");
  return new Margins{copied(full),          copied(required),     copied(at_start),
                     copied(at_end),        copied(contact_until), copied(contact_from),
                     copied(depth),         {gives.data(), gives.data() + gives.size()},
                     last,                  taper,                share};
}

// Rows as Python hands them out: values, derivatives, knots, and weights, or bounds.
Rows taken(const Program& program, const Role& role, const nb::handle& given) {
  const auto rows = nb::cast<nb::tuple>(given);
  const auto value = nb::cast<Vector<double>>(rows[0]);
  const auto jacobian = nb::cast<Block<double>>(rows[1]);
  const auto knots = nb::cast<Matrix<std::int64_t>>(rows[2]);
  expect_stencils(program, value.shape(0), jacobian, knots);
  Rows made;
  made.value = copied(value);
  made.new_jacobian = copied(jacobian);
  made.new_knot = copied(knots);
  if (role.bounded()) {
    made.new_lower = copied(nb::cast<Vector<double>>(rows[3]));
    made.new_upper = copied(nb::cast<Vector<double>>(rows[4]));
    expect(made.new_lower.size() == made.value.size() && made.new_upper.size() == made.value.size(), "bounds for each row");
  } else {
    made.new_weight = copied(nb::cast<Vector<double>>(rows[3]));
    expect(made.new_weight.size() == made.value.size(), "a weight for each row");
  }
  made.settle(static_cast<int>(knots.shape(1)));
  return made;
}

// Keeps an object until nobody needs it; the last may be a thread without the interpreter's lock.
std::shared_ptr<const void> kept(nb::object object) {
  return {static_cast<const void*>(object.release().ptr()), [](const void* released) {
            const gil::Taken lock;
            nb::steal(static_cast<PyObject*>(const_cast<void*>(released)));
          }};
}

Answer answered(const Program& program, const nb::callable& ask, const double* x) {
  const gil::Taken lock;
  const std::size_t knots = program.variables().knots(), joints = program.variables().joints;
  const auto knots_asked = hand_over(std::vector<double>(x, x + knots * joints), {knots, joints});
  const auto given = nb::cast<nb::tuple>(gil::call(ask, knots_asked));
  const auto rows = nb::cast<nb::list>(given[0]);
  Answer answer;
  std::size_t number = 0;
  for (const auto& part : program.parts()) {
    if (!std::holds_alternative<Outside>(part.rows)) continue;
    expect(number < nb::len(rows), "rows of each part outside");
    answer.rows.push_back(taken(program, part.role, rows[number++]));
  }
  answer.configurations = nb::cast<std::int64_t>(given[1]);
  answer.kept = kept(nb::borrow(given[2]));
  return answer;
}

Program::Ask asking(const Program& program, const nb::callable& ask) {
  return [&program, &ask](const double* x) { return answered(program, ask, x); };
}

SharedPoint point_at(Program& program, const Matrix<double>& x, const nb::callable& ask) {
  expect(x.shape(0) * x.shape(1) == program.variables().moves.size(), "as many numbers as variables");
  std::vector<double> at = copied(x);
  const auto outside = asking(program, ask);
  gil::Released released;
  return std::const_pointer_cast<Point>(program.at(std::move(at), outside));
}

auto work_of(const Work& work) { return std::make_tuple(work.configurations, work.bounds, work.distances); }

nb::list told(const Entry* entries, std::size_t count) {
  nb::list list;
  for (const Entry* entry = entries; entry != entries + count; ++entry) {
    list.append(nb::make_tuple(entry->cost, entry->violation, entry->merit, entry->radius, entry->accepted, entry->rows,
                               entry->qp_iterations, work_of(entry->work)));
  }
  return list;
}

// Ending, point, radius and failures so far.
auto descend_from(Program& program, const SharedPoint& from, const std::vector<double>& region, int failures,
                  const Options& options, const nb::callable& ask, const nb::callable& tell, double seconds,
                  std::int64_t configurations) {
  expect(region.size() == 7, "seven numbers of the trust region");
  Descent descent{from, {region[0], region[1], region[2], region[3], region[4], region[5], region[6]}, failures, {}};
  const Watch watch{[&](const Entry* entries, std::size_t count) {
                      const gil::Taken lock;
                      gil::call(tell, told(entries, count));
                    },
                    seconds, configurations};
  const auto outside = asking(program, ask);
  Ending ending;
  {
    gil::Released released;
    ending = descend(program, descent, options, outside, watch);
  }
  return std::make_tuple(static_cast<int>(ending), std::const_pointer_cast<Point>(descent.at), descent.region.radius,
                         descent.failures);
}

// Rows of one part at a point, copied out as they are asked for. What is the same at every point is empty.
struct MadeRows {
  SharedPoint point;
  const Rows& rows;
  std::size_t joints;

  std::size_t made() const { return rows.new_jacobian.empty() ? 0 : rows.value.size(); }
  std::size_t stencil() const { return rows.stencil; }
};

MadeRows rows_of(const Program& program, const SharedPoint& point, std::size_t part) {
  expect(part < point->rows.size(), "a known part");
  return {point, point->rows[part], static_cast<std::size_t>(program.variables().joints)};
}

template <class T>
auto line(std::vector<T> Rows::* numbers) {
  return [numbers](const MadeRows& made) { return hand_over(made.rows.*numbers, {(made.rows.*numbers).size()}); };
}

}  // namespace

NB_MODULE(descent, m) {
  leaks::settle();
  nb::class_<robot::RobotQuery>(m, "RobotQuery");
  nb::class_<robot::RobotDynamics>(m, "RobotDynamics");
  bind_frame_terms(m);
  nb::enum_<Kind>(m, "Kind")
      .value("SQUARED", Kind::kSquared)
      .value("ABSOLUTE", Kind::kAbsolute)
      .value("HINGE", Kind::kHinge);
  nb::class_<Role>(m, "Role");
  m.def("cost", &cost, "kind"_a, "weight"_a);
  m.def("bounds", &bounds, "lower"_a, "upper"_a, "tolerance"_a);
  nb::class_<Margins>(m, "Margins")
      .def("__init__", [](Margins* made, const Vector<double>& full) { new (made) Margins{copied(full), {}, {}, {}, {}, {}, {}, {}}; }, "full"_a)
      .def("__call__", [](const Margins& margins, std::size_t pair, double place) { return margins(pair, place); },
           "pair"_a, "place"_a);
  m.def("tapered", &tapered, nb::kw_only(), "full"_a, "required"_a, "at_start"_a, "at_end"_a, "contact_until"_a,
        "contact_from"_a, "depth"_a, "gives"_a, "last"_a, "taper"_a, "share"_a);
  nb::class_<Point>(m, "Point")
      .def_ro("cost", &Point::cost)
      .def_ro("violation", &Point::violation)
      .def_ro("feasible", &Point::feasible)
      .def_prop_ro("kept", [](const Point& point) {
        return point.kept ? nb::borrow(static_cast<PyObject*>(const_cast<void*>(point.kept.get()))) : nb::none();
      })
      .def_prop_ro("x", [](const Point& point) { return hand_over(point.x, {point.x.size()}); }, kOwned);
  nb::class_<MadeRows>(m, "MadeRows")
      .def_prop_ro("value", line(&Rows::value), kOwned)
      .def_prop_ro("jacobian",
                   [](const MadeRows& made) {
                     return hand_over(made.rows.new_jacobian, {made.made(), made.stencil(), made.joints});
                   },
                   kOwned)
      .def_prop_ro("knots",
                   [](const MadeRows& made) { return hand_over(made.rows.new_knot, {made.made(), made.stencil()}); },
                   kOwned)
      .def_prop_ro("component", line(&Rows::component), kOwned)
      .def_prop_ro("place", line(&Rows::place), kOwned)
      .def_prop_ro("weight", line(&Rows::new_weight), kOwned)
      .def_prop_ro("lower", line(&Rows::new_lower), kOwned)
      .def_prop_ro("upper", line(&Rows::new_upper), kOwned);
  nb::class_<Options>(m, "Options")
      .def("__init__",
           [](Options* made, double penalty, double relative_gain, double absolute_gain, double accuracy,
              double regularisation, int qp_iterations, int steps, int failures, bool until_feasible, int window,
              std::vector<double> violations) {
             new (made) Options{penalty,       relative_gain, absolute_gain, accuracy,       regularisation,
                                qp_iterations, steps,         failures,      until_feasible, window,
                                std::move(violations)};
           },
           nb::kw_only(), "penalty"_a, "relative_gain"_a, "absolute_gain"_a, "accuracy"_a, "regularisation"_a,
           "qp_iterations"_a, "steps"_a, "failures"_a, "until_feasible"_a, "window"_a, "violations"_a);
  auto program = nb::class_<Program>(m, "Program");
  program
      .def("__init__", &make_program, "lower"_a, "upper"_a, "scale"_a, "query"_a, nb::keep_alive<1, 5>())
      .def("add_linear", &add_linear, "role"_a, "constant"_a, "jacobian"_a, "knots"_a)
      .def("add_distances", &add_distances, "role"_a, "knots"_a, "weight"_a, "place"_a, "reach"_a, "factor"_a, "margins"_a)
      .def("add_frames", &add_frames, "role"_a, "knots"_a, "weight"_a, "place"_a, "view"_a, "term"_a, "configurations"_a)
      .def("add_outside", &add_outside, "role"_a)
      .def("at", &point_at, "x"_a, "ask"_a)
      .def("rows", &rows_of, "point"_a, "part"_a)
      .def("descend", &descend_from, "start"_a, "region"_a, "failures"_a, "options"_a, "ask"_a, "tell"_a, "seconds"_a,
           "configurations"_a)
      .def_prop_ro("work", [](const Program& program) { return work_of(program.work()); });
  bind_what_changes(program);
}
