// The judge's native core: what is bound here has a body in plain Python of the same results in trajopt.verify.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include "../coal_boxes.hpp"
#include "../gil.hpp"
#include "../leaks.hpp"
#include "binding.hpp"
#include "clearance_search.hpp"
#include "nearest.hpp"
#include "surface_tree.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace proof;

namespace {

Kind round_kind(const std::string_view name) {
  if (name == "sphere") return Kind::Sphere;
  if (name == "cylinder") return Kind::Cylinder;
  if (name == "capsule") return Kind::Capsule;
  if (name == "cone") return Kind::Cone;
  throw std::invalid_argument("no round shape of that name");
}

std::vector<Vec> points_of(const Numbers& rows) {
  std::vector<Vec> points;
  points.reserve(rows.shape(0));
  for (size_t i = 0; i < rows.shape(0); ++i) points.push_back(vector(rows.data() + 3 * i));
  return points;
}

std::shared_ptr<Form> mesh(const Numbers& vertices, const Counts& faces, std::shared_ptr<Form> hull,
                           const Numbers& representatives, const Numbers& closed) {
  auto form = make_hull(vertices.data(), vertices.shape(0), faces.data(), faces.shape(0), false);
  form->kind = Kind::Mesh;
  form->hull = std::move(hull);
  form->representatives.clear();
  for (size_t i = 0; i < representatives.shape(0); ++i) {
    form->representatives.push_back(vector(representatives.data() + 3 * i));
  }
  SurfaceTree::Triangles surface, shell;
  for (const auto& face : form->faces) {
    auto corner = [&](int i) { return vector(vertices.data() + 3 * face[i]); };
    surface.push_back({corner(0), corner(1), corner(2)});
  }
  for (size_t i = 0; i < closed.shape(0); ++i) {
    const double* at = closed.data() + 9 * i;
    shell.push_back({vector(at), vector(at + 3), vector(at + 6)});
  }
  form->tree = std::make_shared<SurfaceTree>(std::move(surface));
  if (!shell.empty()) form->shell = std::make_shared<SurfaceTree>(std::move(shell));
  return form;
}

Arm make_arm(const Counts& parents, const Flags& revolute, const Numbers& axes, const Numbers& rotations,
             const Numbers& translations) {
  Arm arm;
  for (size_t i = 0; i < parents.shape(0); ++i) {
    arm.joints.push_back({int(parents.data()[i]), revolute.data()[i], vector(axes.data() + 3 * i),
                          {matrix(rotations.data() + 9 * i), vector(translations.data() + 3 * i)}});
  }
  return arm;
}

nb::tuple place(const Arm& arm, const Numbers& positions) {
  const size_t count = positions.shape(0), joints = arm.joints.size();
  std::vector<double> rotation(count * joints * 9), translation(count * joints * 3);
  {
    gil::Released released;
    std::vector<Pose> poses(joints);
    for (size_t row = 0; row < count; ++row) {
      arm.place(positions.data() + row * (joints - 1), poses.data());
      for (size_t j = 0; j < joints; ++j) {
        const size_t at = row * joints + j;
        Eigen::Map<RowMajor>{rotation.data() + 9 * at} = poses[j].R;
        Eigen::Map<Vec>{translation.data() + 3 * at} = poses[j].p;
      }
    }
  }
  return nb::make_tuple(array(std::move(rotation), {count, joints, 3, 3}),
                        array(std::move(translation), {count, joints, 3}));
}

Bodies with_errors(Bodies bodies, const Numbers& errors) {
  for (size_t i = 0; i < errors.shape(0); ++i) {
    const double* row = errors.data() + 3 * i;
    bodies.pairs[i].error = {row[0], row[1], row[2]};
  }
  return bodies;
}

// Everything about one reduced model.
class Proof {
 public:
  Proof(const Arm& arm, const std::vector<std::shared_ptr<Form>>& forms, const Counts& joint, const Numbers& rotation,
        const Numbers& translation, const Counts& first, const Counts& second, const Numbers& required,
        const Numbers& errors, const Flags& listed, double error)
      : bodies_(with_errors({arm, placed(forms, joint, rotation, translation), first.data(), second.data(),
                             required.data(), first.shape(0)}, errors)),
        candidates_(bodies_, std::vector<char>(listed.data(), listed.data() + listed.size())),
        meter_(bodies_, error) {}

  long calls() const { return meter_.calls; }

  Array measure(const Numbers& times, const Numbers& rotation, const Numbers& translation, const Counts& cell,
                 const Counts& pair) {
    return each(times, rotation, translation, cell, pair, [this](int number, Snapshot& at) {
      return meter_.measure(number, at, std::numeric_limits<double>::infinity()).distance;
    });
  }
  Array measure_hulls(const Numbers& times, const Numbers& rotation, const Numbers& translation, const Counts& cell,
                 const Counts& pair) {
    return each(times, rotation, translation, cell, pair,
                [this](int number, Snapshot& at) { return meter_.measure_hulls(number, at); });
  }
  Array search_depths(const Numbers& times, const Numbers& rotation, const Numbers& translation, const Counts& cell,
                 const Counts& pair) {
    return each(times, rotation, translation, cell, pair,
                [this](int number, Snapshot& at) { return meter_.search_depth(number, at); });
  }
  Array nearest(const Numbers& times, const Numbers& rotation, const Numbers& translation, const Flags& strict) {
    std::vector<double> found;
    {
      gil::Released released;
      Snapshot at = snapshot(times, rotation, translation, 0);
      found = measure_nearest(bodies_, candidates_, meter_, at,
                              std::vector<char>(strict.data(), strict.data() + strict.size()));
    }
    return array(std::move(found));
  }

