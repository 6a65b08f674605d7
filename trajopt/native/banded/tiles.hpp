// Arithmetic of tiles, in vectors of as many numbers as the processor at hand takes at once.
//
// Included once for each kind of processor, in a namespace of its own where kWidth says how many these are: 8, 4 or 2.
// Sums are added in the same order for each of them. Source: Golub and Van Loan, Matrix Computations (4th ed.),
// sections 4.1.2 and 4.2.9.

constexpr int kParts = kLanes / kWidth;  // vectors in eight numbers

using Vec = double __attribute__((vector_size(8 * kWidth), may_alias));
using Two = double __attribute__((vector_size(16)));

[[gnu::always_inline]] inline Vec& part(Eight& of, int number) { return reinterpret_cast<Vec*>(&of)[number]; }
[[gnu::always_inline]] inline const Vec& part(const Eight& of, int number) {
  return reinterpret_cast<const Vec*>(&of)[number];
}

[[gnu::always_inline]] inline void fill(double value, Eight& found) {
  for (int p = 0; p < kParts; ++p) part(found, p) = Vec{} + value;
}

// Half the sum of a vector's lanes each.
template <class V, int N>
[[gnu::always_inline]] inline Two in_halves(const V (&parts)[N]) {
  if constexpr (N == 1) {
    const auto four = __builtin_shufflevector(parts[0], parts[0], 0, 1, 2, 3) +
                      __builtin_shufflevector(parts[0], parts[0], 4, 5, 6, 7);
    return __builtin_shufflevector(four, four, 0, 1) + __builtin_shufflevector(four, four, 2, 3);
  } else if constexpr (N == 2) {
    const auto four = parts[0] + parts[1];
    return __builtin_shufflevector(four, four, 0, 1) + __builtin_shufflevector(four, four, 2, 3);
  } else {
    return (parts[0] + parts[2]) + (parts[1] + parts[3]);
  }
}

// The sums of eight times eight numbers.
[[gnu::always_inline]] inline void sums(const Vec (&each)[kLanes][kParts], double* found) {
  for (int k = 0; k < kLanes; k += 2) {
    const Two one = in_halves(each[k]), other = in_halves(each[k + 1]);
    const Two both = __builtin_shufflevector(one, other, 0, 2) + __builtin_shufflevector(one, other, 1, 3);
    found[k] = both[0];
    found[k + 1] = both[1];
  }
}

[[gnu::always_inline]] inline double sum(const Vec (&parts)[kParts]) {
  const Two halves = in_halves(parts);
  return halves[0] + halves[1];
}

// What each column of a tile on the diagonal takes from those after it.
using Factors = double[kLanes][kLanes];

// Take a tile's columns out of one another, pivot by pivot. A pivot that is nothing beside what was its diagonal entry
// is taken to be that entry, so that its variable stays where it is (as good as).
[[gnu::always_inline]] inline void eliminate(const Tile& tile, const Eight& diagonal, Factors& factor, Eight& inverse) {
  constexpr double kNothing = 1e-14;
  Tile left = tile;
#pragma GCC unroll 8
  for (int c = 0; c < kLanes; ++c) {
    const double found = left.column[c].lane[c];
    inverse.lane[c] = 1.0 / (found > kNothing * diagonal.lane[c] ? found : diagonal.lane[c]);
#pragma GCC unroll 8
    for (int later = c + 1; later < kLanes; ++later) {
      factor[c][later] = left.column[c].lane[later] * inverse.lane[c];
      for (int p = 0; p < kParts; ++p) part(left.column[later], p) -= part(left.column[c], p) * factor[c][later];
    }
  }
}

// The same for a tile that is not on the diagonal.
[[gnu::always_inline]] inline void follow(const Factors& factor, Tile& tile) {
  for (int p = 0; p < kParts; ++p) {
    Vec column[kLanes];
#pragma GCC unroll 8
    for (int c = 0; c < kLanes; ++c) column[c] = part(tile.column[c], p);
#pragma GCC unroll 8
    for (int c = 0; c < kLanes; ++c) {
#pragma GCC unroll 8
      for (int later = c + 1; later < kLanes; ++later) column[later] -= column[c] * factor[c][later];
    }
#pragma GCC unroll 8
    for (int c = 0; c < kLanes; ++c) part(tile.column[c], p) = column[c];
  }
}

// tile += sum_k weight_k left_k right_k', of columns that are so many groups of eight apart.
[[gnu::always_inline]] inline void add_outers(const Eight* left, const Eight* right, int stride, const double* weight,
                                              int count, Tile& tile) {
  for (int p = 0; p < kParts; ++p) {
    Vec column[kLanes];
#pragma GCC unroll 8
    for (int c = 0; c < kLanes; ++c) column[c] = part(tile.column[c], p);
    for (int k = 0; k < count; ++k) {
      const Vec scaled = part(left[k * stride], p) * weight[k];
      const double* other = right[k * stride].lane;
#pragma GCC unroll 8
      for (int c = 0; c < kLanes; ++c) column[c] += scaled * other[c];
    }
#pragma GCC unroll 8
    for (int c = 0; c < kLanes; ++c) part(tile.column[c], p) = column[c];
  }
}

