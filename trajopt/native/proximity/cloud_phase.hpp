// Signed distances of a cloud and another body: the nearest ball or cube before each part of the body's sides.
//
// A part of the tree is bounded by the box around the body, as the body sees it: apart by the distance of both, or inside
// by no more than the way out of the box. Every ball or cube that was measured tells a direction besides along which
// all others are at least so far: d(p) >= d(p0) + n . (p - p0). What neither excludes is measured as a body of its own,
// by the same means as any other. Nothing hangs on what was asked before.
#pragma once

#include <memory>
#include <vector>

#include "narrow.hpp"

namespace proximity {

class CloudPhase {
 public:
  explicit CloudPhase(NarrowPhase& narrow);
  ~CloudPhase();

  // Of a pair of which one is a cloud at least: what is nearer than a reach, the nearest first, one for each quarter of a
  // side of the other body's box and six at most. Empty where nothing is; `beyond` is then no more than the distance.
  const std::vector<Nearest>& rows(const Body& a, const coal::Transform3s& at_a, const Body& b, const coal::Transform3s& at_b,
                                   double reach);
  double beyond() const;

  // Whether everything keeps at least a reach. `known`: the ball or cube that did not at last, -1 for none.
  bool keeps(const Body& a, const coal::Transform3s& at_a, const Body& b, const coal::Transform3s& at_b, double reach, int& known);

  // What was done, added to that of its owner, and forgotten.
  void tell(Work& work);

 private:
  class Search;
  std::unique_ptr<Search> search_;
};

}  // namespace proximity