  nb::tuple search(const Numbers& times, const Numbers& coefficients, bool smooth, const Numbers& expand,
                   const Numbers& offset, const Counts& windowed, const Numbers& windows, const Numbers& edges,
                   const Numbers& options, bool measured) {
    Motion motion;
    motion.position = make_curve(times, coefficients);
    motion.velocity = motion.position.derivative();
    motion.acceleration = motion.velocity.derivative();
    motion.smooth = smooth;
    motion.expand = rows_of(expand);
    motion.offset = Eigen::Map<const Eigen::VectorXd>(offset.data(), offset.size());
    Windows accepted{std::vector<int>(bodies_.pairs.size(), -1), {}, numbers(edges)};
    for (size_t i = 0; i < windowed.size(); ++i) {
      const double* w = windows.data() + 4 * i;
      accepted.number[size_t(windowed.data()[i])] = int(i);
      accepted.windows.push_back({w[0], w[1], w[2], w[3]});
    }
    const double* o = options.data();
    const Options chosen{o[0], o[1], o[2], o[3], o[4], o[5]};
    ClearanceSearch search(bodies_, candidates_, meter_, motion, accepted, chosen);
    {
      gil::Released released;
      measured ? search.run() : search.decide();
    }
    std::vector<double> contacts;
    for (const Contact& contact : search.contacts) {
      contacts.insert(contacts.end(), {double(contact.pair), contact.time, contact.distance});
    }
    const size_t found = search.contacts.size();
    auto tally = [](Tally& of) {
      return nb::make_tuple(array(std::move(of.proven)), array(std::move(of.measured)), array(std::move(of.time)));
    };
    return nb::make_tuple(tally(search.free), tally(search.accepted), array(std::move(contacts), {found, 3}),
                          nb::make_tuple(search.gap.pair, search.gap.begin, search.gap.end), search.configurations);
  }

 private:
  Bodies bodies_;
  Candidates candidates_;
  Meter meter_;

  static std::vector<Body> placed(const std::vector<std::shared_ptr<Form>>& forms, const Counts& joint,
                                  const Numbers& rotation, const Numbers& translation) {
    std::vector<Body> bodies;
    bodies.reserve(forms.size());
    for (size_t i = 0; i < forms.size(); ++i) {
      bodies.push_back({forms[i], int(joint.data()[i]),
                        {matrix(rotation.data() + 9 * i), vector(translation.data() + 3 * i)}});
    }
    return bodies;
  }

  Snapshot snapshot(const Numbers& times, const Numbers& rotation, const Numbers& translation, int64_t cell) const {
    const size_t count = bodies_.arm.joints.size();
    std::vector<Pose> joints(count);
    for (size_t j = 0; j < count; ++j) {
      const size_t at = size_t(cell) * count + j;
      joints[j] = {matrix(rotation.data() + 9 * at), vector(translation.data() + 3 * at)};
    }
    return Snapshot(bodies_, times.data()[cell], std::move(joints));
  }

  template <typename Measure>
  Array each(const Numbers& times, const Numbers& rotation, const Numbers& translation, const Counts& cell,
             const Counts& pair, Measure measure) {
    std::vector<double> found(pair.size());
    {
      gil::Released released;
      for (size_t i = 0; i < found.size(); ++i) {
        Snapshot at = snapshot(times, rotation, translation, cell.data()[i]);
        found[i] = measure(int(pair.data()[i]), at);
      }
    }
    return array(std::move(found));
  }
};

}  // namespace

NB_MODULE(proof, m) {
  leaks::settle();
  coal_boxes::settle();
  nb::class_<Form>(m, "Form");
  m.def("box", [](double x, double y, double z) { return make_solid(Kind::Box, Vec(x, y, z) / 2.0); });
  m.def("round_solid", [](const char* name, double radius, double length) {
    return make_solid(round_kind(name), Vec(radius, radius, length / 2.0));
  });
  m.def("half_space", [] { return make_solid(Kind::Plane, Vec::Zero()); });
  m.def("hull", [](const Numbers& vertices, const Counts& faces) {
    return make_hull(vertices.data(), vertices.shape(0), faces.data(), faces.shape(0), true);
  });
  m.def("mesh", &mesh);
  m.def("balls", [](const Numbers& centres, double radius) {
    return make_cloud(points_of(centres), make_solid(Kind::Sphere, Vec(radius, radius, 0.0)));
  });
  m.def("cubes", [](const Numbers& centres, double edge) {
    return make_cloud(points_of(centres), make_solid(Kind::Box, Vec::Constant(edge / 2.0)));
  });
  bind_curves(m);
  nb::class_<Arm>(m, "Arm").def("place", &place);
  m.def("arm", &make_arm);
  nb::class_<Proof>(m, "Proof")
      .def(nb::init<const Arm&, const std::vector<std::shared_ptr<Form>>&, const Counts&, const Numbers&,
                    const Numbers&, const Counts&, const Counts&, const Numbers&, const Numbers&, const Flags&,
                    double>())
      .def_prop_ro("calls", &Proof::calls)
      .def("measure", &Proof::measure)
      .def("measure_hulls", &Proof::measure_hulls)
      .def("search_depths", &Proof::search_depths)
      .def("nearest", &Proof::nearest)
      .def("search", &Proof::search);
}
