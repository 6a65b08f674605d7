// Few boxes that contain a cloud, each little larger than the part of the cloud in it.
//
// Space is cut into cells along the directions that most of the cloud's flat parts face. Cells with a point in them, and
// those that such cells enclose, are solid; solid cells are joined to boxes, and each box shrinks to the points in it. So
// every point lies in a box, whatever the cells are; and a box holds nothing farther from a point than about a cell but
// what the cloud encloses. What is enclosed counts as solid because nothing can come there without passing the cloud.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <vector>

namespace proximity {

class CloudCover {
 public:
  using Vector3 = Eigen::Vector3d;
  using Matrix3 = Eigen::Matrix3d;

  // Around the points of one part, in the cover's axes.
  struct Piece {
    Vector3 low, high;
  };

  CloudCover() = default;
  // No pieces where there would be more than `most`, or where the cloud is wider than a grid of such cells may be.
  CloudCover(const std::vector<Vector3>& cloud, double cell, std::size_t most);

  // The cover with some pieces cut: along the longest axis, and those more than half as long, in as many parts as are no
  // shorter than an edge, but no more than `parts`.
  CloudCover cut(const std::vector<Vector3>& cloud, const std::vector<char>& chosen, double edge, int parts) const;

  // Columns: the cover's axes in the cloud's frame.
  const Matrix3& axes() const { return axes_; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  // The points in some pieces.
  std::vector<Vector3> within(const std::vector<Vector3>& cloud, const std::vector<char>& chosen) const;

 private:
  std::vector<Piece> pieces_;
  Matrix3 axes_ = Matrix3::Identity();
  std::vector<std::int32_t> piece_;  // of each point
};

}  // namespace proximity
