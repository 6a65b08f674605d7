// Torques of many samples by the recursive Newton-Euler algorithm, on the very model that Python made.
#pragma once

#include <Python.h>

#include <cstddef>
#include <memory>

namespace proof {

class Dynamics {
 public:
  // Takes a pinocchio.Model; raises std::invalid_argument for anything else. Keep the model alive meanwhile.
  explicit Dynamics(PyObject* model);
  ~Dynamics();

  // Rows of configurations, velocities and accelerations to rows of torques.
  void torques(size_t rows, const double* q, const double* v, const double* a, double* found) const;

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

}  // namespace proof
