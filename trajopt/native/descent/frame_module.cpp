// Binding of the terms of frames.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "../arrays.hpp"
#include "frame_terms.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace descent;
using arrays::expect, arrays::Matrix, arrays::Vector;

namespace {

Vector3 vector_of(const Vector<double>& numbers) {
  expect(numbers.size() == 3, "three numbers");
  return Eigen::Map<const Vector3>(numbers.data());
}

Matrix3 matrix_of(const Matrix<double>& numbers) {
  expect(numbers.shape(0) == 3 && numbers.shape(1) == 3, "three rows of three numbers");
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data());
}

void make_view(robot::View* made, int joint, const Matrix<double>& rotation, const Vector<double>& point, int base,
               const Matrix<double>& base_rotation, const Vector<double>& base_origin) {
  new (made) robot::View{joint, base, matrix_of(rotation), matrix_of(base_rotation), vector_of(point), vector_of(base_origin)};
}

// A term with what its members are set to.
template <class Term, class Set>
std::shared_ptr<FrameTerm> term_with(Set&& set) {
  auto term = std::make_shared<Term>();
  set(*term);
  return term;
}

auto axis_angle(const Vector<double>& axis, const Vector<double>& direction, const Vector<double>& across) {
  return term_with<AxisAngle>([&](AxisAngle& term) {
    term.axis = vector_of(axis), term.direction = vector_of(direction), term.across = vector_of(across);
  });
}

auto frame_placement(const Matrix<double>& rotation, const Vector<double>& translation, bool euler) {
  return term_with<FramePlacement>([&](FramePlacement& term) {
    term.rotation = matrix_of(rotation), term.translation = vector_of(translation), term.euler = euler;
  });
}

auto point_distance(const Vector<double>& from) {
  return term_with<PointDistance>([&](PointDistance& term) { term.from = vector_of(from); });
}

auto view_angle(const Vector<double>& origin, const Vector<double>& axis, const Vector<double>& across) {
  return term_with<ViewAngle>([&](ViewAngle& term) {
    term.origin = vector_of(origin), term.axis = vector_of(axis), term.across = vector_of(across);
  });
}

auto view_distance(const Vector<double>& origin) {
  return term_with<ViewDistance>([&](ViewDistance& term) { term.origin = vector_of(origin); });
}

using Member = std::tuple<Shape, Vector<double>, Matrix<double>, Vector<double>>;

auto region(const std::vector<Member>& members) {
  expect(!members.empty(), "at least one member");
  return term_with<PointInRegion>([&](PointInRegion& term) {
    for (const auto& [shape, size, rotation, translation] : members) {
      term.members.push_back({shape, vector_of(size), matrix_of(rotation), vector_of(translation)});
    }
  });
}

}  // namespace

void bind_frame_terms(nb::module_& m) {
  nb::class_<robot::View>(m, "View")
      .def("__init__", &make_view, nb::kw_only(), "joint"_a, "rotation"_a, "point"_a, "base"_a, "base_rotation"_a,
           "base_origin"_a);
  nb::enum_<Shape>(m, "Shape")
      .value("BOX", Shape::kBox)
      .value("SPHERE", Shape::kSphere)
      .value("CYLINDER", Shape::kCylinder)
      .value("HALF_SPACE", Shape::kHalfSpace);
  nb::class_<FrameTerm>(m, "FrameTerm").def_prop_ro("components", &FrameTerm::components);
  m.def("axis_angle", &axis_angle, "axis"_a, "direction"_a, "across"_a);
  m.def("frame_placement", &frame_placement, "rotation"_a, "translation"_a, "euler"_a);
  m.def("point_distance", &point_distance, "point"_a);
  m.def("view_angle", &view_angle, "origin"_a, "axis"_a, "across"_a);
  m.def("view_distance", &view_distance, "origin"_a);
  m.def("region", &region, "members"_a);
}
