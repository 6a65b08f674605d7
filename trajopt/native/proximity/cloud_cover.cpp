#include "cloud_cover.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "cell_grid.hpp"
#include "cloud_axes.hpp"

namespace proximity {

namespace {

using Vector3 = CloudCover::Vector3;
using Matrix3 = CloudCover::Matrix3;
using Piece = CloudCover::Piece;
using Index = CellGrid::Index;

// A box of cells, its far corner included.
struct Block {
  Index from, to;
};

bool all_of(const Block& block, const CellGrid& grid) {
  Index at;
  for (at[2] = block.from[2]; at[2] <= block.to[2]; ++at[2]) {
    for (at[1] = block.from[1]; at[1] <= block.to[1]; ++at[1]) {
      for (at[0] = block.from[0]; at[0] <= block.to[0]; ++at[0]) {
        if (!grid.get(at)) return false;
      }
    }
  }
  return true;
}

// The largest block of solid cells of which a cell is the lower corner, of those that grow along one axis after the other.
Block grown(const Index& corner, const CellGrid& solid) {
  constexpr int kOrders[3][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}};
  Block best{corner, corner};
  double most = 0.0;
  for (const auto& order : kOrders) {
    Block block{corner, corner};
    double count = 1.0;
    for (const int axis : order) {
      for (;;) {
        Block next = block;
        next.from[axis] = next.to[axis] = block.to[axis] + 1;
        if (!all_of(next, solid)) break;
        ++block.to[axis];
      }
      for (;;) {
        Block next = block;
        next.from[axis] = next.to[axis] = block.from[axis] - 1;
        if (!all_of(next, solid)) break;
        --block.from[axis];
      }
      count *= block.to[axis] - block.from[axis] + 1;
    }
    if (count > most) most = count, best = block;
  }
  return best;
}

// The cells with points in them.
class Filled {
 public:
  // The points of a cloud, turned: they are turned anew rather than kept, which takes longer.
  Filled(const std::vector<Vector3>& cloud, const Matrix3& turn, CellGrid& grid) : grid_(grid), at_(grid.cells(), -1) {
    in.reserve(cloud.size());
    grid.clear();
    for (const Vector3& each : cloud) {
      const Vector3 point = turn * each;
      const Index at = grid.of(point);
      std::int32_t& known = at_[grid.number(at)];
      if (known < 0) {
        known = static_cast<std::int32_t>(cells.size());
        cells.push_back({at, {point, point}, -1});
        grid.set(at);
      } else {
        add(cells[known].bounds, {point, point});
      }
      in.push_back(known);
    }
  }

  struct Cell {
    Index at;
    Piece bounds;
    std::int32_t piece;
  };

  static void add(Piece& to, const Piece& other) {
    to.low = to.low.cwiseMin(other.low);
    to.high = to.high.cwiseMax(other.high);
  }

  // Give the cells of a block that have none yet to a piece, and return what is around their points.
  Piece give(const Block& block, const Cell& first, std::int32_t piece) {
    Piece around = first.bounds;
    Index at;
    for (at[2] = block.from[2]; at[2] <= block.to[2]; ++at[2]) {
      for (at[1] = block.from[1]; at[1] <= block.to[1]; ++at[1]) {
        for (at[0] = block.from[0]; at[0] <= block.to[0]; ++at[0]) {
          const std::int32_t inner = at_[grid_.number(at)];
          if (inner < 0 || cells[inner].piece >= 0) continue;
          cells[inner].piece = piece;
          add(around, cells[inner].bounds);
        }
      }
    }
    return around;
  }

  // From the lowest corner on.
  std::vector<std::int32_t> in_order() const {
    std::vector<std::int32_t> order(cells.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(),
              [&](std::int32_t a, std::int32_t b) { return grid_.number(cells[a].at) < grid_.number(cells[b].at); });
    return order;
  }

  std::vector<Cell> cells;
  std::vector<std::int32_t> in;  // the cell of each point

