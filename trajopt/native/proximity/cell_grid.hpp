// Cells of space, solid or free, a bit each.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace proximity {

// Bits of all cells, in words along the first axis; one layer of cells around the cloud is free.
class CellGrid {
 public:
  using Vector3 = Eigen::Vector3d;
  using Index = std::array<int, 3>;

  CellGrid(const Vector3& low, const Vector3& high, double cell) : origin_(low - Vector3::Constant(2.5 * cell)), cell_(cell) {
    for (int axis = 0; axis < 3; ++axis) size_[axis] = static_cast<int>(std::floor((high[axis] - origin_[axis]) / cell)) + 3;
    words_ = (size_[0] + 63) / 64;
    rows_ = static_cast<std::size_t>(size_[1]) * size_[2];
  }

  // About how many cells there would be.
  static double cells_of(const Vector3& low, const Vector3& high, double cell) {
    return ((high - low) / cell + Vector3::Constant(6.0)).prod();
  }
  std::size_t cells() const { return rows_ * size_[0]; }
  std::size_t number(const Index& at) const { return row(at[1], at[2]) * size_[0] + at[0]; }
  Index of(const Vector3& point) const {
    Index at;
    for (int axis = 0; axis < 3; ++axis) at[axis] = static_cast<int>((point[axis] - origin_[axis]) / cell_);
    return at;
  }

  void set(const Index& at) { bits_[row(at[1], at[2]) * words_ + at[0] / 64] |= std::uint64_t{1} << (at[0] % 64); }
  bool get(const Index& at) const { return bits_[row(at[1], at[2]) * words_ + at[0] / 64] >> (at[0] % 64) & 1u; }
  void clear() { bits_.assign(rows_ * words_, 0); }

  // Make solid what lies between solid cells that are two cells apart at most along every axis: morphological closing by
  // a cube of three cells.
  void close_gaps() {
    for (const bool widened : {true, false}) {
      if (!widened) invert();
      widen();
    }
    invert();
  }

  // Make solid what cannot be reached from outside through cells that are not.
  void enclose() {
    std::vector<std::uint64_t> outside(bits_.size(), 0);
    for (std::size_t word = 0; word < words_; ++word) outside[word] = ~std::uint64_t{0};
    const std::size_t layer = static_cast<std::size_t>(size_[1]);
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t row = 0; row < rows_; ++row) {
        changed |= spread(outside, row, row % layer ? row - 1 : row, row >= layer ? row - layer : row);
      }
      for (std::size_t row = rows_; row-- > 0;) {
        changed |= spread(outside, row, (row + 1) % layer ? row + 1 : row, row + layer < rows_ ? row + layer : row);
      }
    }
    for (std::size_t word = 0; word < bits_.size(); ++word) bits_[word] = ~outside[word];
  }

 private:
  std::size_t row(int y, int z) const { return static_cast<std::size_t>(z) * size_[1] + y; }

  void invert() {
    for (auto& word : bits_) word = ~word;
  }

  // Make solid the 26 cells around each solid one.
  void widen() {
    std::vector<std::uint64_t> old = bits_;
    for (std::size_t row = 0; row < rows_; ++row) {
      const std::uint64_t* from = old.data() + row * words_;
      for (std::size_t word = 0; word < words_; ++word) {
        const std::uint64_t before = word > 0 ? from[word - 1] >> 63 : 0, after = word + 1 < words_ ? from[word + 1] << 63 : 0;
        bits_[row * words_ + word] |= from[word] << 1 | before | from[word] >> 1 | after;
      }
    }
    const std::size_t layer = static_cast<std::size_t>(size_[1]);
    for (const std::size_t step : {std::size_t{1}, layer}) {
      old = bits_;
      for (std::size_t row = 0; row < rows_; ++row) {
        const bool first = step == 1 ? row % layer == 0 : row < layer, last = step == 1 ? (row + 1) % layer == 0 : row + layer >= rows_;
        for (std::size_t word = 0; word < words_; ++word) {
          std::uint64_t& here = bits_[row * words_ + word];
          if (!first) here |= old[(row - step) * words_ + word];
          if (!last) here |= old[(row + step) * words_ + word];
        }
      }
    }
  }

  // Reach what is free from two rows beside one, and along it.
  bool spread(std::vector<std::uint64_t>& outside, std::size_t row, std::size_t beside, std::size_t below) {
    std::uint64_t carry = 0, changed = 0;
    std::uint64_t* const here = outside.data() + row * words_;
    const std::uint64_t *one = outside.data() + beside * words_, *other = outside.data() + below * words_;
    const std::uint64_t* const solid = bits_.data() + row * words_;
    for (std::size_t word = 0; word < words_; ++word) {
      const std::uint64_t free = ~solid[word];
      std::uint64_t reached = (here[word] | one[word] | other[word] | carry) & free, way = free;
      for (int step = 1; step < 64; step *= 2) reached |= way & (reached << step), way &= way << step;
      changed |= reached ^ here[word];
      here[word] = reached;
      carry = reached >> 63;
    }
    carry = 0;
    for (std::size_t word = words_; word-- > 0;) {
      const std::uint64_t free = ~solid[word];
      std::uint64_t reached = (here[word] | carry) & free, way = free;
      for (int step = 1; step < 64; step *= 2) reached |= way & (reached >> step), way &= way >> step;
      changed |= reached ^ here[word];
      here[word] = reached;
      carry = reached << 63;
    }
    return changed != 0;
  }

  Vector3 origin_;
  double cell_;
  Index size_;
  std::size_t words_, rows_;
  std::vector<std::uint64_t> bits_;
};

}  // namespace proximity
