// Cutting planes for the largest gap between two bodies near one direction.
//
// Along a unit direction n the gap is the least n @ w over the differences w between points of the second body and
// points of the first. So whichever differences are known, the least n @ w over them is never below the gap, and each
// direction that is measured adds the difference that decides there. Where that model is highest is found among its
// peaks: the best direction of one difference, and those where two or three of them, or the border, meet.
#pragma once

#include <array>
#include <vector>

#include "pose.hpp"

namespace proof {

class UpperModel {
 public:
  // Directions within a pyramid around `middle`, whose sides are `spread` [rad] off.
  UpperModel(const Vec& middle, double spread);

  // Add a difference [m], and forget whatever does not rise above `found` [m].
  void cut(const Vec& difference, double found);
  // No direction within the border can have a gap above what was found.
  bool exhausted() const { return peaks_.empty(); }
  // Differences that still decide somewhere.
  size_t size() const { return cuts_.size(); }
  // Where the model is highest; only while it is not exhausted.
  const Vec& highest() const;
  bool at_border(const Vec& n) const;

 private:
  struct Peak {
    Vec n;
    double height;
  };

  void add_peaks(const Vec& difference, double found);
  void consider(const Vec& direction, const Vec& difference, double found);
  bool decides(const Vec& difference) const;

  Vec middle_;
  double spread_, same_ = 0.0;
  std::array<Vec, 4> sides_;
  std::vector<Vec> cuts_, edges_;
  std::vector<Peak> peaks_;
};

}  // namespace proof
