#include "form.hpp"

#include <cmath>
#include <limits>

namespace proof {

namespace {

Vec farthest(const Form& form, const Vec& d) {
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
    for (size_t i = 0; i < length; ++i) {
      if (along[i] > best) best = along[i], place = begin + i;
    }
  }
  return {x[place], y[place], z[place]};
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

std::shared_ptr<Form> make_hull(const double* vertices, size_t count, const int64_t* faces, size_t triangles) {
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
  return form;
}

}  // namespace proof
