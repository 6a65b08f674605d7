// Binding of the core that places a robot, finds what it is near to, and what its joints must hold.
//
// Pinocchio's model and Coal's geometries are the very objects that Python made: boost.python hands out the C++
// objects inside, so nothing of a robot's description is copied or built twice.
#include <boost/python/extract.hpp>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>

#include "../arrays.hpp"
#include "../coal_boxes.hpp"
#include "../gil.hpp"
#include "../leaks.hpp"
#include "cloud_cover.hpp"
#include "dynamics.hpp"
#include "path_search.hpp"
#include "query.hpp"

namespace nb = nanobind;
namespace bp = boost::python;
using namespace nb::literals;
using namespace proximity;
using arrays::Block, arrays::expect, arrays::hand_over, arrays::Matrix, arrays::Numpy, arrays::Vector;

namespace {

template <class T>
T inside(const nb::handle& object, const char* what) {
  bp::extract<T> extract(object.ptr());
  if (!extract.check()) throw nb::type_error(what);
  return extract();
}

Vector3 vector_at(const Matrix<double>& values, size_t row) {
  return Eigen::Map<const Vector3>(values.data() + 3 * row);
}

Robot make_robot(const nb::object& model, const Matrix<double>& expand, const Vector<double>& offset) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  expect(expand.shape(0) == offset.shape(0), "as many offsets as model joints");
  const pinocchio::Model* handed = pinocchio_model(model.ptr());
  if (handed == nullptr) throw nb::type_error("not a pinocchio model");
  return Robot(*handed,
               Eigen::Map<const RowMajor>(expand.data(), expand.shape(0), expand.shape(1)),
               Eigen::Map<const Eigen::VectorXd>(offset.data(), offset.shape(0)));
}

void make_dynamics(Dynamics* made, const nb::object& model, const Matrix<double>& expand, const Vector<double>& offset) {
  new (made) Dynamics(make_robot(model, expand, offset));
}

Solid* make_solid(const Matrix<double>& points, const Block<double>& closed, const nb::object& geometry,
                  const Matrix<double>& cloud) {
  expect(points.shape(1) == 3 && cloud.shape(1) == 3 && closed.shape(1) == 3 && closed.shape(2) == 3, "points and triangles in space");
  std::vector<Vector3> inner;
  std::vector<Solid::Triangle> shell;
  for (size_t i = 0; i < points.shape(0); ++i) inner.push_back(vector_at(points, i));
  for (size_t i = 0; i < closed.shape(0); ++i) {
    const Eigen::Map<const Eigen::Matrix3d> corners(closed.data() + 9 * i);
    shell.push_back({corners.col(0), corners.col(1), corners.col(2)});
  }
  const auto shape = inside<std::shared_ptr<coal::CollisionGeometry>>(geometry, "not a Coal geometry");
  const auto* convex = dynamic_cast<const coal::ConvexBase*>(shape.get());
  std::vector<Vector3> centres(cloud.shape(0));
  for (size_t i = 0; i < centres.size(); ++i) centres[i] = vector_at(cloud, i);
  return new Solid(std::move(inner), std::move(shell), convex == nullptr ? nullptr : std::make_unique<const Polytope>(*convex),
                   std::move(centres));
}

// One ball or cube of a cloud, about its origin.
std::shared_ptr<const Body> make_element(const std::shared_ptr<const coal::CollisionGeometry>& geometry,
                                         const std::shared_ptr<const Solid>& solid, const Support& support) {
  const Vector3 half = (geometry->aabb_local.max_ - geometry->aabb_local.min_) / 2.0;
  return std::make_shared<const Body>(
      Body{0, Matrix3::Identity(), Vector3::Zero(), Vector3::Zero(), half, half.norm(), geometry, solid, support, Vector3::Zero(), nullptr});
}