// y += sign tile x; each of two sums waits for its own last term only.
[[gnu::always_inline]] inline void add_product(double sign, const Tile& tile, const double* x, Eight& y) {
  for (int p = 0; p < kParts; ++p) {
    Vec even = part(tile.column[0], p) * x[0], odd = part(tile.column[1], p) * x[1];
#pragma GCC unroll 8
    for (int c = 2; c < kLanes; c += 2) {
      even += part(tile.column[c], p) * x[c];
      odd += part(tile.column[c + 1], p) * x[c + 1];
    }
    part(y, p) += sign * (even + odd);
  }
}

// terms_c += tile_c x, lane by lane.
[[gnu::always_inline]] inline void add_terms(const Tile& tile, const Eight& x, Vec (&terms)[kLanes][kParts]) {
#pragma GCC unroll 8
  for (int c = 0; c < kLanes; ++c) {
    for (int p = 0; p < kParts; ++p) terms[c][p] += part(tile.column[c], p) * part(x, p);
  }
}

// Rows of so many tiles, eight at a time. Beyond the last of a set the next one's entries are taken for rows; their
// numbers are written over. Where the compiler knows how many tiles there are, no sum leaves the registers.
[[gnu::always_inline]] inline void multiply_set(const Eight* entry, int tiles, const Eight* x, int rows, double* found) {
  for (int row = 0; row < rows; row += kLanes, entry += kLanes * tiles, found += kLanes) {
    Vec terms[kLanes][kParts] = {};
    for (int tile = 0; tile < tiles; ++tile) {
#pragma GCC unroll 8
      for (int k = 0; k < kLanes; ++k) {
        for (int p = 0; p < kParts; ++p) terms[k][p] += part(entry[k * tiles + tile], p) * part(x[tile], p);
      }
    }
    sums(terms, found);
  }
}

// y_i = row_i x of rows beside each other.
inline void multiply_beside(const Runs& rows, const Eights& x, Eights& y) {
  for (const Runs::Beside& set : rows.beside) {
    const Eight* entry = rows.lanes.data() + set.start;
    for (int group = set.first; group < set.first + set.groups; ++group, entry += set.tiles) {
      for (int p = 0; p < kParts; ++p) {
        Vec total = {};
        for (int tile = 0; tile < set.tiles; ++tile) total += part(entry[tile], p) * part(x[set.tile + tile], p);
        part(y[group], p) = total;
      }
    }
  }
}

// y_i = row_i x; y has room for a group more than there are rows.
inline void multiply(const Runs& rows, const Eights& x, Eights& y) {
  for (const Runs::Set& set : rows.sets) {
    const Eight* entry = rows.entries.data() + set.start;
    const Eight* at = x.data() + set.tile;
    double* found = numbers(y) + set.first;
    if (set.tiles == 1) {
      multiply_set(entry, 1, at, set.rows, found);
    } else if (set.tiles == 2) {
      multiply_set(entry, 2, at, set.rows, found);
    } else {
      multiply_set(entry, set.tiles, at, set.rows, found);
    }
  }
  multiply_beside(rows, x, y);  // at last: the others write beyond their end
}

// y += sum of factor_i row_i of rows beside each other.
inline void add_rows_beside(const Runs& rows, const Eights& factor, Eights& y) {
  for (const Runs::Beside& set : rows.beside) {
    const Eight* entry = rows.lanes.data() + set.start;
    for (int group = set.first; group < set.first + set.groups; ++group, entry += set.tiles) {
      for (int tile = 0; tile < set.tiles; ++tile) {
        for (int p = 0; p < kParts; ++p) part(y[set.tile + tile], p) += part(entry[tile], p) * part(factor[group], p);
      }
    }
  }
}

// y += sum of factor_i row_i.
inline void add_rows(const Runs& rows, const Eights& factor, Eights& y) {
  for (const Runs::Set& set : rows.sets) {
    const double* factors = numbers(factor) + set.first;
    for (int tile = 0; tile < set.tiles; ++tile) {
      const Eight* entry = rows.entries.data() + set.start + tile;
      Vec total[kParts];
      for (int p = 0; p < kParts; ++p) total[p] = part(y[set.tile + tile], p);
      for (int row = 0; row < set.rows; ++row, entry += set.tiles) {
        for (int p = 0; p < kParts; ++p) total[p] += part(*entry, p) * factors[row];
      }
      for (int p = 0; p < kParts; ++p) part(y[set.tile + tile], p) = total[p];
    }
  }
  add_rows_beside(rows, factor, y);
}

