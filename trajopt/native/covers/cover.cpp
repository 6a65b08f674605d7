#include "cover.hpp"

#include <limits>
#include <map>
#include <optional>

#include "cut.hpp"

namespace covers {

namespace {

constexpr size_t kJudges = 500;       // Of the wrong points, so many tell which cuts are promising,
constexpr size_t kJury = 2000;        // and so many which of these is best.
constexpr size_t kPromising = 8;      // Cuts that are looked at again.
constexpr size_t kCoarse = 1000;      // Cuts are chosen on fewer triangles than the mesh has: about so many,
constexpr size_t kMedium = 6000;      // and so many at the second look;
constexpr double kCoarseCell = 0.25;  // with corners moved by at most so much of the tolerance,
constexpr double kMediumCell = 0.05;  // and so much,
constexpr double kLike = 0.8;         // as long as their hull holds such a share of the points that the piece's holds.
constexpr double kLittleLeft = 0.85;  // Powers of what the sides of a cut leave to be cut: below 1 one side that has
constexpr double kMuchLeft = 1.1;    // all of it is better than two with half, above 1 worse.
constexpr double kGood = 0.4;         // What a good side with all of the surface would be worth.
constexpr double kSnap = 1e-6;        // Corners this near a plane count as in it: share of the mesh's size.
constexpr double kRough = 2e-2;       // Accuracy of the hulls that choose cuts: share of the tolerance;
constexpr double kTrue = 1e-3;        // of those that tell what a piece holds.
constexpr double kNearly = 0.2;       // Points that stand out by so little more than the tolerance call for no further
                                      // cut: share of it. To be rid of the last few costs many slivers.
constexpr double kInward = 0.02;      // Points found on faces are moved inward by so much of the tolerance.
constexpr int kMostLooks = 20000;     // Places looked at on a hull's faces.
constexpr size_t kWanted = 100;       // Places too far out that are worth knowing.

struct Piece {
  Triangles fine, medium, coarse;
  Hull hull;
  Samples wrong;  // What this piece holds, and none should.
  double reach = 0.0;
};

template <class Items>
Items every(const Items& items, size_t most) {
  const size_t step = 1 + items.size() / most;
  Items some;
  for (size_t index = 0; index < items.size(); index += step) some.push_back(items[index]);
  return some;
}

Samples every(const Samples& samples, size_t most) {
  return {every(samples.points, most), every(samples.depth, most)};
}

Points all_corners(const Triangles& triangles) {
  Points corners;
  corners.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) corners.insert(corners.end(), t.begin(), t.end());
  return corners;
}

class Cutter {
 public:
  Cutter(const Triangles& triangles, const Surface& surface, const Room& room, const Options& options, double size)
      : surface_(surface), room_(room), options_(options), snap_(kSnap * size), wrong_(room.wrong) {
    bad_.push_back({triangles,
                    coarser(triangles, kMedium, kMediumCell * options.tolerance),
                    coarser(triangles, kCoarse, kCoarseCell * options.tolerance),
                    {},
                    room.wrong,
                    0.0});
    while (!bad_.empty() && static_cast<int>(bad_.size() + good_.size()) < options.most_pieces &&
           work_ < options.most_work)
      divide_worst();
    for (Piece& piece : bad_) good_.push_back(std::move(piece));
    bad_.clear();
    for (Piece& piece : good_) {
      piece.hull = hull_of(all_corners(piece.fine));
      leave(piece.hull);
    }
    merge();
  }

  std::vector<Piece>& pieces() { return good_; }


 private:
  Samples held(const Hull& hull, const Samples& samples) {
    work_ += 1.0 * samples.points.size() * hull.planes.size();
    Samples inside;
    for (size_t index = 0; index < samples.points.size(); ++index)
      if (hull.holds(samples.points[index])) inside.add(samples.points[index], samples.depth[index]);
    return inside;
  }

  // What both sides of a cut still hold of the wrong points, by depth, as a share of all: less is better. Of two cuts
  // alike that leave less than half, one with a good side is preferred to one that leaves both to be cut. From a ring or
  // a shelf no single cut takes away as much: then even halves are better than slivers, and a good side counts for
  // itself, by its share of the surface.
  std::pair<bool, double> rest(const Indexed& triangles, const Plane& plane, const Samples& wrong) {
    std::array<Side, 2> sides = clipped_corners(triangles, plane, snap_);
    const double area = sides[0].area + sides[1].area;
    std::array<double, 2> left{0.0, 0.0};
    double good = 0.0;
    for (int side = 0; side < 2; ++side) {
      if (sides[side].corners.empty()) continue;
      work_ += 50.0 * sides[side].corners.size();
      const Hull hull = hull_of(std::move(sides[side].corners), kRough * options_.tolerance);
      left[side] = held(hull, wrong).sum() / wrong.sum();
      if (left[side] == 0.0) good += sides[side].area / area;
    }
    const bool little = left[0] + left[1] > 0.5;
    const double power = little ? kMuchLeft : kLittleLeft;
    return {little, std::pow(left[0], power) + std::pow(left[1], power) - kGood * good};
  }