void make_cell(Cell* made, const nb::object& model, const Matrix<double>& expand, const Vector<double>& offset,
               const nb::list& geometries, const nb::list& solids, const Vector<std::int64_t>& joint, const Block<double>& rotation,
               const Matrix<double>& translation, const Matrix<double>& centre, const Matrix<double>& half,
               const Vector<std::int64_t>& first, const Vector<std::int64_t>& second,
               const std::tuple<double, double, double>& accuracy) {
  using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  Robot robot = make_robot(model, expand, offset);
  const size_t count = nb::len(geometries);
  expect(nb::len(solids) == count && joint.shape(0) == count && rotation.shape(0) == count && translation.shape(0) == count &&
             centre.shape(0) == count && half.shape(0) == count,
         "as many solids, joints, placements and boxes as geometries");
  expect(first.shape(0) == second.shape(0), "two bodies for each pair");
  std::vector<Body> bodies;
  for (size_t i = 0; i < count; ++i) {
    const Vector3 box = vector_at(half, i);
    auto geometry = inside<std::shared_ptr<coal::CollisionGeometry>>(geometries[i], "not a Coal geometry");
    auto solid = nb::cast<std::shared_ptr<Solid>>(solids[i]);
    const Support support = Support::of(*geometry, solid->polytope());
    const Matrix3 turn = Eigen::Map<const Rotation>(rotation.data() + 9 * i);
    const Vector3 shift = vector_at(translation, i), around = vector_at(centre, i);
    const Vector3 middle = turn.transpose() * (around - shift);
    const bool cloud = !solid->cloud().empty();
    auto element = cloud ? make_element(geometry, solid, support) : nullptr;
    bodies.push_back({static_cast<int>(joint(i)), turn, shift, around, box, box.norm(), std::move(geometry), std::move(solid),
                      cloud ? Support() : support, middle, std::move(element)});
  }
  std::vector<Pair> pairs;
  for (size_t i = 0; i < first.shape(0); ++i) {
    expect(static_cast<size_t>(first(i)) < count && static_cast<size_t>(second(i)) < count, "pairs of known bodies");
    pairs.push_back({static_cast<int>(first(i)), static_cast<int>(second(i))});
  }
  const auto [gjk, epa, epa_again] = accuracy;
  new (made) Cell(std::move(robot), std::move(bodies), std::move(pairs), {gjk, epa, epa_again});
}

void expect_positions(const Query& query, const Matrix<double>& positions) {
  expect(static_cast<int>(positions.shape(1)) == query.cell.robot.dofs(), "one position for each joint of the group");
}

template <class Values>
std::vector<double> copied(const Values& values) {
  return {values.data(), values.data() + values.size()};
}

// Rows of close pairs: sample, pair, distance, normal, point on the first body, on the second, Jacobian row.
auto close_pairs(Query& query, const Matrix<double>& positions, const Vector<double>& reach, const Vector<double>& aim) {
  expect_positions(query, positions);
  for (const auto* each : {&reach, &aim}) {
    expect(static_cast<int>(each->shape(0)) == query.pairs(), "one reach and one aim for each pair");
  }
  ClosePairs found;
  {
    gil::Released released;
    found = query.close_pairs(positions.data(), static_cast<int>(positions.shape(0)), copied(reach), copied(aim));
  }
  const size_t count = found.pair.size();
  const size_t dofs = query.cell.robot.dofs();
  return std::make_tuple(hand_over(std::move(found.sample), {count}), hand_over(std::move(found.pair), {count}),
                         hand_over(std::move(found.distance), {count}), hand_over(std::move(found.normal), {count, 3}),
                         hand_over(std::move(found.first), {count, 3}), hand_over(std::move(found.second), {count, 3}),
                         hand_over(std::move(found.jacobian), {count, dofs}));
}

void make_query_for(Query* made, const Cell& cell, const Vector<std::int64_t>& stands_for, int count) {
  expect(stands_for.shape(0) == cell.pairs.size(), "one number for each pair");
  for (size_t pair = 0; pair < stands_for.shape(0); ++pair) {
    expect(stands_for(pair) >= 0 && stands_for(pair) < count, "pairs that are asked about");
  }
  new (made) Query(cell, {stands_for.data(), stands_for.data() + stands_for.shape(0)}, count);
}

