#include "interior_point.hpp"

#include <algorithm>
#include <cmath>

#include "../processors.hpp"

// The method is compiled for several kinds of processor, each with vectors as wide as its registers. What it needs of
// others comes before, compiled for all of them.
namespace banded {

namespace two_at_once {
constexpr int kWidth = 2;
#include "tiles.hpp"
// After what it is made of.
#include "method.hpp"
}  // namespace two_at_once

#ifdef SEVERAL_PROCESSORS
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v3")
namespace four_at_once {
constexpr int kWidth = 4;
#include "tiles.hpp"
// After what it is made of.
#include "method.hpp"
}  // namespace four_at_once
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4")
namespace eight_at_once {
constexpr int kWidth = 8;
#include "tiles.hpp"
// After what it is made of.
#include "method.hpp"
}  // namespace eight_at_once
#pragma GCC pop_options
#endif

namespace {

Solution from(const Program& program, const Eights& lower, const Eights& upper, const Options& options) {
#ifdef SEVERAL_PROCESSORS
  if (__builtin_cpu_supports("x86-64-v4")) return eight_at_once::InteriorPoint(program, lower, upper, options).solve();
  if (__builtin_cpu_supports("x86-64-v3")) return four_at_once::InteriorPoint(program, lower, upper, options).solve();
#endif
  return two_at_once::InteriorPoint(program, lower, upper, options).solve();
}

}  // namespace

Solution best(const Program& program, const Eights& lower, const Eights& upper, const Options& options) {
  Solution found = from(program, lower, upper, options);
  if (found.outcome == Outcome::kSolved) return found;
  // From near its bound a variable may hardly get away: begin again, well inside.
  Options again = options;
  again.inside = options.well_inside;
  const int spent = found.iterations;
  found = from(program, lower, upper, again);
  found.iterations += spent;
  return found;
}

}  // namespace banded
