// Eight numbers, which inner loops take together, whatever the processor's registers hold at once.
#pragma once

#include <vector>

namespace banded {

constexpr int kLanes = 8;

struct alignas(64) Eight {
  double lane[kLanes] = {};
};
using Eights = std::vector<Eight>;

constexpr int groups_of(int numbers) { return (numbers + kLanes - 1) / kLanes; }

// The numbers one by one.
inline double* numbers(Eights& of) { return of.data()->lane; }
inline const double* numbers(const Eights& of) { return of.data()->lane; }

}  // namespace banded
