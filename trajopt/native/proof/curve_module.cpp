// Bindings of polynomials of time: their extremes and values, limits, and the torques that they need.
#include "../gil.hpp"
#include "binding.hpp"
#include "dynamics.hpp"
#include "loads.hpp"

namespace proof {

namespace {

nb::tuple largest(const Numbers& times, const Numbers& coefficients, double sign, double slack) {
  const Curve curve = make_curve(times, coefficients);
  std::vector<double> values(size_t(curve.functions)), when(size_t(curve.functions));
  {
    gil::Released released;
    for (int f = 0; f < curve.functions; ++f) curve.largest(f, sign, slack, values[f], when[f]);
  }
  return nb::make_tuple(array(std::move(values)), array(std::move(when)));
}

// Smallest and largest control values of all functions over intervals, one row each.
nb::tuple ranges(const Numbers& times, const Numbers& coefficients, const Numbers& begin, const Numbers& end) {
  const Curve curve = make_curve(times, coefficients);
  const size_t count = begin.size(), functions = size_t(curve.functions);
  std::vector<double> low(count * functions), high(count * functions);
  {
    gil::Released released;
    for (size_t i = 0; i < count; ++i) {
      curve.range(begin.data()[i], end.data()[i], low.data() + i * functions, high.data() + i * functions);
    }
  }
  return nb::make_tuple(array(std::move(low), {count, functions}), array(std::move(high), {count, functions}));
}

// Largest speed of any of the functions `matrix @ f` in each piece.
Array speeds(const Numbers& times, const Numbers& coefficients, const Numbers& matrix) {
  const Curve velocity = make_curve(times, coefficients).derivative();
  const Rows spread = rows_of(matrix).cwiseAbs();
  std::vector<double> found(size_t(velocity.pieces()));
  {
    gil::Released released;
    Eigen::VectorXd low(velocity.functions), high(velocity.functions);
    for (int piece = 0; piece < velocity.pieces(); ++piece) {
      velocity.range(velocity.times[piece], velocity.times[piece + 1], low.data(), high.data());
      found[piece] = (spread * high.cwiseMax(-low)).maxCoeff();
    }
  }
  return array(std::move(found));
}

// Functions and others, over the times of the first.
nb::tuple beside(const Numbers& times, const Numbers& coefficients, const Numbers& other_times,
                 const Numbers& other_coefficients) {
  Curve curve = make_curve(times, coefficients).beside(make_curve(other_times, other_coefficients));
  const size_t rows = size_t(curve.degree) + 1, pieces = size_t(curve.pieces()), functions = size_t(curve.functions);
  return nb::make_tuple(array(std::move(curve.times)), array(std::move(curve.coefficients), {rows, pieces, functions}));
}

// Values of all functions at times counted from the start of a piece, one row each.
Array sampled(const Numbers& coefficients, const Counts& piece, const Numbers& local) {
  const size_t rows = coefficients.shape(0), pieces = coefficients.shape(1), functions = coefficients.shape(2);
  std::vector<double> found(piece.size() * functions, 0.0);
  {
    gil::Released released;
    for (size_t i = 0; i < piece.size(); ++i) {
      double* values = found.data() + i * functions;
      const double* of = coefficients.data() + size_t(piece.data()[i]) * functions;
      for (size_t row = 0; row < rows; ++row, of += pieces * functions) {
        for (size_t f = 0; f < functions; ++f) values[f] = values[f] * local.data()[i] + of[f];
      }
    }
  }
  return array(std::move(found), {piece.size(), functions});
}

// One number of each joint, the world first: masses, centres, inertias and armatures.
Dynamics make_dynamics(const Arm& arm, const Numbers& mass, const Numbers& centre, const Numbers& inertia,
                       const Numbers& armature, const Numbers& gravity) {
  std::vector<Mass> masses;
  for (size_t i = 0; i < mass.size(); ++i) {
    masses.push_back({mass.data()[i], vector(centre.data() + 3 * i), matrix(inertia.data() + 9 * i), armature.data()[i]});
  }
  return Dynamics(arm, masses, vector(gravity.data()));
}

Array torques(const Dynamics& dynamics, const Numbers& q, const Numbers& v, const Numbers& a) {
  const size_t rows = v.shape(0), columns = v.shape(1);
  if (columns != dynamics.joints()) throw std::invalid_argument("there must be one number for each joint");
  std::vector<double> found(rows * columns);
  {
    gil::Released released;
    dynamics.torques(rows, q.data(), v.data(), a.data(), found.data());
  }
  return array(std::move(found), {rows, columns});
}

double share(const Dynamics& dynamics, const Numbers& times, const Numbers& coefficients, const Counts& steps,
             double rounding, const Numbers& rests, const Numbers& expand, const Numbers& offset,
             const Numbers& effort) {
  if (expand.shape(0) != dynamics.joints()) throw std::invalid_argument("there must be one number for each joint");
  const Curve position = make_curve(times, coefficients);
  const Samples samples{steps.data(), rounding, rests.data(), rests.shape(0)};
  gil::Released released;
  return largest_share(dynamics, position, samples, rows_of(expand),
                       Eigen::Map<const Eigen::VectorXd>(offset.data(), Eigen::Index(offset.size())), effort.data());
}

// Whether functions and their derivatives keep within bounds, one row of these for each order, and jumps of the second
// derivative, from what it is before, to the rest after, within others; where none of these are given there are none.
bool limits_hold(const Numbers& times, const Numbers& coefficients, const Numbers& low, const Numbers& high,
                 const Numbers& before, const Numbers& most, bool rests_after) {
  Curve curve = make_curve(times, coefficients);
  const size_t joints = size_t(curve.functions);
  gil::Released released;
  for (size_t order = 0; order < low.shape(0); ++order, curve = curve.derivative()) {
    if (!curve.within(low.data() + order * joints, high.data() + order * joints)) return false;
    if (order == 2 && most.size() > 0 && !curve.jumps_within(before.data(), rests_after, most.data())) return false;
  }
  return true;
}

}  // namespace

void bind_curves(nb::module_& m) {
  m.def("largest", &largest);
  m.def("ranges", &ranges);
  m.def("speeds", &speeds);
  m.def("beside", &beside);
  m.def("sampled", &sampled);
  m.def("limits_hold", &limits_hold);
  nb::class_<Dynamics>(m, "Dynamics").def("torques", &torques).def("share", &share);
  m.def("dynamics", &make_dynamics);
}

}  // namespace proof
