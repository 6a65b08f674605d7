// Rows of numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace timing {

using Numbers = std::vector<double>;

struct Table {
  std::size_t rows = 0, columns = 0;
  Numbers values;

  Table() = default;
  Table(std::size_t rows, std::size_t columns, double value = 0.0)
      : rows(rows), columns(columns), values(rows * columns, value) {}
  Table(std::size_t rows, std::size_t columns, Numbers given) : rows(rows), columns(columns), values(std::move(given)) {}

  double* operator[](std::size_t row) { return values.data() + row * columns; }
  const double* operator[](std::size_t row) const { return values.data() + row * columns; }
  void set(std::size_t row, const double* from) { std::copy(from, from + columns, (*this)[row]); }
};

constexpr double kMostParts = 1e6;  // more parts of anything mean that rounding errors rule

// A number of parts: whole, at least one.
inline std::size_t parts_of(double number) {
  return number >= 1.0 ? static_cast<std::size_t>(std::min(number, kMostParts)) : 1;
}

// The function through points with increasing arguments, straight between them and level beyond.
inline double interpolated(const Numbers& argument, const Numbers& value, double at) {
  if (!(at > argument.front())) return value.front();
  if (at >= argument.back()) return value.back();
  const std::size_t right = std::upper_bound(argument.begin(), argument.end(), at) - argument.begin(), left = right - 1;
  return (value[right] - value[left]) / (argument[right] - argument[left]) * (at - argument[left]) + value[left];
}

// Cuts each span between marks into equal parts, marks included.
inline Numbers cut(const Numbers& marks, const std::vector<std::size_t>& parts) {
  Numbers cuts;
  for (std::size_t span = 0; span < parts.size(); ++span) {
    const double step = (marks[span + 1] - marks[span]) / static_cast<double>(parts[span]);
    for (std::size_t i = 0; i < parts[span]; ++i) cuts.push_back(marks[span] + step * static_cast<double>(i));
  }
  cuts.push_back(marks.back());
  return cuts;
}

// Where control values stand on a grid: start, interval middles, goal.
inline Numbers stations(const Numbers& s) {
  Numbers found{s.front()};
  for (std::size_t i = 0; i + 1 < s.size(); ++i) found.push_back((s[i] + s[i + 1]) / 2.0);
  found.push_back(s.back());
  return found;
}

}  // namespace timing