void make_cover(CloudCover* made, const Solid& solid, double cell, std::int64_t most) {
  expect(!solid.cloud().empty() && cell > 0.0 && most > 0, "a cloud, and cells to cut it into");
  gil::Released released;
  new (made) CloudCover(solid.cloud(), cell, static_cast<size_t>(most));
}

std::vector<char> marked(const CloudCover& cover, const Vector<std::int64_t>& chosen) {
  std::vector<char> taken(cover.pieces().size(), 0);
  for (size_t at = 0; at < chosen.shape(0); ++at) {
    expect(chosen(at) >= 0 && chosen(at) < static_cast<std::int64_t>(taken.size()), "pieces of the cover");
    taken[chosen(at)] = 1;
  }
  return taken;
}

CloudCover cut(const CloudCover& cover, const Solid& solid, const Vector<std::int64_t>& chosen, double edge, int parts) {
  expect(edge > 0.0 && parts > 0, "parts of some size");
  return cover.cut(solid.cloud(), marked(cover, chosen), edge, parts);
}

// Lower and upper corners of the pieces along the cover's axes.
auto pieces(const CloudCover& cover) {
  std::vector<double> low, high;
  for (const CloudCover::Piece& piece : cover.pieces()) {
    low.insert(low.end(), piece.low.data(), piece.low.data() + 3);
    high.insert(high.end(), piece.high.data(), piece.high.data() + 3);
  }
  const size_t count = cover.pieces().size();
  return std::make_tuple(hand_over(std::move(low), {count, 3}), hand_over(std::move(high), {count, 3}));
}

// Columns: the cover's axes in the cloud's frame.
Numpy<double> axes(const CloudCover& cover) {
  const Matrix3 transposed = cover.axes().transpose();
  return hand_over(std::vector<double>(transposed.data(), transposed.data() + 9), {3, 3});
}

Numpy<double> points_within(const CloudCover& cover, const Solid& solid, const Vector<std::int64_t>& chosen) {
  std::vector<double> points;
  for (const Vector3& point : cover.within(solid.cloud(), marked(cover, chosen))) points.insert(points.end(), point.data(), point.data() + 3);
  const size_t count = points.size() / 3;
  return hand_over(std::move(points), {count, 3});
}

// Rotations and translations of all joints, and the velocity of each at the world's origin at unit speed.
auto placements(Query& query, const Matrix<double>& positions) {
  expect_positions(query, positions);
  const Robot& robot = query.cell.robot;
  const size_t samples = positions.shape(0), joints = robot.joints(), columns = robot.columns();
  std::vector<double> rotation(samples * joints * 9), translation(samples * joints * 3);
  std::vector<double> jacobian(samples * 6 * columns);
  {
    gil::Released released;
    for (size_t sample = 0; sample < samples; ++sample) {
      const auto& placed = query.kinematics(positions.data() + sample * positions.shape(1));
      double* columns_here = jacobian.data() + sample * 6 * columns;
      for (size_t joint = 0; joint < joints; ++joint) {
        const auto& frame = placed[joint];
        const size_t row = sample * joints + joint;
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data() + 9 * row) = frame.rotation();
        Eigen::Map<Vector3>(translation.data() + 3 * row) = frame.translation();
        if (joint == 0) continue;
        const auto velocity = frame.act(robot.axis[joint]).toVector();
        const int column = robot.column(static_cast<int>(joint));
        for (int part = 0; part < 6; ++part) columns_here[part * columns + column] = velocity[part];
      }
    }
  }
  return std::make_tuple(hand_over(std::move(rotation), {samples, joints, 3, 3}),
                         hand_over(std::move(translation), {samples, joints, 3}),
                         hand_over(std::move(jacobian), {samples, 6, columns}));
}

