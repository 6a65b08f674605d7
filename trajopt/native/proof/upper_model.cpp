#include "upper_model.hpp"

#include <algorithm>
#include <cmath>

namespace proof {

namespace {

constexpr double rounding = 1e-13;     // Of products with differences, relative to the longest of them.
constexpr double border_share = 1e-3;  // Of the spread: nearer to a side than this is at the border.

template <class Each, class Condition>
void erase_if(std::vector<Each>& all, Condition condition) {
  all.erase(std::remove_if(all.begin(), all.end(), condition), all.end());
}

}  // namespace

UpperModel::UpperModel(const Vec& middle, double spread) : middle_(middle), spread_(spread) {
  const Vec across = middle.unitOrthogonal(), up = middle.cross(across);
  const double tilt = std::sin(spread), lean = std::cos(spread);
  sides_ = {tilt * middle + lean * across, tilt * middle - lean * across, tilt * middle + lean * up,
            tilt * middle - lean * up};
}

void UpperModel::cut(const Vec& difference, double found) {
  same_ = std::max(same_, rounding * difference.norm());
  erase_if(peaks_, [&](const Peak& peak) {
    return peak.height <= found || peak.n.dot(difference) < peak.height - same_;
  });
  add_peaks(difference, found);
  cuts_.push_back(difference);
  // What decides at no peak decides nowhere above `found`: its own highest place would be a peak.
  erase_if(cuts_, [&](const Vec& each) { return !decides(each); });
}

const Vec& UpperModel::highest() const {
  return std::max_element(peaks_.begin(), peaks_.end(), [](const Peak& a, const Peak& b) {
           return a.height < b.height;
         })->n;
}

bool UpperModel::at_border(const Vec& n) const {
  return std::any_of(sides_.begin(), sides_.end(), [&](const Vec& side) { return side.dot(n) < border_share * spread_; });
}

void UpperModel::add_peaks(const Vec& difference, double found) {
  // Normals of the planes in which another difference, or the border, meets this one.
  edges_.assign(sides_.begin(), sides_.end());
  for (const Vec& each : cuts_) {
    if (each != difference) edges_.push_back(each - difference);
  }
  consider(difference, difference, found);
  for (size_t i = 0; i < edges_.size(); ++i) {
    const Vec& edge = edges_[i];
    consider(difference - edge * (edge.dot(difference) / edge.squaredNorm()), difference, found);
    for (size_t j = 0; j < i; ++j) consider(edge.cross(edges_[j]), difference, found);
  }
}

// Keep a direction of any length and sign if it lies within the border and the model there is the new difference.
void UpperModel::consider(const Vec& direction, const Vec& difference, double found) {
  const double length = direction.norm();
  if (!(length > 0.0)) return;
  const Vec n = direction / (direction.dot(middle_) < 0.0 ? -length : length);
  const double height = n.dot(difference);
  if (!(height > found)) return;
  for (const Vec& side : sides_) {
    if (side.dot(n) < -rounding) return;
  }
  for (const Vec& each : cuts_) {
    if (each.dot(n) < height - same_) return;
  }
  peaks_.push_back({n, height});
}

bool UpperModel::decides(const Vec& difference) const {
  return std::any_of(peaks_.begin(), peaks_.end(), [&](const Peak& peak) {
    return peak.n.dot(difference) <= peak.height + same_;
  });
}

}  // namespace proof