// matrix += sum of weight_i row_i row_i' of rows beside each other: what they add to a tile is on its diagonal.
inline void add_outers_beside(const Runs& rows, const Eights& weight, Band& matrix) {
  for (const Runs::Beside& set : rows.beside) {
    for (int column = 0; column < set.tiles; ++column) {
      for (int row = column; row < set.tiles; ++row) {
        const Eight* entry = rows.lanes.data() + set.start;
        Eight sum;
        for (int group = set.first; group < set.first + set.groups; ++group, entry += set.tiles) {
          for (int p = 0; p < kParts; ++p) {
            part(sum, p) += part(entry[row], p) * part(entry[column], p) * part(weight[group], p);
          }
        }
        Tile& tile = matrix.tile(set.tile + column, row - column);
        for (int c = 0; c < kLanes; ++c) tile.column[c].lane[c] += sum.lane[c];
      }
    }
  }
}

// matrix += sum of weight_i row_i row_i'.
inline void add_outers(const Runs& rows, const Eights& weight, Band& matrix) {
  for (const Runs::Set& set : rows.sets) {
    const Eight* entry = rows.entries.data() + set.start;
    for (int column = 0; column < set.tiles; ++column) {
      for (int row = column; row < set.tiles; ++row) {
        add_outers(entry + row, entry + column, set.tiles, numbers(weight) + set.first, set.rows,
                   matrix.tile(set.tile + column, row - column));
      }
    }
  }
  add_outers_beside(rows, weight, matrix);
}

// y = matrix x.
inline void multiply(const Band& matrix, const Eights& x, Eights& y) {
  for (Eight& each : y) fill(0.0, each);
  for (int k = 0; k < matrix.tiles(); ++k) {
    add_product(1.0, matrix.tile(k, 0), x[k].lane, y[k]);
    Vec terms[kLanes][kParts] = {};
    for (int down = 1; down <= matrix.last_below(k); ++down) {
      add_product(1.0, matrix.tile(k, down), x[k].lane, y[k + down]);
      add_terms(matrix.tile(k, down), x[k + down], terms);
    }
    Eight across;
    sums(terms, across.lane);
    for (int p = 0; p < kParts; ++p) part(y[k], p) += part(across, p);
  }
}

// A = L D L' in place, for A that is positive definite but for rounding. Below the diagonal are L's tiles then, and on
// it the inverses of the transposes of its own.
inline void factorise(Band& matrix, Eights& inverse) {
  Factors factor;
  Eights& diagonal = inverse;  // until a tile's turn has come
  for (int k = 0; k < matrix.tiles(); ++k) {
    for (int c = 0; c < kLanes; ++c) diagonal[k].lane[c] = matrix.tile(k, 0).column[c].lane[c];
  }
  for (int k = 0; k < matrix.tiles(); ++k) {
    const Eight entries = diagonal[k];
    eliminate(matrix.tile(k, 0), entries, factor, inverse[k]);
    Tile& unit = matrix.tile(k, 0);
    for (int c = 0; c < kLanes; ++c) {
      fill(0.0, unit.column[c]);
      unit.column[c].lane[c] = 1.0;
    }
    follow(factor, unit);
    Eight less;
    for (int p = 0; p < kParts; ++p) part(less, p) = -part(inverse[k], p);
    const int last = matrix.last_below(k);
    for (int down = 1; down <= last; ++down) {
      Tile& below = matrix.tile(k, down);  // L D, before it is scaled
      follow(factor, below);
      for (int over = 1; over <= down; ++over) {
        add_outers(below.column, matrix.tile(k, over).column, 1, less.lane, kLanes, matrix.tile(k + over, down - over));
      }
    }
    for (int down = 1; down <= last; ++down) {
      for (int c = 0; c < kLanes; ++c) {
        for (int p = 0; p < kParts; ++p) part(matrix.tile(k, down).column[c], p) *= inverse[k].lane[c];
      }
    }
  }
}

// Solve L D L' x = b in place.
inline void solve_in_place(const Band& matrix, const Eights& inverse, Eights& b) {
  for (int k = 0; k < matrix.tiles(); ++k) {
    Vec terms[kLanes][kParts] = {};
    add_terms(matrix.tile(k, 0), b[k], terms);
    sums(terms, b[k].lane);
    for (int down = 1; down <= matrix.last_below(k); ++down) {
      add_product(-1.0, matrix.tile(k, down), b[k].lane, b[k + down]);
    }
  }
  for (int k = matrix.tiles() - 1; k >= 0; --k) {
    Vec terms[kLanes][kParts] = {};
    for (int down = 1; down <= matrix.last_below(k); ++down) add_terms(matrix.tile(k, down), b[k + down], terms);
    double left[kLanes];
    sums(terms, left);
    for (int c = 0; c < kLanes; ++c) left[c] = b[k].lane[c] * inverse[k].lane[c] - left[c];
    fill(0.0, b[k]);
    add_product(1.0, matrix.tile(k, 0), left, b[k]);
  }
}
