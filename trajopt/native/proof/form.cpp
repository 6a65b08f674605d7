#include "form.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cloud_points.hpp"

namespace proof {

namespace {

constexpr size_t large_hull = 256;  // With more vertices it is faster to climb along edges.

Vec vertex(const Form& form, int i) { return {form.x[i], form.y[i], form.z[i]}; }

int octant(const Vec& d) { return (d.x() > 0.0) + 2 * (d.y() > 0.0) + 4 * (d.z() > 0.0); }

// On a convex hull the farthest vertex among all is the one from which no edge leads farther.
Vec climb(const Form& form, const Vec& d) {
  int at = form.corners[octant(d)];
  double height = d.dot(vertex(form, at));
  for (int best = -1; best != at;) {
    best = at;
    for (int i = form.first_neighbour[best]; i < form.first_neighbour[best + 1]; ++i) {
      const double other = d.dot(vertex(form, form.neighbours[i]));
      if (other > height) height = other, at = form.neighbours[i];
    }
  }
  return vertex(form, at);
}

Vec farthest(const Form& form, const Vec& d) {
  if (!form.neighbours.empty()) return climb(form, d);
  const size_t count = form.x.size();
  const double *x = form.x.data(), *y = form.y.data(), *z = form.z.data();
  const double dx = d.x(), dy = d.y(), dz = d.z();
  // Blocks keep the comparison out of the multiplications, which the compiler then vectorises.
  constexpr size_t block = 16;
  double best = -std::numeric_limits<double>::infinity(), along[block];
  size_t place = 0;
  for (size_t begin = 0; begin < count; begin += block) {
    const size_t length = std::min(block, count - begin);
    for (size_t i = 0; i < length; ++i) along[i] = dx * x[begin + i] + dy * y[begin + i] + dz * z[begin + i];
    double most[2] = {best, best};
    for (size_t i = 0; i + 1 < length; i += 2) {
      for (size_t lane = 0; lane < 2; ++lane) most[lane] = along[i + lane] > most[lane] ? along[i + lane] : most[lane];
    }
    if (!(std::max({most[0], most[1], along[length - 1]}) > best)) continue;
    for (size_t i = 0; i < length; ++i) {
      if (along[i] > best) best = along[i], place = begin + i;
    }
  }
  return vertex(form, int(place));
}

void join_neighbours(Form& form) {
  const size_t count = form.x.size();
  std::array<int, 8> corners{};
  for (int i = 0; i < 8; ++i) {
    const Vec d(i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0);
    for (size_t v = 0; v < count; ++v) {
      if (d.dot(vertex(form, int(v))) > d.dot(vertex(form, corners[i]))) corners[i] = int(v);
    }
  }
  form.corners = corners;
  // In a closed surface every edge is met once in each direction.
  std::vector<int> first(count + 1, 0);
  for (const auto& face : form.faces) {
    for (int i = 0; i < 3; ++i) ++first[size_t(face[i]) + 1];
  }
  for (size_t v = 0; v < count; ++v) first[v + 1] += first[v];
  std::vector<int> place(first.begin(), first.end() - 1), neighbours(first.back());
  for (const auto& face : form.faces) {
    for (int i = 0; i < 3; ++i) neighbours[size_t(place[face[i]]++)] = face[(i + 1) % 3];
  }
  form.first_neighbour = std::move(first);
  form.neighbours = std::move(neighbours);
}

Vec on_rim(const Vec& d, double radius, double z) {
  const double across = std::hypot(d.x(), d.y());
  if (across == 0.0) return {0.0, 0.0, z};
  return {radius * d.x() / across, radius * d.y() / across, z};
}

}  // namespace

Vec Form::core_support(const Vec& d) const {
  switch (kind) {
    case Kind::Box:
      return {std::copysign(half.x(), d.x()), std::copysign(half.y(), d.y()), std::copysign(half.z(), d.z())};
    case Kind::Sphere:
      return Vec::Zero();
    case Kind::Cylinder:
      return on_rim(d, half.x(), std::copysign(half.z(), d.z()));
    case Kind::Capsule:
      return {0.0, 0.0, std::copysign(half.z(), d.z())};
    case Kind::Cone: {
      const double across = std::hypot(d.x(), d.y());
      if (2.0 * d.z() * half.z() >= across * half.x()) return {0.0, 0.0, half.z()};
      return on_rim(d, half.x(), -half.z());
    }
    case Kind::Convex:
      return farthest(*this, d);
    case Kind::Mesh:
      return farthest(*hull, d);
    case Kind::Cloud:
      return points->farthest(d) + Vec(std::copysign(half.x(), d.x()), std::copysign(half.y(), d.y()), std::copysign(half.z(), d.z()));
    case Kind::Plane:
      break;
  }
  return Vec::Constant(std::numeric_limits<double>::infinity());
}

std::shared_ptr<Form> make_solid(Kind kind, const Vec& half) {
  auto form = std::make_shared<Form>();
  form->kind = kind;
  form->half = half;
  form->high = half;
  form->radius = half.norm();
  if (kind == Kind::Sphere) {
    form->rounding = form->radius = half.x();
    form->high = Vec::Constant(half.x());
  } else if (kind == Kind::Capsule) {
    form->rounding = half.x();
    form->radius = half.x() + half.z();
    form->high.z() += half.x();
  } else if (kind == Kind::Cylinder || kind == Kind::Cone) {
    form->radius = std::hypot(half.x(), half.z());
  } else if (kind == Kind::Plane) {
    form->radius = std::numeric_limits<double>::infinity();
    form->high = Vec::Constant(form->radius);
  }
  form->low = -form->high;
  form->representatives = {Vec::Zero()};
  return form;
}

std::shared_ptr<Form> make_cloud(std::vector<Vec> points, std::shared_ptr<const Form> element) {
  auto form = std::make_shared<Form>();
  form->kind = Kind::Cloud;
  form->rounding = element->rounding;
  if (element->kind == Kind::Box) form->half = element->half;
  form->low = form->high = points[0];
  for (const Vec& point : points) form->low = form->low.cwiseMin(point), form->high = form->high.cwiseMax(point);
  form->low -= element->high;
  form->high += element->high;
  form->centre = (form->low + form->high) / 2.0;
  for (const Vec& point : points) form->radius = std::max(form->radius, (point - form->centre).norm());
  form->radius += element->radius;
  form->representatives = points;
  form->points = std::make_shared<const PointTree>(std::move(points));
  form->element = std::move(element);
  return form;
}

std::shared_ptr<Form> make_hull(const double* vertices, size_t count, const int64_t* faces, size_t triangles,
                                bool closed) {
  auto form = std::make_shared<Form>();
  form->kind = Kind::Convex;
  form->low = Vec::Constant(std::numeric_limits<double>::infinity());
  form->high = -form->low;
  Vec sum = Vec::Zero();
  for (size_t i = 0; i < count; ++i) {
    const Vec v(vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]);
    form->x.push_back(v.x()), form->y.push_back(v.y()), form->z.push_back(v.z());
    form->low = form->low.cwiseMin(v), form->high = form->high.cwiseMax(v);
    sum += v;
  }
  form->centre = (form->low + form->high) / 2.0;
  for (size_t i = 0; i < count; ++i) {
    const Vec v(form->x[i], form->y[i], form->z[i]);
    form->radius = std::max(form->radius, (v - form->centre).norm());
  }
  for (size_t i = 0; i < triangles; ++i) {
    form->faces.emplace_back(int(faces[3 * i]), int(faces[3 * i + 1]), int(faces[3 * i + 2]));
  }
  form->representatives = {sum / double(count)};
  if (count > large_hull && closed) join_neighbours(*form);
  return form;
}

}  // namespace proof