// The largest motion bound of any moving body between two configurations, for each two of many.
Numpy<double> displacement(Query& query, const Matrix<double>& from, const Matrix<double>& to) {
  expect_positions(query, from);
  expect_positions(query, to);
  expect(from.shape(0) == to.shape(0), "as many ends as starts");
  const Cell& cell = query.cell;
  const size_t samples = from.shape(0), dofs = from.shape(1);
  std::vector<double> largest(samples, 0.0);
  {
    gil::Released released;
    std::vector<Place> before(cell.bodies.size());
    const auto carried = [&](auto&& act) {
      for (size_t body = 0; body < cell.bodies.size(); ++body) {
        if (cell.bodies[body].joint > 0 && cell.bodies[body].radius < Obstacles::kUnbounded) act(body);
      }
    };
    for (size_t sample = 0; sample < samples; ++sample) {
      const auto& first = query.kinematics(from.data() + sample * dofs);
      carried([&](size_t body) { before[body] = place(cell.bodies[body], first[cell.bodies[body].joint]); });
      const auto& second = query.kinematics(to.data() + sample * dofs);
      carried([&](size_t body) {
        const Place now = place(cell.bodies[body], second[cell.bodies[body].joint]);
        largest[sample] = std::max(largest[sample], motion(cell.bodies[body], before[body], now));
      });
    }
  }
  return hand_over(std::move(largest), {samples});
}

// Corners of a path that is clear, whether the search was exhausted, and what was looked at: configurations, bounds, distances.
auto search_path(const Cell& cell, const Vector<double>& start, const Matrix<double>& goals, const Vector<double>& lower,
           const Vector<double>& upper, const Vector<double>& unit, const Vector<double>& reach, double step,
           std::int64_t looks, std::int64_t shortening, std::uint64_t seed, const nb::callable& check) {
  const size_t dofs = cell.robot.dofs();
  for (const auto* each : {&start, &lower, &upper, &unit}) expect(each->shape(0) == dofs, "one number for each joint of the group");
  expect(goals.shape(1) == dofs, "one position for each joint of the group");
  expect(reach.shape(0) == cell.pairs.size(), "one reach for each pair");
  const PathRequest asked{copied(start), copied(goals), copied(lower), copied(upper), copied(unit),
                           copied(reach), step,          looks,         shortening,    seed};
  const auto ask = [&](std::int64_t looked) {
    const gil::Taken lock;
    gil::call(check, looked);
  };
  FoundPath found;
  {
    gil::Released released;
    found = PathSearch(cell, asked, ask)();
  }
  const size_t corners = found.corners.size() / dofs;
  return std::make_tuple(hand_over(std::move(found.corners), {corners, dofs}), found.exhausted, found.looked,
                         found.work.bounds, found.work.distances);
}

// Torques of the group's joints at as many states.
Numpy<double> torques(Dynamics& dynamics, const Matrix<double>& positions, const Matrix<double>& velocities,
                      const Matrix<double>& accelerations) {
  const size_t states = positions.shape(0), dofs = dynamics.dofs();
  for (const auto* rows : {&positions, &velocities, &accelerations}) {
    expect(rows->shape(0) == states && rows->shape(1) == dofs, "one number for each state and joint of the group");
  }
  std::vector<double> result(states * dofs);
  {
    gil::Released released;
    for (size_t at = 0; at < result.size(); at += dofs) {
      dynamics.torques(positions.data() + at, velocities.data() + at, accelerations.data() + at, result.data() + at);
    }
  }
  return hand_over(std::move(result), {states, dofs});
}

