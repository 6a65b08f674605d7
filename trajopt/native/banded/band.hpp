// Symmetric matrices whose entries lie near the diagonal, and rows of few neighbours, in tiles of eight by eight.
#pragma once

#include <cstddef>
#include <vector>

#include "lanes.hpp"

namespace banded {

struct Tile {
  Eight column[kLanes];
};

// Of each column of tiles the one on the diagonal, in full, and those below it.
class Band {
 public:
  Band() = default;
  // So many tiles along the diagonal, and below each of them.
  Band(int tiles, int below)
      : tiles_(tiles), below_(below), entries_(static_cast<std::size_t>(tiles) * (below + 1)) {}

  int tiles() const { return tiles_; }
  int last_below(int column) const { return column + below_ < tiles_ ? below_ : tiles_ - 1 - column; }
  Tile& tile(int column, int down) { return entries_[static_cast<std::size_t>(column) * (below_ + 1) + down]; }
  const Tile& tile(int column, int down) const {
    return entries_[static_cast<std::size_t>(column) * (below_ + 1) + down];
  }
  // The row is in the column's tile, or in one below it.
  double& entry(int row, int column) {
    return tile(column / kLanes, row / kLanes - column / kLanes).column[column % kLanes].lane[row % kLanes];
  }

 private:
  int tiles_ = 0, below_ = 0;
  std::vector<Tile> entries_;
};

// Rows that are zero but for a run of tiles each. Those of equal runs follow each other, as a set. Rows that are zero but
// for one lane, as limits of one joint are, stand eight beside each other, each in its own: a tile of theirs is eight
// numbers.
struct Runs {
  struct Set {
    int tile, tiles;    // the run
    int first, rows;
    std::size_t start;  // of their entries: row by row, tile by tile
  };
  struct Beside {
    int tile, tiles;    // the run
    int first, groups;  // of eight rows
    std::size_t start;  // of their entries: group by group, tile by tile
  };

  int count = 0, groups = 0;  // rows in sets; groups of eight, those beside each other come after them
  std::vector<Set> sets;
  std::vector<Beside> beside;
  Eights entries;  // and, at the end, those of eight rows that are zero
  Eights lanes;    // entries of those beside each other
};

}  // namespace banded
