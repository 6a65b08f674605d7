#include "inverse_dynamics.hpp"

#include <boost/python/extract.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>

#include <stdexcept>

namespace proof {

struct Dynamics::Inner {
  const pinocchio::Model& model;
  mutable pinocchio::Data data;

  explicit Inner(const pinocchio::Model& given) : model(given), data(given) {}
};

Dynamics::Dynamics(PyObject* handed) {
  const boost::python::extract<const pinocchio::Model&> model(handed);
  if (!model.check()) throw std::invalid_argument("not a pinocchio.Model");
  inner_ = std::make_unique<Inner>(model());
}

Dynamics::~Dynamics() = default;

void Dynamics::torques(size_t rows, const double* q, const double* v, const double* a, double* found) const {
  const pinocchio::Model& model = inner_->model;
  using Row = Eigen::Map<const Eigen::VectorXd>;
  for (size_t row = 0; row < rows; ++row) {
    const size_t at = row * size_t(model.nv);
    Eigen::Map<Eigen::VectorXd>(found + at, model.nv) =
        pinocchio::rnea(model, inner_->data, Row(q + row * size_t(model.nq), model.nq), Row(v + at, model.nv),
                        Row(a + at, model.nv));
  }
}

}  // namespace proof
