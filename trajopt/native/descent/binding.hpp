// What Python hands to programs, checked and copied.
#pragma once

#include <algorithm>

#include "../arrays.hpp"
#include "points.hpp"

namespace descent {

using arrays::expect, arrays::Matrix, arrays::Vector;

template <class Array>
auto copied(const Array& array) {
  return std::vector<std::remove_const_t<typename Array::Scalar>>(array.data(), array.data() + array.size());
}

// Not one more or less than the loops believe, or one for all.
inline void expect_numbers(const Role& role, std::size_t count, bool one_for_all) {
  const auto fits = [&](const std::vector<double>& numbers) {
    return numbers.size() == count || (one_for_all && numbers.size() == 1);
  };
  expect(role.bounded() ? fits(role.lower) && fits(role.upper) : fits(role.weight), "a weight or bounds for each row");
}

inline void expect_knots(const Program& program, const Matrix<std::int64_t>& knots) {
  const auto known = [&](std::int64_t knot) { return 0 <= knot && knot < program.variables().knots(); };
  expect(std::all_of(knots.data(), knots.data() + knots.size(), known), "known knots");
}

inline Samples samples_of(const Program& program, const Matrix<std::int64_t>& knots, const Matrix<double>& weight,
                   const Vector<double>& place) {
  const std::size_t samples = place.shape(0);
  expect(knots.shape(0) == samples && weight.shape(0) == samples && weight.shape(1) == knots.shape(1),
         "knots and weights for each sample");
  expect_knots(program, knots);
  return {static_cast<int>(knots.shape(1)), copied(knots), copied(weight), copied(place)};
}

}  // namespace descent
