// What retiming does for every grid point and piece, on plain arrays: see passes.hpp, barrier.hpp, extremes.hpp.
#include <cstddef>
#include <initializer_list>
#include <stdexcept>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "barrier.hpp"
#include "extremes.hpp"
#include "passes.hpp"

namespace nb = nanobind;

namespace {

using Column = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Table = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Coefficients = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Array = nb::ndarray<nb::numpy, double>;

Array handed(std::vector<double>&& values, std::initializer_list<std::size_t> shape) {
  auto* kept = new std::vector<double>(std::move(values));
  nb::capsule owner(kept, [](void* made) noexcept { delete static_cast<std::vector<double>*>(made); });
  return Array(kept->data(), shape, owner);
}

Array fastest(const Column& distance, const Table& a, const Table& b, const Table& c, const Table& limit,
              const Column& bound) {
  const std::size_t points = a.shape(0), columns = a.shape(1);
  for (const Table* other : {&b, &c, &limit})
    if (other->shape(0) != points || other->shape(1) != columns)
      throw std::invalid_argument("a, b, c and limit must have one shape");
  if (distance.shape(0) != points || bound.shape(0) != points + 1)
    throw std::invalid_argument("distance must have as many rows as a, bound one more");
  std::vector<double> control;
  {
    nb::gil_scoped_release released;
    control = passes::fastest({distance.data(), a.data(), b.data(), c.data(), limit.data(), bound.data(), points,
                               columns});
  }
  return handed(std::move(control), {points + 1});
}

nb::tuple minimise(const Column& weight, const Column& bound, const Coefficients& rows, const Table& above,
                   const Table& below, const Table& jerk, const Coefficients& speed, const Column& z, double first_gap,
                   double gap) {
  const std::size_t blocks = rows.shape(0), linear = above.shape(1), jerks = jerk.shape(1);
  if (rows.shape(1) != linear + jerks || rows.shape(2) != 3 || jerks % 2 != 0 || below.shape(1) != linear ||
      speed.shape(1) != 2 || speed.shape(2) != 3)
    throw std::invalid_argument("rows must be (blocks, above's columns + jerk's, 3), speed (blocks, 2, 3)");
  for (const std::size_t rows_of : {above.shape(0), below.shape(0), jerk.shape(0), speed.shape(0)})
    if (rows_of != blocks) throw std::invalid_argument("tables must have a row for each block");
  for (const Column* column : {&weight, &bound, &z})
    if (column->shape(0) != blocks + 2) throw std::invalid_argument("columns must have two rows more than blocks");
  std::vector<double> found;
  int steps = 0;
  {
    nb::gil_scoped_release released;
    const barrier::Program program{weight.data(), bound.data(), rows.data(), above.data(), below.data(),
                                   jerk.data(),   speed.data(), blocks,      linear,       jerks};
    found = barrier::minimise(program, std::vector<double>(z.data(), z.data() + blocks + 2), first_gap, gap, steps);
  }
  const std::size_t count = found.size();
  return nb::make_tuple(handed(std::move(found), {count}), steps);
}

nb::tuple motion_extremes(const Coefficients& coefficients, const Column& widths) {
  const std::size_t pieces = coefficients.shape(1), joints = coefficients.shape(2), count = pieces * joints;
  if (coefficients.shape(0) != 6 || widths.shape(0) != pieces)
    throw std::invalid_argument("coefficients must be (6, pieces, joints), widths (pieces,)");
  std::vector<double> speed(count), low(count), high(count);
  {
    nb::gil_scoped_release released;
    for (std::size_t i = 0; i < count; ++i) {
      const auto found = extremes::of_piece(coefficients.data() + i, count, widths.data()[i / joints]);
      speed[i] = found.speed, low[i] = found.low, high[i] = found.high;
    }
  }
  return nb::make_tuple(handed(std::move(speed), {pieces, joints}), handed(std::move(low), {pieces, joints}),
                        handed(std::move(high), {pieces, joints}));
}

}  // namespace

NB_MODULE(reachability, m) {
  m.def("fastest", &fastest, nb::arg("distance"), nb::arg("a"), nb::arg("b"), nb::arg("c"), nb::arg("limit"),
        nb::arg("bound"));
  m.def("minimise", &minimise, nb::arg("weight"), nb::arg("bound"), nb::arg("rows"), nb::arg("above"),
        nb::arg("below"), nb::arg("jerk"), nb::arg("speed"), nb::arg("z"), nb::arg("first_gap"), nb::arg("gap"));
  m.def("motion_extremes", &motion_extremes, nb::arg("coefficients"), nb::arg("widths"));
}
