#include "surface.hpp"

#include <numeric>

namespace covers {

namespace {

constexpr int kFewTriangles = 4;

// A rotation whose axes run along nothing that a designer would draw: by angles that no drawing has.
const std::array<Vec, 3> kGeneric = [] {
  const double ca = std::cos(0.7391), sa = std::sin(0.7391), cb = std::cos(0.4127), sb = std::sin(0.4127);
  return std::array<Vec, 3>{Vec{ca, -sa * cb, sa * sb}, Vec{sa, ca * cb, -ca * sb}, Vec{0.0, sb, cb}};
}();

// Squared distance of a point to a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
double squared_distance(const Vec& p, const Triangle& t) {
  const Vec &a = t[0], &b = t[1], &c = t[2];
  const Vec ab = b - a, ac = c - a, ap = p - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return squared(ap);
  const Vec bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return squared(bp);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return squared(ap - d1 / (d1 - d3) * ab);
  const Vec cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return squared(cp);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return squared(ap - d2 / (d2 - d6) * ac);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return squared(bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b));
  const double share = 1.0 / (va + vb + vc);
  return squared(ap - vb * share * ab - vc * share * ac);
}

}  // namespace

Surface::Surface(Triangles triangles, std::vector<int> parts) {
  const int count = static_cast<int>(triangles.size());
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  Points centres(count);
  for (int index = 0; index < count; ++index) {
    const Triangle& t = triangles[index];
    centres[index] = 1.0 / 3.0 * (t[0] + t[1] + t[2]);
  }
  triangles_ = std::move(triangles);
  parts_ = std::move(parts);
  nodes_.reserve(count);
  build(order, centres, 0, count);
  Triangles sorted(count);
  std::vector<int> sorted_parts(count);
  for (int index = 0; index < count; ++index)
    sorted[index] = triangles_[order[index]], sorted_parts[index] = parts_[order[index]];
  triangles_ = std::move(sorted), parts_ = std::move(sorted_parts);
}

void Surface::build(std::vector<int>& order, const Points& centres, int begin, int end) {
  const size_t here = nodes_.size();
  nodes_.emplace_back();
  Box box, middle;
  for (int index = begin; index < end; ++index) {
    for (const Vec& corner : triangles_[order[index]]) box.add(corner);
    middle.add(centres[order[index]]);
  }
  nodes_[here].box = box;
  nodes_[here].begin = begin, nodes_[here].end = end;
  if (end - begin <= kFewTriangles) return;
  const Vec extent = middle.extent();
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const int half = begin + (end - begin) / 2;
  std::nth_element(order.begin() + begin, order.begin() + half, order.begin() + end, [&](int a, int b) {
    return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis] : a < b;
  });
  build(order, centres, begin, half);
  nodes_[here].right = static_cast<int>(nodes_.size());
  build(order, centres, half, end);
}

double Surface::distance(const Vec& point, int triangle) const {
  return std::sqrt(squared_distance(point, triangles_[triangle]));
}

Near Surface::nearest(const Vec& point, int guess) const {
  double best = HUGE_VAL;
  int found = guess;
  if (guess >= 0) best = squared_distance(point, triangles_[guess]);
  std::array<std::pair<int, double>, 64> stack;
  int depth = 0;
  stack[depth++] = {0, nodes_[0].box.squared_distance(point)};
  while (depth > 0) {
    const auto [index, bound] = stack[--depth];
    if (bound >= best) continue;
    const Node& node = nodes_[index];
    if (node.right < 0) {
      for (int triangle = node.begin; triangle < node.end; ++triangle)
        if (const double here = squared_distance(point, triangles_[triangle]); here < best)
          best = here, found = triangle;
      continue;
    }
    const double left = nodes_[index + 1].box.squared_distance(point);
    const double right = nodes_[node.right].box.squared_distance(point);
    const bool left_first = left <= right;
    stack[depth++] = left_first ? std::pair{node.right, right} : std::pair{index + 1, left};
    stack[depth++] = left_first ? std::pair{index + 1, left} : std::pair{node.right, right};
  }
  return {std::sqrt(best), found};
}

