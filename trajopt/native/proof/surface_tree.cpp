#include "surface_tree.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace proof {

namespace {

constexpr double far_factor = 3.0;  // Farther than so many radii a node's triangles act as one.

// Source: van Oosterom and Strackee, IEEE Trans. Biomedical Engineering, 1983.
double triangle_angle(const std::array<Vec, 3>& corners, const Vec& point) {
  const Vec a = corners[0] - point, b = corners[1] - point, c = corners[2] - point;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2.0 * std::atan2(a.dot(b.cross(c)), rest);
}

}  // namespace

SurfaceTree::SurfaceTree(Triangles triangles) {
  nodes.reserve(2 * triangles.size());
  build(triangles, 0, triangles.size());
}

int SurfaceTree::build(Triangles& triangles, size_t begin, size_t end) {
  const int number = int(nodes.size());
  nodes.emplace_back();
  Node node;
  Vec mean = Vec::Zero(), low = Vec::Constant(std::numeric_limits<double>::infinity()), high = -low;
  double weight = 0.0;
  for (size_t i = begin; i < end; ++i) {
    const auto& t = triangles[i];
    const Vec area = (t[1] - t[0]).cross(t[2] - t[0]) / 2.0, middle = (t[0] + t[1] + t[2]) / 3.0;
    node.area += area;
    node.middle += area.norm() * middle;
    weight += area.norm();
    mean += middle;
  }
  mean /= double(end - begin);
  node.middle = weight > 0.0 ? Vec(node.middle / weight) : mean;
  Mat spread = Mat::Zero();
  for (size_t i = begin; i < end; ++i) {
    for (const Vec& corner : triangles[i]) {
      spread += (corner - mean) * (corner - mean).transpose();
      node.radius = std::max(node.radius, (corner - node.middle).norm());
    }
  }
  node.axes = Eigen::SelfAdjointEigenSolver<Mat>(spread).eigenvectors();
  for (size_t i = begin; i < end; ++i) {
    for (const Vec& corner : triangles[i]) {
      const Vec local = node.axes.transpose() * corner;
      low = low.cwiseMin(local), high = high.cwiseMax(local);
    }
  }
  node.centre = node.axes * ((low + high) / 2.0);
  node.half = (high - low) / 2.0;
  if (end - begin == 1) {
    node.corners = triangles[begin];
  } else {
    Eigen::Index axis;
    node.half.maxCoeff(&axis);
    const Vec along = node.axes.col(axis);
    const size_t middle = begin + (end - begin) / 2;
    auto before = [&](const auto& s, const auto& t) {
      return along.dot(s[0] + s[1] + s[2]) < along.dot(t[0] + t[1] + t[2]);
    };
    std::nth_element(triangles.begin() + begin, triangles.begin() + middle, triangles.begin() + end, before);
    node.left = build(triangles, begin, middle);
    node.right = build(triangles, middle, end);
  }
  nodes[number] = node;
  return number;
}

Vec SurfaceTree::support(int number, const Vec& direction) const {
  const Node& node = nodes[number];
  if (node.leaf()) {
    const double a = direction.dot(node.corners[0]), b = direction.dot(node.corners[1]);
    const double c = direction.dot(node.corners[2]);
    return node.corners[a >= b ? (a >= c ? 0 : 2) : (b >= c ? 1 : 2)];
  }
  const Vec local = node.axes.transpose() * direction;
  const Vec corner(std::copysign(node.half.x(), local.x()), std::copysign(node.half.y(), local.y()),
                   std::copysign(node.half.z(), local.z()));
  return node.centre + node.axes * corner;
}

double SurfaceTree::solid_angle(const Vec& point, double factor) const {
  double angle = 0.0;
  std::vector<int> open{0};
  while (!open.empty()) {
    const Node& node = nodes[open.back()];
    open.pop_back();
    const Vec between = node.middle - point;
    const double distance = between.norm();
    if (node.leaf()) {
      angle += triangle_angle(node.corners, point);
    } else if (distance > factor * node.radius) {
      angle += node.area.dot(between) / (distance * distance * distance);
    } else {
      open.push_back(node.left);
      open.push_back(node.right);
    }
  }
  return angle;
}

bool SurfaceTree::encloses(const Vec& point) const {
  const Node& root = nodes[0];
  const Vec local = (root.axes.transpose() * (point - root.centre)).cwiseAbs();
  if ((local.array() > root.half.array()).any()) return false;
  const double coarse = solid_angle(point, far_factor);
  if (coarse < pi || coarse > 3.0 * pi) return coarse > 2.0 * pi;
  return solid_angle(point, std::numeric_limits<double>::infinity()) > 2.0 * pi;
}

}  // namespace proof