  std::optional<Plane> best_plane(const Piece& piece) {
    std::vector<Plane> planes = planes_worth_a_cut(piece.medium.empty() ? piece.fine : piece.medium, piece.wrong.points);
    if (planes.empty()) return std::nullopt;
    sort_by_rest(planes, representative(piece, piece.coarse), every(piece.wrong, kJudges));
    planes.resize(std::min(planes.size(), kPromising));
    sort_by_rest(planes, representative(piece, piece.medium), every(piece.wrong, kJury));
    return planes.front();
  }

  void sort_by_rest(std::vector<Plane>& planes, const Triangles& triangles, const Samples& judges) {
    const Indexed shared = indexed(triangles);
    std::vector<std::pair<std::pair<bool, double>, size_t>> rests;
    for (size_t index = 0; index < planes.size(); ++index)
      rests.emplace_back(rest(shared, planes[index], judges), index);
    std::sort(rests.begin(), rests.end());
    std::vector<Plane> sorted;
    for (const auto& [value, index] : rests) sorted.push_back(planes[index]);
    planes = std::move(sorted);
  }

  // Fewer triangles than the piece has, unless they hold too little of what is wrong with it.
  const Triangles& representative(const Piece& piece, const Triangles& fewer) {
    const Samples judges = every(piece.wrong, kJudges);
    for (const Triangles* triangles : {&fewer, &piece.medium}) {
      if (triangles->empty()) continue;
      const Hull hull = hull_of(all_corners(*triangles), kRough * options_.tolerance);
      if (static_cast<double>(held(hull, judges).points.size()) >= kLike * judges.points.size()) return *triangles;
    }
    return piece.fine;
  }

  // Replace the piece that holds most of what is wrong by both sides of its best cut.
  void divide_worst() {
    size_t worst = 0;
    for (size_t index = 1; index < bad_.size(); ++index)
      if (bad_[index].wrong.sum() > bad_[worst].wrong.sum()) worst = index;
    Piece piece = std::move(bad_[worst]);
    bad_.erase(bad_.begin() + static_cast<long>(worst));
    const std::optional<Plane> plane = best_plane(piece);
    if (!plane) return good_.push_back(std::move(piece));
    std::array<Triangles, 2> fine = clipped(piece.fine, *plane, snap_);
    std::array<Triangles, 2> medium = clipped(piece.medium, *plane, snap_);
    std::array<Triangles, 2> coarse = clipped(piece.coarse, *plane, snap_);
    const bool both = !fine[0].empty() && !fine[1].empty();
    for (int side = 0; side < 2; ++side) {
      if (fine[side].empty()) continue;
      Piece part{std::move(fine[side]), std::move(medium[side]), std::move(coarse[side]), {}, {}, 0.0};
      work_ += 50.0 * part.fine.size();
      part.hull = hull_of(all_corners(part.fine), kTrue * options_.tolerance);
      part.wrong = held(part.hull, piece.wrong);
      if (part.wrong.deepest() <= (1.0 + kNearly) * options_.tolerance) look_at_faces(part);
      (both && !part.wrong.points.empty() ? bad_ : good_).push_back(std::move(part));
    }
  }

  // What a piece holds in spite of all is no reason against a merger.
  void leave(const Hull& hull) {
    Samples left;
    for (size_t index = 0; index < wrong_.points.size(); ++index)
      if (!hull.holds(wrong_.points[index])) left.add(wrong_.points[index], wrong_.depth[index]);
    wrong_ = std::move(left);
  }

  Question question() const {
    const double most = (1.0 + kBetween) * options_.tolerance;
    return {options_.tolerance, most, kWanted, kSettled * options_.tolerance, kMostLooks};
  }

  // What stands out too far between the points looked at is wrong as well.
  void look_at_faces(Piece& part) {
    const StandOut measured = stand_out(part.hull, surface_, &room_, question());
    part.wrong = measured.beyond;
    part.reach = measured.bound;
    const Vec centre = 0.5 * (part.hull.box.low + part.hull.box.high);
    for (size_t index = 0; index < part.wrong.points.size(); ++index) {
      Vec& point = part.wrong.points[index];
      const Vec inward = centre - point;  // On the face no hull would hold it.
      point += std::min(1.0, kInward * options_.tolerance / norm(inward)) * inward;
      wrong_.add(point, part.wrong.depth[index]);
    }
  }

