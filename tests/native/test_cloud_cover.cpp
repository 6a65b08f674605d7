// Boxes that contain clouds: every point is in one, and few are enough where the cloud is flat.
#include "check.hpp"
#include "proof/cloud_points.hpp"
#include "proximity/cloud_cover.hpp"

using namespace proximity;
using check::uniform;

namespace {

using Vector3 = CloudCover::Vector3;

constexpr double kRounding = 1e-12;  // Of a point that is turned here and there.

// Points on the faces of a box, turned.
void add_box(std::vector<Vector3>& points, std::mt19937& rng, const Vector3& size, const Vector3& at, int count) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.4, Vector3(0.1, 0.2, 1.0).normalized()).toRotationMatrix();
  for (int index = 0; index < count; ++index) {
    Vector3 point(uniform(rng, -0.5, 0.5), uniform(rng, -0.5, 0.5), uniform(rng, -0.5, 0.5));
    point[check::whole(rng, 0, 2)] = check::whole(rng, 0, 1) ? 0.5 : -0.5;
    points.push_back(turn * (point.cwiseProduct(size) + at));
  }
}

void contains(const CloudCover& cover, const std::vector<Vector3>& points) {
  for (const Vector3& point : points) {
    const Vector3 seen = cover.axes().transpose() * point;
    bool inside = false;
    for (const CloudCover::Piece& piece : cover.pieces()) {
      inside = inside || ((seen - piece.low).minCoeff() >= -kRounding && (piece.high - seen).minCoeff() >= -kRounding);
    }
    CHECK(inside);
  }
}

}  // namespace

TEST(every_point_is_in_a_box) {
  std::mt19937 rng(5);
  std::vector<Vector3> points;
  add_box(points, rng, {1.2, 0.8, 0.04}, {0.0, 0.0, 0.0}, 3000);
  add_box(points, rng, {0.04, 0.8, 0.5}, {0.3, 0.0, 0.25}, 2000);
  add_box(points, rng, {0.2, 0.2, 0.3}, {-0.2, 0.0, 0.2}, 1000);
  const CloudCover cover(points, 0.03, 200);
  CHECK(cover.pieces().size() >= 3 && cover.pieces().size() < 40);
  contains(cover, points);
  std::vector<char> chosen(cover.pieces().size(), 0);
  chosen[0] = 1;
  const CloudCover cut = cover.cut(points, chosen, 0.03, 4);
  CHECK(cut.pieces().size() > cover.pieces().size());
  contains(cut, points);
  std::size_t within = 0;
  for (std::size_t piece = 0; piece < cover.pieces().size(); ++piece) {
    std::fill(chosen.begin(), chosen.end(), 0);
    chosen[piece] = 1;
    within += cover.within(points, chosen).size();
  }
  CHECK(within == points.size());
}

TEST(clouds_without_width_and_clouds_too_wide_or_too_ragged) {
  std::mt19937 rng(6);
  for (const Vector3& along : {Vector3(0.0, 0.0, 0.0), Vector3(1.0, 0.0, 0.0), Vector3(0.3, 0.2, 50.0)}) {
    std::vector<Vector3> points;
    for (int index = 0; index < 500; ++index) points.push_back(Vector3(7.0, -8.0, 9.0) + uniform(rng, 0.0, 1.0) * along);
    const CloudCover cover(points, 0.03, 2000);
    if (along.norm() < 2.0) CHECK(!cover.pieces().empty());
    if (!cover.pieces().empty()) contains(cover, points);
  }
  std::vector<Vector3> ragged;
  for (int index = 0; index < 3000; ++index) ragged.emplace_back(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
  CHECK(CloudCover(ragged, 0.03, 200).pieces().empty());
  for (Vector3& point : ragged) point *= 25.0;
  CHECK(CloudCover(ragged, 0.03, 5000).pieces().empty());
}

TEST(a_tree_of_the_judge_holds_every_point_once) {
  std::mt19937 rng(7);
  for (const int count : {1, 8, 9, 100, 5000}) {
    std::vector<proof::Vec> points(count);
    // Half of them in one place: no order tells those apart.
    for (int index = 0; index < count; ++index) {
      points[index] = index % 2 ? proof::Vec(0.1, 0.2, 0.3) : proof::Vec(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, 0, 0.1));
    }
    const proof::PointTree tree(points);
    std::vector<int> open{0}, met(count, 0);
    while (!open.empty()) {
      const int part = open.back();
      open.pop_back();
      const proof::Vec middle = tree.middle(part), half = tree.half(part);
      tree.open(part, [&](int inner) {
        const proof::Vec off = (tree.middle(inner) - middle).cwiseAbs() + tree.half(inner) - half;
        CHECK(off.maxCoeff() <= (inner < tree.part_of(0) ? 1e-12 : 0.0));
        if (inner >= tree.part_of(0)) {
          ++met[inner - tree.part_of(0)];
        } else {
          open.push_back(inner);
        }
      });
    }
    for (const int times : met) CHECK(times == 1);
  }
}