// Their derivatives by positions, velocities and accelerations.
auto slopes(Dynamics& dynamics, const Matrix<double>& positions, const Matrix<double>& velocities,
            const Matrix<double>& accelerations) {
  const size_t states = positions.shape(0), dofs = dynamics.dofs();
  for (const auto* rows : {&positions, &velocities, &accelerations}) {
    expect(rows->shape(0) == states && rows->shape(1) == dofs, "one number for each state and joint of the group");
  }
  std::vector<double> by_position(states * dofs * dofs), by_velocity(by_position), by_acceleration(by_position);
  {
    gil::Released released;
    for (size_t state = 0; state < states; ++state) {
      const size_t at = state * dofs, row = at * dofs;
      dynamics.slopes(positions.data() + at, velocities.data() + at, accelerations.data() + at, by_position.data() + row,
                      by_velocity.data() + row, by_acceleration.data() + row);
    }
  }
  const auto made = [&](std::vector<double>& numbers) { return hand_over(std::move(numbers), {states, dofs, dofs}); };
  return std::make_tuple(made(by_position), made(by_velocity), made(by_acceleration));
}

std::tuple<Numpy<double>, Numpy<double>> gravity(Dynamics& dynamics, const Matrix<double>& positions) {
  const size_t states = positions.shape(0), dofs = dynamics.dofs();
  expect(positions.shape(1) == dofs, "one position for each joint of the group");
  std::vector<double> torques(states * dofs), slopes(states * dofs * dofs);
  {
    gil::Released released;
    for (size_t at = 0; at < torques.size(); at += dofs) {
      dynamics.gravity(positions.data() + at, torques.data() + at, slopes.data() + at * dofs);
    }
  }
  return {hand_over(std::move(torques), {states, dofs}), hand_over(std::move(slopes), {states, dofs, dofs})};
}

}  // namespace

NB_MODULE(proximity, m) {
  leaks::settle();
  coal_boxes::settle();
  nb::module_::import_("trajopt.native.descent");  // which knows what a RobotQuery is
  nb::class_<Solid>(m, "Solid").def(nb::new_(&make_solid), "points"_a, "closed"_a, "geometry"_a, "cloud"_a);
  nb::class_<CloudCover>(m, "CloudCover")
      .def("__init__", &make_cover, "solid"_a, "cell"_a, "most"_a)
      .def("axes", &axes)
      .def("pieces", &pieces)
      .def("cut", &cut, "solid"_a, "chosen"_a, "edge"_a, "parts"_a)
      .def("points_within", &points_within, "solid"_a, "chosen"_a);
  nb::class_<Cell>(m, "Cell").def("__init__", &make_cell, "model"_a, "expand"_a, "offset"_a, "geometries"_a, "solids"_a,
                                  "joint"_a, "rotation"_a, "translation"_a, "centre"_a, "half"_a, "first"_a, "second"_a,
                                  "accuracy"_a, nb::keep_alive<1, 2>());
  m.def("search_path", &search_path, "cell"_a, "start"_a, "goals"_a, "lower"_a, "upper"_a, "unit"_a, "reach"_a, "step"_a, "looks"_a,
        "shortening"_a, "seed"_a, "check"_a);
  nb::class_<Dynamics, robot::RobotDynamics>(m, "Dynamics")
      .def("__init__", &make_dynamics, "model"_a, "expand"_a, "offset"_a, nb::keep_alive<1, 2>())
      .def("torques", &torques, "positions"_a, "velocities"_a, "accelerations"_a)
      .def("slopes", &slopes, "positions"_a, "velocities"_a, "accelerations"_a)
      .def("gravity", &gravity, "positions"_a);
  nb::class_<Query, robot::RobotQuery>(m, "Query")
      .def(nb::init<const Cell&>(), "cell"_a, nb::keep_alive<1, 2>())
      .def("__init__", &make_query_for, "cell"_a, "stands_for"_a, "count"_a, nb::keep_alive<1, 2>())
      .def("close_pairs", &close_pairs, "positions"_a, "reach"_a, "aim"_a)
      .def("placements", &placements, "positions"_a)
      .def("displacement", &displacement, "start"_a, "end"_a)
      .def("forget", [](Query& query) { query.tracker.forget(); })
      .def_prop_ro("bounds", [](const Query& query) { return query.tracker.work.bounds; })
      .def_prop_ro("distances", [](const Query& query) { return query.tracker.work.distances; });
}
