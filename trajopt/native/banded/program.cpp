#include "program.hpp"

#include <algorithm>
#include <cmath>

namespace banded {

Program::Program(int joints, std::vector<char> moves) : joints_(joints), column_(moves.size(), -1) {
  for (std::size_t variable = 0; variable < moves.size(); ++variable) {
    if (moves[variable]) column_[variable] = size_++;
  }
}

// The entries of a row that are not zero, of variables that move, by column; widens the band to hold them.
const std::vector<Program::Entry>& Program::entries_of(const Stencils& rows, int row) {
  scratch_.clear();
  for (int k = 0; k < rows.knots; ++k) {
    const std::size_t place = static_cast<std::size_t>(row) * rows.knots + k;
    const int* columns = column_.data() + rows.knot[place] * joints_;
    const double* values = rows.jacobian + place * joints_;
    for (int joint = 0; joint < joints_; ++joint) {
      if (values[joint] != 0.0 && columns[joint] >= 0) scratch_.push_back({columns[joint], values[joint]});
    }
  }
  const auto earlier = [](const Entry& a, const Entry& b) { return a.column < b.column; };
  if (!std::is_sorted(scratch_.begin(), scratch_.end(), earlier)) {
    std::sort(scratch_.begin(), scratch_.end(), earlier);
  }
  std::size_t kept = 0;  // a stencil may name a knot twice
  for (std::size_t k = 0; k < scratch_.size(); ++k) {
    if (kept > 0 && scratch_[kept - 1].column == scratch_[k].column) {
      scratch_[kept - 1].value += scratch_[k].value;
    } else {
      scratch_[kept++] = scratch_[k];
    }
  }
  scratch_.resize(kept);
  if (!scratch_.empty()) bandwidth_ = std::max(bandwidth_, scratch_.back().column - scratch_.front().column);
  return scratch_;
}

void Program::add_squared(const Stencils& stencils, const double* weight) {
  for (int row = 0; row < stencils.rows; ++row) {
    const auto& entries = entries_of(stencils, row);
    const int start = static_cast<int>(square_entries_.size());
    square_entries_.insert(square_entries_.end(), entries.begin(), entries.end());
    squares_.push_back({weight[row], stencils.value[row], start, static_cast<int>(square_entries_.size())});
  }
}

void Program::add_excess(const Stencils& stencils, const double* lower, const double* upper, const double* weight) {
  for (int row = 0; row < stencils.rows; ++row) {
    const auto& entries = entries_of(stencils, row);
    for (const double sign : {1.0, -1.0}) {
      const double limit = sign > 0.0 ? upper[row] : -lower[row];
      if (!std::isfinite(limit) || weight[row] == 0.0) continue;
      bound.push_back(limit - sign * stencils.value[row]);
      penalty.push_back(weight[row]);
      rows.first.push_back(entries.empty() ? 0 : entries.front().column);
      rows.start.push_back(static_cast<int>(rows.values.size()));
      const std::size_t begin = rows.values.size();
      const int span = entries.empty() ? 0 : entries.back().column - entries.front().column + 1;
      rows.length.push_back(span);
      rows.values.resize(begin + padded(span) + kLanes, 0.0);
      for (const Entry& entry : entries) {
        rows.values[begin + entry.column - entries.front().column] += sign * entry.value;
      }
    }
  }
}

void Program::assemble(double regularisation) {
  if (hessian.size() == size_ && size_ > 0) return;
  hessian = Band(size_, bandwidth_);
  gradient.assign(size_, 0.0);
  for (int j = 0; j < size_; ++j) hessian.column(j)[0] = regularisation;
  for (const Square& square : squares_) {
    for (int a = square.start; a < square.end; ++a) {
      const Entry& one = square_entries_[a];
      const double scaled = 2.0 * square.weight * one.value;
      gradient[one.column] += scaled * square.value;
      double* column = hessian.column(one.column);
      for (int b = a; b < square.end; ++b) {
        column[square_entries_[b].column - one.column] += scaled * square_entries_[b].value;
      }
    }
  }
}

double Program::objective(const double* x) const {
  std::vector<double> product(hessian.room());
  hessian.multiply(x, product.data());
  double value = 0.0;
  for (int j = 0; j < size_; ++j) value += (0.5 * product[j] + gradient[j]) * x[j];
  for (int row = 0; row < rows.count(); ++row) {
    const double excess = dot(rows.run(row), x + rows.first[row], rows.length[row]) - bound[row];
    value += penalty[row] * std::max(0.0, excess);
  }
  return value;
}

}  // namespace banded
