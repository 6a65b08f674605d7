// The motion of joints with constant jerks that stays near targets.
//
// It minimises the sum over the targets a_k of (q_k - a_k)^2, and over the times of (w j_k)^2: a linear-quadratic regulator.
// The cost from a time on is |R x - z|^2 of the state x then. In square-root form each step back is the QR decomposition of
// a few rows, so rounding is not squared, as in the Riccati recursion (Bierman, "Factorization methods for discrete
// sequential estimation", 1977). The joints share all but z.
#pragma once

#include "joint_stop.hpp"

namespace tracking {

using stopping::JointLimit, stopping::Moving, timing::Numbers;

struct Tracked {
  std::vector<Moving> rows;  // One of each joint at each time.
  Numbers jerks;             // One of each joint up to each time after the begin.
  std::size_t kept = 0;      // Targets up to the first time at which a limit is exceeded, at most those that count.
};

inline bool keeps(const Moving& at, double jerk, const JointLimit& limit) {
  return at.position >= limit.lower && at.position <= limit.upper && std::abs(at.velocity) <= limit.velocity &&
         std::abs(at.acceleration) <= limit.acceleration && std::abs(jerk) <= limit.jerk;
}

// Rows of a least-squares problem: factors of the jerk j and of the state x before it, and the right side of each joint.
class Rows {
 public:
  static constexpr std::size_t kUnknowns = 4, kRows = 5;

  explicit Rows(std::size_t joints) : table_(kRows, kUnknowns + joints) {}

  double* operator[](std::size_t row) { return table_[row]; }

  // Replace the rows after the first, with factors of the state after a step, by factors of its jerk and the state before.
  void begin_with(double h) {
    for (std::size_t row = 1; row < kRows; ++row) {
      double* at = table_[row];
      const double q = at[1], v = at[2], a = at[3];
      at[0] = h * (a + h / 2.0 * (v + h / 3.0 * q)), at[2] = v + h * q, at[3] = a + h * (v + h / 2.0 * q);
    }
  }

  // Make the rows triangular, by Givens rotations.
  void decompose() {
    for (std::size_t column = 0; column < kUnknowns; ++column)
      for (std::size_t row = kRows - 1; row > column; --row) rotate(row - 1, row, column);
  }

 private:
  void rotate(std::size_t above, std::size_t below, std::size_t column) {
    double *one = table_[above], *other = table_[below];
    if (other[column] == 0.0) return;
    const double size = std::hypot(one[column], other[column]), c = one[column] / size, s = other[column] / size;
    for (std::size_t k = column; k < table_.columns; ++k) {
      const double upper = one[k], lower = other[k];
      one[k] = c * upper + s * lower, other[k] = c * lower - s * upper;
    }
    other[column] = 0.0;
  }

  timing::Table table_;
};

// Targets of each joint, one row after the other, that are due at some of the times; the first `counted` count as kept.
inline Tracked track(const std::vector<Moving>& begin, const Numbers& times, const std::vector<std::size_t>& due,
                     const double* targets, std::size_t counted, double weight, const std::vector<JointLimit>& limits) {
  const std::size_t joints = begin.size(), width = Rows::kUnknowns + joints, count = times.size() - 1;
  Rows rows(joints);  // The first is of the jerk, the last of the target, the others of the cost after that.
  timing::Table feedback(count, width);
  for (std::size_t k = count, next = due.size(); k-- > 0;) {
    std::fill_n(rows[0], width, 0.0), std::fill_n(rows[4], width, 0.0);
    rows[0][0] = weight;
    if (next && due[next - 1] == k + 1) {
      const double* target = targets + --next * joints;
      rows[4][1] = 1.0;
      for (std::size_t j = 0; j < joints; ++j) rows[4][4 + j] = target[j] - begin[j].position;
    }
    rows.begin_with(times[k + 1] - times[k]);
    rows.decompose();
    std::copy_n(rows[0], width, feedback[k]);
  }
  Tracked found{begin, Numbers(count * joints), counted};
  found.rows.reserve((count + 1) * joints);
  for (std::size_t k = 0, reached = 0; k < count; ++k) {
    for (std::size_t j = 0; j < joints; ++j) {
      const Moving at = found.rows[k * joints + j];
      const double* row = feedback[k];
      const double state = row[1] * (at.position - begin[j].position) + row[2] * at.velocity + row[3] * at.acceleration;
      const double jerk = found.jerks[k * joints + j] = (row[4 + j] - state) / row[0];
      found.rows.push_back(at.after(times[k + 1] - times[k], jerk));
      if (!keeps(found.rows.back(), jerk, limits[j])) found.kept = std::min(found.kept, reached);
    }
    if (reached < due.size() && due[reached] == k + 1) ++reached;
  }
  return found;
}

}  // namespace tracking
