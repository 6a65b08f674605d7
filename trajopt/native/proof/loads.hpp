// How much of what its motors can give a motion asks of the joints of a group, at samples.
#pragma once

#include <cstdint>

#include "curve.hpp"
#include "dynamics.hpp"

namespace proof {

struct Samples {
  const int64_t* steps;  // Of each piece: it is sampled at so many moments and one, both its ends among them.
  double rounding;       // Accelerations that differ by this part of the largest differ by rounding.
  const double* rests;   // Positions at which the group's joints are held still as well, one row each.
  size_t rest_count;
};

// The largest part of its limit that a joint of the group needs, 0 at least; what has no limit counts for nothing. A
// joint that mimics another counts for it. Where the acceleration does not jump, the end of a piece is the begin of the
// next as well.
double largest_share(const Dynamics& dynamics, const Curve& position, const Samples& samples,
                     const Eigen::MatrixXd& expand, const Eigen::VectorXd& offset, const double* effort);

}  // namespace proof