  struct Joint {
    double added;  // Volume.
    Hull hull;
  };

  // The common hull of two pieces, if it holds nothing wrong.
  std::optional<Joint> joined(const Piece& a, const Piece& b) {
    if (work_ >= 2.0 * options_.most_work) return std::nullopt;  // What is not merged covers as well.
    Points points = a.hull.vertices;
    points.insert(points.end(), b.hull.vertices.begin(), b.hull.vertices.end());
    work_ += 50.0 * points.size();
    Hull hull = hull_of(std::move(points));
    for (size_t index = 0; index < wrong_.points.size(); ++index)
      if (hull.holds(wrong_.points[index])) {
        work_ += 1.0 * (index + 1) * hull.planes.size();
        return std::nullopt;
      }
    work_ += 1.0 * wrong_.points.size() * hull.planes.size();
    const double added = hull.volume - a.hull.volume - b.hull.volume;
    return Joint{added, std::move(hull)};
  }

  // Replace pairs of pieces by their common hull, tightest first, while that is no worse than the pieces may be.
  void merge() {
    std::map<int, Piece> kept;
    std::map<std::pair<int, int>, Joint> joints;
    int next = 0;
    const auto add = [&](Piece piece) {
      for (const auto& [number, other] : kept)
        if (std::optional<Joint> joint = joined(other, piece)) joints.emplace(std::pair{number, next}, *joint);
      kept.emplace(next++, std::move(piece));
    };
    for (Piece& piece : good_) add(std::move(piece));
    while (!joints.empty()) {
      auto best = joints.begin();
      for (auto joint = joints.begin(); joint != joints.end(); ++joint)
        if (joint->second.added < best->second.added) best = joint;
      const auto [a, b] = best->first;
      Piece both{{}, {}, {}, std::move(best->second.hull), {}, 0.0};
      joints.erase(best);
      const StandOut measured = stand_out(both.hull, surface_, &room_, question());
      if (measured.found > question().too_far) continue;
      both.reach = measured.bound;
      for (auto joint = joints.begin(); joint != joints.end();) {
        const auto [i, j] = joint->first;
        joint = i == a || i == b || j == a || j == b ? joints.erase(joint) : std::next(joint);
      }
      kept.erase(a), kept.erase(b);
      add(std::move(both));
    }
    good_.clear();
    for (auto& [number, piece] : kept) {
      if (piece.reach == 0.0) {
        Question all = question();
        all.too_far = HUGE_VAL;
        piece.reach = stand_out(piece.hull, surface_, &room_, all).bound;
      }
      good_.push_back(std::move(piece));
    }
  }

  const Surface& surface_;
  const Room& room_;
  const Options& options_;
  double work_ = 0.0;
  double snap_;
  Samples wrong_;
  std::vector<Piece> bad_, good_;
};

}  // namespace

Cover cover(const Indexed& mesh, const std::vector<int>& parts, const Options& options) {
  const Hull hull = hull_of(mesh.corners);
  const Triangles triangles = mesh.triangles();
  const Surface surface(triangles, parts);
  Cover result;
  result.excess = std::numeric_limits<double>::quiet_NaN();
  const double tolerance = options.tolerance;
  const StandOut plain =
      stand_out(hull, surface, nullptr, {tolerance, 2.0 * tolerance, 1, kSettled * tolerance, kMostLooks});
  result.pieces.push_back(hull.vertices);
  result.reach = plain.bound;
  if (plain.bound <= tolerance) return result;
  const Room room(surface, hull, options.samples, tolerance);
  result.excess = room.excess;
  result.reach = std::max(plain.bound, room.reach);
  const double farthest = std::max(plain.found, room.reach);
  if ((room.reach <= tolerance && farthest <= (1.0 + kBetween) * tolerance) ||
      (room.excess <= options.hull_excess && farthest <= 2.0 * tolerance))
    return result;
  Cutter cutter(triangles, surface, room, options, norm(hull.box.extent()));
  result.cut = true;
  result.reach = 0.0;
  result.pieces.clear();
  for (const Piece& piece : cutter.pieces()) {
    result.reach = std::max(result.reach, piece.reach);
    result.pieces.push_back(piece.hull.vertices);
  }
  return result;
}

}  // namespace covers
