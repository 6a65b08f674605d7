// One configuration: every pair that touches, and the nearest.
#pragma once

#include "candidates.hpp"
#include "meter.hpp"

namespace proof {

// Distances of all pairs that may touch or be the nearest of the strict ones; infinite for the others [m].
std::vector<double> measure_nearest(const Bodies& bodies, const Candidates& candidates, Meter& meter, Snapshot& at,
                                    const std::vector<char>& strict);

}  // namespace proof
