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
  const auto run = [&](int row) { return std::pair{excesses_[row].tile, excesses_[row].tiles}; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return run(a) < run(b); });
  std::vector<int> alone, places;  // rows of sets; rows beside each other, eight a group, -1 for none
  for (auto first = order.begin(); first != order.end();) {
    const auto last = std::find_if(first, order.end(), [&](int row) { return run(row) != run(*first); });
    const int begin = static_cast<int>(places.size()) / kLanes;
    deal({first, last}, alone, places);
    const int groups = static_cast<int>(places.size()) / kLanes - begin;
    if (groups > 0) rows.beside.push_back({run(*first).first, run(*first).second, begin, groups, 0});
    first = last;
  }
  rows.count = static_cast<int>(alone.size());
  rows.groups = groups_of(rows.count) + static_cast<int>(places.size()) / kLanes;
  for (auto* each : {&bound, &penalty, &row_there}) each->assign(rows.groups + 1, {});
  assemble_sets(alone);
  assemble_beside(places);
}

// The lane that all entries of a row are in; -1 where there is none.
int Program::lane_of(const Excess& excess) const {
  const auto lane = [&](std::size_t entry) { return entries_[entry].lane % kLanes; };
  for (std::size_t k = excess.start; k < excess.end; ++k) {
    if (lane(k) != lane(excess.start)) return -1;
  }
  return excess.start == excess.end ? -1 : lane(excess.start);
}

// Deal rows over the same run out to groups of eight beside each other, if at least half of the places are taken; the
// rest are left alone.
void Program::deal(const std::vector<int>& bucket, std::vector<int>& alone, std::vector<int>& places) const {
  int taken[kLanes] = {}, dealt = 0;
  std::vector<int> found;
  for (int row : bucket) {
    const int lane = lane_of(excesses_[row]);
    if (lane < 0) continue;
    const std::size_t place = static_cast<std::size_t>(taken[lane]++) * kLanes + lane;
    if (place >= found.size()) found.resize((place / kLanes + 1) * kLanes, -1);
    found[place] = row;
    ++dealt;
  }
  const bool full = found.size() <= 2 * static_cast<std::size_t>(dealt);
  if (full) places.insert(places.end(), found.begin(), found.end());
  for (int row : bucket) {
    if (!full || lane_of(excesses_[row]) < 0) alone.push_back(row);
  }
}

void Program::assemble_sets(const std::vector<int>& order) {
  std::size_t size = 0;
  int widest = 0;
  for (int row : order) {
    size += excesses_[row].tiles;
    widest = std::max(widest, excesses_[row].tiles);
  }
  rows.entries.assign(size + static_cast<std::size_t>(kLanes) * widest, {});
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
    take_in(excess, row);
  }
}

void Program::assemble_beside(const std::vector<int>& places) {
  std::size_t start = 0;
  for (Runs::Beside& set : rows.beside) {
    set.start = start;
    rows.lanes.resize(start + static_cast<std::size_t>(set.groups) * set.tiles);
    for (int place = set.first * kLanes; place < (set.first + set.groups) * kLanes; ++place) {
      if (places[place] < 0) continue;
      const Excess& excess = excesses_[places[place]];
      Eight* entry = rows.lanes.data() + start + static_cast<std::size_t>(place / kLanes - set.first) * set.tiles;
      for (std::size_t k = excess.start; k < excess.end; ++k) {
        const int lane = entries_[k].lane;
        entry[lane / kLanes - excess.tile].lane[lane % kLanes] += excess.sign * entries_[k].value;
      }
      take_in(excess, groups_of(rows.count) * kLanes + place);
    }
    start = rows.lanes.size();
    set.first += groups_of(rows.count);
  }
}

void Program::take_in(const Excess& excess, int row) {
  numbers(bound)[row] = excess.bound;
  numbers(penalty)[row] = excess.penalty;
  numbers(row_there)[row] = 1.0;
}

}  // namespace banded