std::vector<std::uint8_t> Surface::contains(const Points& points) const {
  std::vector<std::uint8_t> inside = contains_along(0, points);
  const std::vector<std::uint8_t> second = contains_along(1, points);
  Points doubtful;
  for (size_t index = 0; index < points.size(); ++index)
    if (inside[index] != second[index]) doubtful.push_back(points[index]);
  const std::vector<std::uint8_t> third = contains_along(2, doubtful);
  size_t count = 0;
  for (size_t index = 0; index < points.size(); ++index)
    if (inside[index] != second[index]) inside[index] = third[count++];
  return inside;
}

// Points are sorted into the cells of a grid across the direction; a triangle meets those in its cells.
std::vector<std::uint8_t> Surface::contains_along(int first, const Points& points) const {
  std::vector<std::uint8_t> inside(points.size(), 0), odd(points.size(), 0);
  if (points.empty()) return inside;
  const Vec u = kGeneric[first], v = kGeneric[(first + 1) % 3], w = kGeneric[(first + 2) % 3];
  const auto turned = [&](const Vec& p) { return Vec{dot(u, p), dot(v, p), dot(w, p)}; };
  Points local(points.size());
  std::transform(points.begin(), points.end(), local.begin(), turned);
  const Box box = box_around(local);
  const int side = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(points.size())) / 1.5));
  const double step_x = (box.extent().x + 1e-12) * (1.0 + 1e-9) / side;
  const double step_y = (box.extent().y + 1e-12) * (1.0 + 1e-9) / side;
  const auto cell_x = [&](double x) {
    return static_cast<int>(std::clamp(std::floor((x - box.low.x) / step_x), -1.0, static_cast<double>(side)));
  };
  const auto cell_y = [&](double y) {
    return static_cast<int>(std::clamp(std::floor((y - box.low.y) / step_y), -1.0, static_cast<double>(side)));
  };
  const auto cell_of = [&](const Vec& p) {
    return std::clamp(cell_x(p.x), 0, side - 1) * side + std::clamp(cell_y(p.y), 0, side - 1);
  };
  std::vector<int> start(static_cast<size_t>(side) * side + 1, 0), order(points.size());
  for (const Vec& p : local) ++start[cell_of(p) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<int> filled(start.begin(), start.end() - 1);
  for (size_t index = 0; index < local.size(); ++index) order[filled[cell_of(local[index])]++] = static_cast<int>(index);

  std::vector<int> by_part;
  for (size_t index = 0; index < triangles_.size(); ++index)
    if (parts_[index] >= 0) by_part.push_back(static_cast<int>(index));
  std::stable_sort(by_part.begin(), by_part.end(), [this](int a, int b) { return parts_[a] < parts_[b]; });
  std::vector<int> touched;
  const auto close_part = [&] {
    for (const int point : touched) inside[point] |= odd[point], odd[point] = 0;
    touched.clear();
  };
  int part = -1;
  for (const int triangle : by_part) {
    if (parts_[triangle] != part) close_part(), part = parts_[triangle];
    const Vec a = turned(triangles_[triangle][0]), b = turned(triangles_[triangle][1]),
              c = turned(triangles_[triangle][2]);
    const Vec low = least(least(a, b), c), high = most(most(a, b), c);
    const int x0 = std::max(cell_x(low.x), 0), x1 = std::min(cell_x(high.x), side - 1);
    const int y0 = std::max(cell_y(low.y), 0), y1 = std::min(cell_y(high.y), side - 1);
    for (int x = x0; x <= x1; ++x) {
      if (y0 > y1) break;
      for (int slot = start[x * side + y0]; slot < start[x * side + y1 + 1]; ++slot) {
        const Vec& p = local[order[slot]];
        const double wa = (b.x - p.x) * (c.y - p.y) - (c.x - p.x) * (b.y - p.y);
        const double wb = (c.x - p.x) * (a.y - p.y) - (a.x - p.x) * (c.y - p.y);
        const double wc = (a.x - p.x) * (b.y - p.y) - (b.x - p.x) * (a.y - p.y);
        if (!((wa > 0.0 && wb > 0.0 && wc > 0.0) || (wa < 0.0 && wb < 0.0 && wc < 0.0))) continue;
        if ((wa * a.z + wb * b.z + wc * c.z) / (wa + wb + wc) <= p.z) continue;
        odd[order[slot]] ^= 1;
        touched.push_back(order[slot]);
      }
    }
  }
  close_part();
  return inside;
}

}  // namespace covers
