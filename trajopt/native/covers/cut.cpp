#include "cut.hpp"

#include <cstdint>
#include <numeric>
#include <unordered_map>

namespace covers {

namespace {

constexpr int kFacePlanes = 12;   // The largest faces, at which cuts are tried.
constexpr int kFaceNormals = 4;   // Of these, those along whose normals cuts are swept too.
constexpr int kOffsets = 5;       // Along each normal.
constexpr double kParallel = 0.9998;  // Cosine of a degree: cuts along two such normals are the same cuts.
constexpr double kEdge = 1e-3;    // A plane with less of the triangles beyond it cuts nothing: share of their size.
constexpr double kNoArea = 1e-14; // Twice the area of triangles that have no normal [m^2].

// Faces alike: normals and offsets in the same bins, a fiftieth of a unit and a five-hundredth of the size wide.
struct FaceBin {
  std::array<long, 4> key;
  double area;
  Plane plane;
};

std::vector<Plane> largest_faces(const Triangles& triangles, double size) {
  std::vector<FaceBin> bins;
  for (const Triangle& t : triangles) {
    const Vec normal = cross(t[1] - t[0], t[2] - t[0]);
    const double area = norm(normal);
    if (area <= kNoArea) continue;
    const Vec unit = 1.0 / area * normal;
    const double offset = dot(unit, t[0]);
    bins.push_back({{std::lround(50.0 * unit.x), std::lround(50.0 * unit.y), std::lround(50.0 * unit.z),
                     std::lround(500.0 / size * offset)},
                    area,
                    {unit, offset}});
  }
  std::stable_sort(bins.begin(), bins.end(), [](const FaceBin& a, const FaceBin& b) { return a.key < b.key; });
  std::vector<FaceBin> faces;
  for (const FaceBin& bin : bins) {
    if (faces.empty() || faces.back().key != bin.key)
      faces.push_back(bin);
    else
      faces.back().area += bin.area;
  }
  std::stable_sort(faces.begin(), faces.end(), [](const FaceBin& a, const FaceBin& b) { return a.area > b.area; });
  std::vector<Plane> planes;
  for (size_t index = 0; index < std::min<size_t>(faces.size(), kFacePlanes); ++index)
    planes.push_back(faces[index].plane);
  return planes;
}

}  // namespace

std::array<Triangles, 2> clipped(const Triangles& triangles, const Plane& plane, double snap) {
  std::array<Triangles, 2> sides;
  Triangles flat;
  for (const Triangle& t : triangles) {
    std::array<double, 3> height;
    int before = 0, behind = 0;
    for (int corner = 0; corner < 3; ++corner) {
      height[corner] = plane.height(t[corner]);
      if (std::abs(height[corner]) <= snap) height[corner] = 0.0;
      before += height[corner] > 0.0, behind += height[corner] < 0.0;
    }
    if (before == 0 && behind == 0) {
      flat.push_back(t);
    } else if (before == 0 || behind == 0) {
      sides[before > 0].push_back(t);
    } else {
      int lone = 0;  // The corner that is alone on its side.
      for (int corner = 1; corner < 3; ++corner)
        if (before > behind ? height[corner] < height[lone] : height[corner] > height[lone]) lone = corner;
      const Vec &a = t[lone], &b = t[(lone + 1) % 3], &c = t[(lone + 2) % 3];
      const double high = height[lone], at_b = height[(lone + 1) % 3], at_c = height[(lone + 2) % 3];
      const Vec on_b = a + high / (high - at_b) * (b - a), on_c = a + high / (high - at_c) * (c - a);
      const bool up = high > 0.0;
      sides[up].push_back({a, on_b, on_c});
      sides[!up].push_back({on_b, b, c});
      sides[!up].push_back({on_b, c, on_c});
    }
  }
  const bool any_behind = !sides[0].empty(), any_before = !sides[1].empty();
  for (const Triangle& t : flat) {
    const bool along = dot(cross(t[1] - t[0], t[2] - t[0]), plane.normal) >= 0.0;
    const bool is_behind = any_behind != any_before ? any_before : along;
    sides[is_behind ? 0 : 1].push_back(t);
  }
  return sides;
}

Indexed indexed(const Triangles& triangles) {
  std::vector<std::pair<Vec, int>> all;
  all.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (const Vec& corner : t) all.emplace_back(corner, static_cast<int>(all.size()));
  std::sort(all.begin(), all.end(), [](const auto& one, const auto& other) {
    const Vec &a = one.first, &b = other.first;
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z != b.z ? a.z < b.z : one.second < other.second;
  });
  Indexed result;
  result.faces.resize(triangles.size());
  for (const auto& [corner, place] : all) {
    if (result.corners.empty() || !(result.corners.back() == corner)) result.corners.push_back(corner);
    result.faces[place / 3][place % 3] = static_cast<int>(result.corners.size()) - 1;
  }
  return result;
}

std::array<Side, 2> clipped_corners(const Indexed& triangles, const Plane& plane, double snap) {
  std::vector<double> height(triangles.corners.size());
  std::vector<std::array<bool, 2>> is_in(triangles.corners.size(), {false, false});
  bool any[2] = {false, false};
  for (size_t index = 0; index < height.size(); ++index) {
    height[index] = plane.height(triangles.corners[index]);
    if (std::abs(height[index]) <= snap) height[index] = 0.0;
    if (height[index] != 0.0) any[height[index] > 0.0] = true;
  }
  std::array<Side, 2> sides;
  for (const auto& face : triangles.faces) {
    bool beyond[2] = {false, false};
    for (const int corner : face)
      if (height[corner] != 0.0) beyond[height[corner] > 0.0] = true;
    const Vec &a = triangles.corners[face[0]], &b = triangles.corners[face[1]], &c = triangles.corners[face[2]];
    const Vec normal = cross(b - a, c - a);
    const double area = norm(normal);
    if (beyond[0] && beyond[1]) {
      double tip = area;  // Of the corner that is alone on its side.
      int up = 0;
      for (const int corner : face) up += height[corner] > 0.0 ? 1 : height[corner] < 0.0 ? -1 : 0;
      const bool lone = up <= 0;  // It is before the plane.
      for (int side = 0; side < 3; ++side) {
        const int corner = face[side], after = face[(side + 1) % 3];
        const double here = height[corner], there = height[after];
        if (here != 0.0) is_in[corner][here > 0.0] = true;
        if (here == 0.0) is_in[corner] = {true, true};
        if (!((here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0))) continue;
        const double share = here / (here - there);
        const Vec between =
            triangles.corners[corner] + share * (triangles.corners[after] - triangles.corners[corner]);
        sides[0].corners.push_back(between), sides[1].corners.push_back(between);
        tip *= (here > 0.0) == lone ? share : 1.0 - share;
      }
      sides[lone].area += tip, sides[!lone].area += area - tip;
      continue;
    }
    if (!beyond[0] && !beyond[1]) {  // In the plane.
      const bool along = dot(normal, plane.normal) >= 0.0;
      beyond[(any[0] != any[1] ? any[1] : along) ? 0 : 1] = true;
    }
    sides[beyond[1]].area += area;
    for (const int corner : face) is_in[corner][beyond[1]] = true;
  }
  for (size_t index = 0; index < height.size(); ++index)
    for (int side = 0; side < 2; ++side)
      if (is_in[index][side]) sides[side].corners.push_back(triangles.corners[index]);
  return sides;
}

std::vector<Plane> planes_worth_a_cut(const Triangles& triangles, const Points& wrong) {
  const Points corners = indexed(triangles).corners;
  const Vec extent = box_around(corners).extent();
  const double size = std::max({extent.x, extent.y, extent.z});
  std::vector<Plane> planes = largest_faces(triangles, size);
  const size_t faces = planes.size();
  Points normals;
  const auto sweep_along = [&normals](const Vec& normal) {
    const auto alike = [&normal](const Vec& other) { return std::abs(dot(normal, other)) > kParallel; };
    if (std::none_of(normals.begin(), normals.end(), alike)) normals.push_back(normal);
  };
  for (const Vec& axis : {Vec{1.0, 0.0, 0.0}, Vec{0.0, 1.0, 0.0}, Vec{0.0, 0.0, 1.0}}) sweep_along(axis);
  for (size_t face = 0; face < std::min<size_t>(faces, kFaceNormals); ++face) sweep_along(planes[face].normal);
  for (const Vec& axis : principal_axes(corners)) sweep_along(axis);
  std::vector<std::array<double, 2>> range;
  for (const Vec& normal : normals) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Vec& point : wrong) low = std::min(low, dot(normal, point)), high = std::max(high, dot(normal, point));
    range.push_back({low, high});
  }
  for (int count = 0; count < kOffsets; ++count)
    for (size_t index = 0; index < normals.size(); ++index) {
      const auto [low, high] = range[index];
      planes.push_back({normals[index], low + count / (kOffsets - 1.0) * (high - low)});
    }
  std::vector<Plane> worth;
  for (size_t index = 0; index < planes.size(); ++index) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Vec& corner : corners) {
      const double height = planes[index].height(corner);
      low = std::min(low, height), high = std::max(high, height);
    }
    const bool behind = low < -kEdge * size, before = high > kEdge * size;
    if ((behind && before) || (index < faces && (behind || before))) worth.push_back(planes[index]);
  }
  return worth;
}

Triangles coarser(const Triangles& triangles, size_t most, double largest_cell) {
  Triangles left = triangles;
  Box box;
  for (const Triangle& t : triangles)
    for (const Vec& corner : t) box.add(corner);
  for (double cell = largest_cell / 8.0; left.size() > most && cell <= largest_cell; cell *= 2.0) {
    std::unordered_map<std::uint64_t, Vec> first;
    const auto moved = [&](const Vec& corner) {
      std::uint64_t key = 0;  // 21 bits an axis: cells beyond are counted from the start again.
      for (int axis = 0; axis < 3; ++axis)
        key = (key << 21) | (static_cast<std::uint64_t>((corner[axis] - box.low[axis]) / cell) & 0x1fffff);
      return first.try_emplace(key, corner).first->second;
    };
    left.clear();
    for (const Triangle& t : triangles) {
      const Triangle other{moved(t[0]), moved(t[1]), moved(t[2])};
      if (!(other[0] == other[1] || other[1] == other[2] || other[2] == other[0])) left.push_back(other);
    }
  }
  return left.empty() ? triangles : left;
}

}  // namespace covers
