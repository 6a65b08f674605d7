// The motion: bounds of the coordinates and their derivatives in each cell of a grid of times.
#pragma once

#include "statement.hpp"

namespace checker {

// The n coordinates over the g - 1 cells of a grid; rows of n numbers.
struct Motion {
  int count = 0;
  std::vector<Ball> positions, velocities;       // at the times of the grid
  std::array<std::vector<Range>, 5> bounds;      // of position and its derivatives within each cell
  std::array<std::vector<Ball>, 2> accelerations;  // at the start and the end of each cell
};

Motion motion_on(const Statement& statement, const std::vector<double>& grid);

}  // namespace checker
