// Limits of joints at all times, and the state at the ends.
#pragma once

#include "arm.hpp"

namespace checker {

// The first fault; empty if there is none.
std::string limits_fault(const Statement& statement, const Arm& arm);

// A sentence on a cell of the grid in which something is not shown.
std::string unshown(const std::string& words, const Arm& arm, int cell);

}  // namespace checker
