#include "cloud_axes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace proximity {

namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Index = std::array<int, 3>;

// The axes are looked for among points as far apart as this [m], no more than so many, by how sharply their places
// along a direction gather in bins of this width [m].
constexpr double kApart = 0.05, kBin = 0.005;
constexpr std::size_t kLooked = 1500;
constexpr double kBins = 2000.0;        // at most
// Where parts of the cloud face is told by those of them in cubes of so many such distances, by the fullest of these.
constexpr int kPart = 4;
constexpr std::size_t kParts = 32;
constexpr double kDegree = 3.14159265358979 / 180.0;

// Points of a part of the cloud.
struct Part {
  double count = 0.0;
  Vector3 sum = Vector3::Zero();
  Matrix3 square = Matrix3::Zero();

  void add(const Vector3& point) {
    count += 1.0;
    sum += point;
    square += point * point.transpose();
  }
  Vector3 normal() const {
    Eigen::SelfAdjointEigenSolver<Matrix3> solver;
    solver.computeDirect(square / count - sum * sum.transpose() / (count * count));
    return solver.eigenvectors().col(0);
  }
};

// Some points all over a cloud, and where parts of it face, about.
struct Overview {
  std::vector<Vector3> points, normals{Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()};

  explicit Overview(const std::vector<Vector3>& all) {
    const Bounds bounds(all);
    const double apart = std::max(kApart, std::cbrt((bounds.high - bounds.low).prod() / kMostCells));
    Index size, parts;
    for (int axis = 0; axis < 3; ++axis) {
      size[axis] = static_cast<int>((bounds.high[axis] - bounds.low[axis]) / apart) + 1;
      parts[axis] = size[axis] / kPart + 1;
    }
    std::vector<char> taken(static_cast<std::size_t>(size[0]) * size[1] * size[2], 0);
    std::vector<std::int32_t> part_at(static_cast<std::size_t>(parts[0]) * parts[1] * parts[2], -1);
    std::vector<Part> found;
    for (const Vector3& point : all) {
      Index at;
      for (int axis = 0; axis < 3; ++axis) at[axis] = static_cast<int>((point[axis] - bounds.low[axis]) / apart);
      char& known = taken[(static_cast<std::size_t>(at[2]) * size[1] + at[1]) * size[0] + at[0]];
      if (known) continue;
      known = 1;
      points.push_back(point);
      std::int32_t& part = part_at[(static_cast<std::size_t>(at[2] / kPart) * parts[1] + at[1] / kPart) * parts[0] + at[0] / kPart];
      if (part < 0) part = static_cast<std::int32_t>(found.size()), found.emplace_back();
      found[part].add(point - bounds.low);
    }
    const std::size_t fullest = std::min(found.size(), kParts);
    std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(fullest), found.end(),
                      [](const Part& one, const Part& other) { return one.count > other.count; });
    for (std::size_t part = 0; part < fullest; ++part) normals.push_back(found[part].normal());
    thin_out();
  }

 private:
  void thin_out() {
    if (points.size() <= kLooked) return;
    const double stride = static_cast<double>(points.size()) / kLooked;
    for (std::size_t at = 0; at < kLooked; ++at) points[at] = points[static_cast<std::size_t>(at * stride)];
    points.resize(kLooked);
  }
};

// How sharply places along a direction gather.
class Gathering {
 public:
  explicit Gathering(std::vector<Vector3> points) : points_(std::move(points)) {
    const Bounds bounds(points_);
    const Vector3 middle = (bounds.low + bounds.high) / 2.0;
    for (Vector3& point : points_) point -= middle;
    wide_ = (bounds.high - bounds.low).norm() / 2.0;
    bin_ = std::max(kBin, 2.0 * wide_ / kBins);
    bins_.resize(static_cast<std::size_t>(2.0 * wide_ / bin_) + 4);
  }

  double operator()(const Vector3& direction) {
    std::fill(bins_.begin(), bins_.end(), 0.0);
    for (const Vector3& point : points_) bins_[static_cast<std::size_t>((direction.dot(point) + wide_) / bin_ + 1.0)] += 1.0;
    double sum = 0.0;
    for (std::size_t bin = 1; bin + 1 < bins_.size(); ++bin) sum += bins_[bin] * (bins_[bin - 1] + bins_[bin] + bins_[bin + 1]);
    return sum;
  }

 private:
  std::vector<Vector3> points_;
  std::vector<double> bins_;
  double wide_, bin_;
};

}  // namespace

Matrix3 axes_of(const std::vector<Vector3>& cloud) {
  Overview overview(cloud);
  Gathering gathering(std::move(overview.points));
  Vector3 third = Vector3::UnitZ();
  double most = 0.0;
  const auto better = [&](const Vector3& direction) {
    const double sharp = gathering(direction);
    if (sharp <= most) return false;
    most = sharp;
    third = direction;
    return true;
  };
  for (const Vector3& normal : overview.normals) better(normal);
  for (double step = 4.0 * kDegree; step > 0.02 * kDegree; step /= 2.0) {
    const Vector3 first = third.unitOrthogonal(), second = third.cross(first), at = third;
    for (const Vector3& aside : {first, second, Vector3(-first), Vector3(-second)}) better((at + step * aside).normalized());
  }
  Vector3 first = third.unitOrthogonal();
  const Vector3 side = third.cross(first), start = first;
  const auto turned = [&](double angle) { return Vector3(std::cos(angle) * start + std::sin(angle) * side); };
  most = 0.0;
  double best = 0.0;
  const auto better_turn = [&](double angle) {
    const Vector3 one = turned(angle);
    const double sharp = gathering(one) + gathering(third.cross(one));
    if (sharp > most) most = sharp, best = angle;
  };
  for (int degrees = 0; degrees < 90; degrees += 2) better_turn(degrees * kDegree);
  for (double step = 1.0 * kDegree; step > 0.02 * kDegree; step /= 2.0) {
    const double at = best;
    better_turn(at - step);
    better_turn(at + step);
  }
  first = turned(best);
  Matrix3 axes;
  axes << first, third.cross(first), third;
  return axes;
}

}  // namespace proximity
