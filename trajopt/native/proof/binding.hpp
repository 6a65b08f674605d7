// What the files that bind the judge's core share: arrays of Python, read in place and handed over.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <stdexcept>
#include <vector>

#include "curve.hpp"
#include "pose.hpp"

namespace proof {

namespace nb = nanobind;

using Numbers = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Counts = nb::ndarray<const int64_t, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<const bool, nb::c_contig, nb::device::cpu>;
using Array = nb::ndarray<nb::numpy, double>;

inline Array array(std::vector<double> values, std::initializer_list<size_t> shape) {
  auto* kept = new std::vector<double>(std::move(values));
  nb::capsule owner(kept, [](void* at) noexcept { delete static_cast<std::vector<double>*>(at); });
  return Array(kept->data(), shape, owner);
}

inline Array array(std::vector<double> values) {
  const size_t count = values.size();
  return array(std::move(values), {count});
}

inline std::vector<double> numbers(const Numbers& given) { return {given.data(), given.data() + given.size()}; }

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

inline Mat matrix(const double* rows) { return Eigen::Map<const RowMajor>(rows); }
inline Vec vector(const double* values) { return Eigen::Map<const Vec>(values); }

inline Curve make_curve(const Numbers& times, const Numbers& coefficients) {
  Curve curve;
  curve.times = numbers(times);
  curve.coefficients = numbers(coefficients);
  curve.degree = int(coefficients.shape(0)) - 1;
  curve.functions = int(coefficients.shape(2));
  if (curve.degree > Curve::highest_degree) throw std::invalid_argument("the degree is too high");
  return curve;
}

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

inline Rows rows_of(const Numbers& matrix) {
  return Eigen::Map<const Rows>(matrix.data(), Eigen::Index(matrix.shape(0)), Eigen::Index(matrix.shape(1)));
}

// Bind what is known of polynomials of time, and of the torques that they need.
void bind_curves(nb::module_& m);

}  // namespace proof