 private:
  const CellGrid& grid_;
  std::vector<std::int32_t> at_;  // by number in the grid, -1 where there is no point
};

}  // namespace

CloudCover::CloudCover(const std::vector<Vector3>& cloud, double cell, std::size_t most) : axes_(axes_of(cloud)) {
  const Matrix3 turn = axes_.transpose();
  Piece bounds{turn * cloud[0], turn * cloud[0]};
  for (const Vector3& each : cloud) {
    const Vector3 point = turn * each;
    bounds.low = bounds.low.cwiseMin(point);
    bounds.high = bounds.high.cwiseMax(point);
  }
  if (CellGrid::cells_of(bounds.low, bounds.high, cell) > kMostCells) return;
  CellGrid grid(bounds.low, bounds.high, cell);
  Filled filled(cloud, turn, grid);
  grid.close_gaps();
  grid.enclose();
  for (const std::int32_t number : filled.in_order()) {
    const Filled::Cell first = filled.cells[number];
    if (first.piece >= 0) continue;
    pieces_.push_back(filled.give(grown(first.at, grid), first, static_cast<std::int32_t>(pieces_.size())));
    if (pieces_.size() > most) {
      pieces_.clear();
      return;
    }
  }
  piece_ = std::move(filled.in);
  for (std::int32_t& each : piece_) each = filled.cells[each].piece;
}

CloudCover CloudCover::cut(const std::vector<Vector3>& cloud, const std::vector<char>& chosen, double edge, int parts) const {
  CloudCover made;
  made.axes_ = axes_;
  // Along which axes each is cut, and the new numbers of its parts; of the others theirs.
  std::vector<Index> ways(pieces_.size(), Index{1, 1, 1});
  std::vector<std::size_t> first;
  std::size_t count = 0;
  for (std::size_t piece = 0; piece < pieces_.size(); ++piece) {
    const Vector3 size = pieces_[piece].high - pieces_[piece].low;
    for (int axis = 0; chosen[piece] && axis < 3; ++axis) {
      if (2.0 * size[axis] > size.maxCoeff()) ways[piece][axis] = std::clamp(static_cast<int>(std::ceil(size[axis] / edge)), 1, parts);
    }
    first.push_back(count);
    count += static_cast<std::size_t>(ways[piece][0]) * ways[piece][1] * ways[piece][2];
  }
  const double far = std::numeric_limits<double>::infinity();
  std::vector<Piece> around(count, {Vector3::Constant(far), Vector3::Constant(-far)});
  std::vector<std::int32_t> in;
  const Matrix3 turn = axes_.transpose();
  for (std::size_t index = 0; index < cloud.size(); ++index) {
    const std::int32_t piece = piece_[index];
    std::size_t part = first[piece];
    if (chosen[piece]) {
      const Vector3 point = turn * cloud[index];
      std::size_t stride = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const int many = ways[piece][axis];
        const double low = pieces_[piece].low[axis], wide = pieces_[piece].high[axis] - low;
        if (many > 1) part += stride * std::clamp(static_cast<int>((point[axis] - low) / wide * many), 0, many - 1);
        stride *= many;
      }
      Filled::add(around[part], {point, point});
    } else {
      around[part] = pieces_[piece];
    }
    in.push_back(static_cast<std::int32_t>(part));
  }
  std::vector<std::int32_t> number(count, -1);
  for (std::size_t part = 0; part < count; ++part) {
    if (around[part].low[0] > around[part].high[0]) continue;
    number[part] = static_cast<std::int32_t>(made.pieces_.size());
    made.pieces_.push_back(around[part]);
  }
  for (const std::int32_t part : in) made.piece_.push_back(number[part]);
  return made;
}

std::vector<Vector3> CloudCover::within(const std::vector<Vector3>& cloud, const std::vector<char>& chosen) const {
  std::vector<Vector3> found;
  for (std::size_t index = 0; index < piece_.size(); ++index) {
    if (chosen[piece_[index]]) found.push_back(cloud[index]);
  }
  return found;
}

}  // namespace proximity
