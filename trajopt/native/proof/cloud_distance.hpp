// Signed distance of a cloud and a convex body at one moment: that of the nearest ball or cube.
#pragma once

#include "gjk.hpp"

namespace proof {

// Signed distance of two convex forms at their places, or anything no less than `within` if it is no less.
using ConvexDistance = double (*)(const Form& first, const Pose& first_at, const Form& second, const Pose& second_at,
                                  Vec& guess, double within);

// Smallest distance of the parts of a cloud to a form, which may be a cloud too; `within` if none is nearer.
double cloud_distance(const Form& cloud, const Pose& cloud_at, const Form& other, const Pose& other_at, double within,
                      ConvexDistance measure);

}  // namespace proof
