// Signed distances of convex bodies that overlap: Coal proposes a direction, and the gap along it is taken.
#pragma once

#include "form.hpp"

namespace proof {

// Two ways of measuring that differ by more call for another [m].
constexpr double doubtful = 1e-5;

// Gap between two forms along a unit direction from the first to the second, all in one frame [m].
double gap_along(const Form& first, const Pose& first_at, const Form& second, const Pose& second_at, const Vec& n);

// Signed distance, a lower bound of the true one: by the direction that Coal's expanding polytope algorithm proposes,
// and by a search of all directions where Coal's distance is doubtful.
double signed_distance(const Form& first, const Pose& first_at, const Form& second, const Pose& second_at);

// The largest gap that a search of all directions finds: slow, always a lower bound, and the signed distance itself
// unless the search misses a peak between its evenly spread starts.
double largest_gap(const Form& first, const Pose& first_at, const Form& second, const Pose& second_at);

}  // namespace proof
