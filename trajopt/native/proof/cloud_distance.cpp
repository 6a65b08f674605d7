#include "cloud_distance.hpp"

#include <algorithm>
#include <vector>

#include "coal_depth.hpp"
#include "cloud_points.hpp"

namespace proof {

namespace {

constexpr size_t most_directions = 6;  // Kept of those along which single balls or cubes were apart.

struct Entry {
  double bound;  // The part's distance is no less.
  int part;
  bool operator<(const Entry& other) const { return bound > other.bound; }  // The nearest is on top.
};

// Bounds of the distances of parts of a cloud to a form at its place.
class Bounds {
 public:
  Bounds(const Form& cloud, const Pose& cloud_at, const Form& other, const Pose& other_at)
      : cloud_(cloud), seen_(other_at.inverse() * cloud_at), spread_(seen_.R.cwiseAbs()), middle_((other.low + other.high) / 2.0),
        half_((other.high - other.low) / 2.0 + spread_ * cloud.half) {}

  // By the boxes of both: apart by the distance of the boxes, or in each other by no more than the way out.
  double of(int part) const {
    const Vec at = seen_ * cloud_.points->middle(part) - middle_;
    const Vec apart = at.cwiseAbs() - half_ - spread_ * cloud_.points->half(part);
    const double most = apart.maxCoeff();
    double bound = (most > 0.0 ? apart.cwiseMax(0.0).norm() : most) - cloud_.rounding;
    for (const auto& [along, offset] : directions_) {
      bound = std::max(bound, offset + along.dot(cloud_.points->middle(part)) - along.cwiseAbs().dot(cloud_.points->half(part)));
    }
    return bound;
  }

  // All parts are at `gap + along . (p - point)` at least, in the cloud's frame.
  void note(const Vec& along, double gap, const Vec& point) {
    const std::pair<Vec, double> direction{along, gap - along.dot(point)};
    if (directions_.size() < most_directions) {
      directions_.push_back(direction);
    } else {
      directions_[next_++ % most_directions] = direction;
    }
  }

 private:
  const Form& cloud_;
  const Pose seen_;
  const Mat spread_;
  const Vec middle_, half_;
  std::vector<std::pair<Vec, double>> directions_;
  size_t next_ = 0;
};

}  // namespace

double cloud_distance(const Form& cloud, const Pose& cloud_at, const Form& other, const Pose& other_at, double within,
                      ConvexDistance measure) {
  if (other.points != nullptr && other.points->size() < cloud.points->size()) {
    return cloud_distance(other, other_at, cloud, cloud_at, within, measure);
  }
  Bounds bounds(cloud, cloud_at, other, other_at);
  double best = within;
  Vec guess = Vec::Zero();
  std::vector<Entry> open{{bounds.of(0), 0}};
  while (!open.empty() && open.front().bound < best) {
    const int part = open.front().part;
    std::pop_heap(open.begin(), open.end());
    open.pop_back();
    const double bound = bounds.of(part);
    if (bound >= best) continue;
    const bool opened = cloud.points->open(part, [&](int inner) {
      const double apart = std::max(bound, bounds.of(inner));
      if (apart >= best) return;
      open.push_back({apart, inner});
      std::push_heap(open.begin(), open.end());
    });
    if (opened) continue;
    const Vec& point = cloud.points->middle(part);
    const Pose at{cloud_at.R, cloud_at * point};
    if (other.points != nullptr) {
      best = std::min(best, cloud_distance(other, other_at, *cloud.element, at, best, measure));
      continue;
    }
    best = std::min(best, measure(*cloud.element, at, other, other_at, guess, best));
    const double length = guess.norm();
    if (length < 0.5) continue;
    // The gap along the direction that was found: proven, whatever found it.
    const Vec n = guess / length;
    bounds.note(-(cloud_at.R.transpose() * n), gap_along(*cloud.element, at, other, other_at, n), point);
  }
  return best;
}

}  // namespace proof
