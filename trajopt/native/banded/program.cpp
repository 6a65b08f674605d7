#include "program.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace banded {

Program::Program(int joints, const std::vector<char>& moves) : joints_(joints), lane_(moves.size(), -1) {
  for (std::size_t knot = 0; knot < moves.size(); knot += joints) {
    bool any = false;
    for (int joint = 0; joint < joints; ++joint) {
      if (!moves[knot + joint]) continue;
      lane_[knot + joint] = groups_ * kLanes + joint;
      any = true;
      ++size_;
    }
    if (any) groups_ += groups_of(joints);
  }
}

// Append the entries of a row that are not zero, of variables that move.
void Program::take_entries(const Stencils& rows, int row) {
  for (int k = 0; k < rows.knots; ++k) {
    const std::size_t place = static_cast<std::size_t>(row) * rows.knots + k;
    const int* lanes = lane_.data() + rows.knot[place] * joints_;
    const double* values = rows.jacobian + place * joints_;
    for (int joint = 0; joint < joints_; ++joint) {
      if (values[joint] != 0.0 && lanes[joint] >= 0) entries_.push_back({lanes[joint], values[joint]});
    }
  }
}

// The first tile that entries are in, and the last; before the first where there are none.
std::pair<int, int> Program::tiles_between(std::size_t start, std::size_t end) const {
  if (start == end) return {0, -1};
  const auto earlier = [](const Entry& a, const Entry& b) { return a.lane < b.lane; };
  const auto [first, last] = std::minmax_element(entries_.begin() + start, entries_.begin() + end, earlier);
  return {first->lane / kLanes, last->lane / kLanes};
}

void Program::add_squared(const Stencils& stencils, const double* weight) {
  for (int row = 0; row < stencils.rows; ++row) {
    const std::size_t start = entries_.size();
    take_entries(stencils, row);
    squares_.push_back({weight[row], stencils.value[row], start, entries_.size()});
  }
}

void Program::add_excess(const Stencils& stencils, const double* lower, const double* upper, const double* weight) {
  for (int row = 0; row < stencils.rows; ++row) {
    if (weight[row] == 0.0 || !(std::isfinite(lower[row]) || std::isfinite(upper[row]))) continue;
    const std::size_t start = entries_.size();
    take_entries(stencils, row);
    const auto [first, last] = tiles_between(start, entries_.size());
    for (const double sign : {1.0, -1.0}) {
      const double limit = sign > 0.0 ? upper[row] : -lower[row];
      if (!std::isfinite(limit)) continue;
      const double bound = limit - sign * stencils.value[row];
      excesses_.push_back({sign, bound, weight[row], first, last + 1 - first, start, entries_.size()});
    }
  }
}

void Program::assemble(double regularisation) {
  if (assembled_) return;
  assembled_ = true;
  hessian = Band(groups_, reach());
  variable_there.assign(groups_, {});
  for (int lane : lane_) {
    if (lane >= 0) numbers(variable_there)[lane] = 1.0;
  }
  for (int lane = 0; lane < groups_ * kLanes; ++lane) {
    hessian.entry(lane, lane) = numbers(variable_there)[lane] > 0.0 ? regularisation : 1.0;
  }
  assemble_squares();
  assemble_rows();
}

// How many tiles below the diagonal squares and rows reach.
int Program::reach() const {
  int reach = 0;
  for (const Excess& excess : excesses_) reach = std::max(reach, excess.tiles - 1);
  for (const Square& square : squares_) {
    const auto [first, last] = tiles_between(square.start, square.end);
    reach = std::max(reach, last - first);
  }
  return reach;
}

void Program::assemble_squares() {
  gradient.assign(groups_, {});
  for (const Square& square : squares_) {
    for (std::size_t a = square.start; a < square.end; ++a) {
      const Entry& one = entries_[a];
      const double scaled = 2.0 * square.weight * one.value;
      numbers(gradient)[one.lane] += scaled * square.value;
      for (std::size_t b = square.start; b < square.end; ++b) {
        const Entry& other = entries_[b];
        if (other.lane / kLanes >= one.lane / kLanes) hessian.entry(other.lane, one.lane) += scaled * other.value;
      }
    }
  }
}

void Program::assemble_rows() {
  std::vector<int> order(excesses_.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    const Excess &one = excesses_[a], &other = excesses_[b];
    return one.tile != other.tile ? one.tile < other.tile : one.tiles < other.tiles;
  });
  std::size_t size = 0;
  int widest = 0;
  for (const Excess& excess : excesses_) {
    size += excess.tiles;
    widest = std::max(widest, excess.tiles);
  }
  rows.count = row_count();
  rows.entries.assign(size + static_cast<std::size_t>(kLanes) * widest, {});
  for (auto* each : {&bound, &penalty, &row_there}) each->assign(row_groups() + 1, {});
  std::size_t start = 0;
  for (int row = 0; row < rows.count; ++row) {
    const Excess& excess = excesses_[order[row]];
    if (rows.sets.empty() || rows.sets.back().tile != excess.tile || rows.sets.back().tiles != excess.tiles) {
      rows.sets.push_back({excess.tile, excess.tiles, row, 0, start});
    }
    ++rows.sets.back().rows;
    double* entry = numbers(rows.entries) + start * kLanes;
    for (std::size_t k = excess.start; k < excess.end; ++k) {
      entry[entries_[k].lane - excess.tile * kLanes] += excess.sign * entries_[k].value;
    }
    start += excess.tiles;
    numbers(bound)[row] = excess.bound;
    numbers(penalty)[row] = excess.penalty;
    numbers(row_there)[row] = 1.0;
  }
}

}  // namespace banded
