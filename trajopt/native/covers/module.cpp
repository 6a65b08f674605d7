// Convex pieces that cover a mesh, on plain arrays: see cover.hpp.
#include <nanobind/nanobind.h>

#include "../arrays.hpp"
#include "../gil.hpp"
#include "../leaks.hpp"
#include "cover.hpp"

namespace nb = nanobind;

namespace {

nb::tuple cover(const arrays::Matrix<double>& vertices, const arrays::Matrix<std::int32_t>& faces,
                const arrays::Vector<std::int32_t>& parts, double hull_excess, double tolerance, int most_pieces,
                int samples, double most_work) {
  arrays::expect(vertices.shape(0) > 0 && vertices.shape(1) == 3, "vertices must have shape (n, 3), n > 0");
  arrays::expect(faces.shape(0) > 0 && faces.shape(1) == 3, "faces must have shape (m, 3), m > 0");
  arrays::expect(parts.shape(0) == faces.shape(0), "every face must have a part");
  arrays::expect(tolerance > 0.0 && most_pieces > 0 && samples > 0, "bad options");
  covers::Indexed given;
  for (size_t index = 0; index < vertices.shape(0); ++index)
    given.corners.push_back({vertices(index, 0), vertices(index, 1), vertices(index, 2)});
  for (size_t index = 0; index < faces.shape(0); ++index) {
    given.faces.push_back({faces(index, 0), faces(index, 1), faces(index, 2)});
    for (const int corner : given.faces.back())
      arrays::expect(corner >= 0 && corner < static_cast<int>(vertices.shape(0)), "a face has no such vertex");
  }
  const std::vector<int> part(parts.data(), parts.data() + parts.shape(0));
  covers::Cover made;
  {
    gil::Released released;
    made = covers::cover(given, part, {hull_excess, tolerance, most_pieces, samples, most_work});
  }
  std::vector<double> points;
  std::vector<std::int64_t> ends;
  for (const covers::Points& piece : made.pieces) {
    for (const covers::Vec& point : piece) points.insert(points.end(), {point.x, point.y, point.z});
    ends.push_back(static_cast<std::int64_t>(points.size() / 3));
  }
  const size_t count = points.size() / 3, pieces = ends.size();
  return nb::make_tuple(arrays::hand_over(std::move(points), {count, 3}), arrays::hand_over(std::move(ends), {pieces}),
                        made.cut, made.excess, made.reach);
}

}  // namespace

NB_MODULE(covers, module) {
  leaks::settle();
  module.attr("THICKNESS") = covers::kThickness;
  module.attr("FARTHEST") = covers::kFarthest;
  module.def("cover", &cover, nb::arg("vertices"), nb::arg("faces"), nb::arg("parts"), nb::arg("hull_excess"),
             nb::arg("tolerance"), nb::arg("most_pieces"), nb::arg("samples"), nb::arg("most_work"));
}
