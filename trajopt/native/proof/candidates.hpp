// Which pairs may be near each other: what stands still is found by a tree, the others are few and listed.
#pragma once

#include "obstacle_tree.hpp"

namespace proof {

class Candidates {
 public:
  // Pairs in `listed` are always looked at one by one.
  Candidates(const Bodies& bodies, const std::vector<char>& listed);

  const std::vector<int>& listed() const { return listed_; }
  const std::vector<int>& movers() const { return movers_; }
  // The largest error of the others [m], by which their boxes may be nearer than they look.
  double reserve() const { return reserve_; }

  // Call take(pair) for every unlisted pair of a mover whose obstacle's box is within a distance of a point. Returns a
  // lower bound of the distance of the point from all other obstacles [m].
  template <typename Take>
  double visit(int mover, const Vec& point, double within, Take take) const {
    const int* row = &pair_of_[size_t(row_of_[mover]) * bodies_.bodies.size()];
    return tree_.visit(point, within, [&](int body) {
      if (row[body] >= 0) take(row[body]);
    });
  }

 private:
  const Bodies& bodies_;
  ObstacleTree tree_;
  std::vector<int> listed_, movers_, row_of_, pair_of_;
  double reserve_ = 0.0;
};

}  // namespace proof
