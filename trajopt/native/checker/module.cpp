// Binding of the fast kernel of proofs: the checks of trajopt/verify/checker, in doubles with bounds of their errors.
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "../arrays.hpp"
#include "../leaks.hpp"
#include "clearance.hpp"
#include "limits.hpp"
#include "reading.hpp"
#include "swept.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using namespace checker;

class StatedProof {
 public:
  StatedProof(nb::handle statement, const nb::bytes& witness)
      : statement_(read_statement(statement)), witness_(read_witness(std::string(witness.c_str(), witness.size()), statement_)) {}

  // The first fault; empty if the statement is proven.
  std::string fault() const {
    const Arm arm(statement_, witness_.grid);
    if (const std::string found = limits_fault(statement_, arm); !found.empty()) return found;
    for (const Rule& rule : statement_.rules)
      if (const int cell = rule.unshown(arm, static_cast<int>(arm.grid.size()) - 1); cell != SHOWN)
        return unshown(rule.words, arm, std::max(cell, 0));
    if (const std::string found = pairs_fault(statement_, witness_, arm); !found.empty()) return found;
    const std::vector<bool> holds = leaves_hold(statement_, witness_, arm);
    for (std::size_t pair = 0; pair < statement_.pairs.size(); ++pair)
      for (int leaf = witness_.first[pair]; leaf < witness_.first[pair + 1]; ++leaf)
        if (!holds[leaf]) return leaf_fault(static_cast<int>(pair), leaf);
    return "";
  }

  std::vector<bool> leaves() const { return leaves_hold(statement_, witness_, Arm(statement_, witness_.grid)); }

 private:
  std::string leaf_fault(int pair, int leaf) const {
    const Pair& stated = statement_.pairs[pair];
    char rest[120];
    std::snprintf(rest, sizeof rest, " keep %g mm from %.6g to %.6g s", 1000.0 * stated.clearance, witness_.grid[witness_.begin[leaf]],
                  witness_.grid[witness_.end(pair, leaf)]);
    return "leaf " + std::to_string(leaf) + ": it is not shown that " + statement_.parts[stated.one].owner + " and " +
           statement_.parts[stated.other].owner + rest;
  }

  Statement statement_;
  Witness witness_;
};

using Numbers = arrays::Vector<double>;
using Matrix = arrays::Matrix<double>;

// A placement in the world. A matrix R is as near to a rotation as R^T R to the identity.
Place placed(const Matrix& rotation, const Numbers& translation) {
  arrays::expect(rotation.shape(0) == 3 && rotation.shape(1) == 3 && translation.shape(0) == 3, "a placement has a matrix (3, 3) and a vector (3,)");
  Place found;
  std::copy_n(rotation.data(), 9, found.rotation.m.begin());
  found.translation = {translation(0), translation(1), translation(2)};
  double error = 0.0;
  for (int one = 0; one < 3; ++one)
    for (int other = 0; other < 3; ++other) {
      double inner = one == other ? -1.0 : 0.0;
      for (int row = 0; row < 3; ++row) inner += rotation(row, one) * rotation(row, other);
      error += std::abs(inner);
    }
  found.rotation.r = error + TURN_ERROR;
  arrays::expect(error < 1e-7, "the matrix of a placement must be a rotation");
  return found;
}

SweptParts* swept(nb::handle statement, const std::vector<double>& times, const std::map<std::string, std::pair<Matrix, Numbers>>& frames) {
  SweptParts::Frames places;
  for (const auto& [name, frame] : frames) places.emplace(name, placed(frame.first, frame.second));
  return new SweptParts(read_statement(statement), times, places);
}

}  // namespace

NB_MODULE(checker, module) {
  leaks::settle();
  nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
    try {
      std::rethrow_exception(thrown);
    } catch (const Malformed& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    }
  });
  nb::class_<StatedProof>(module, "StatedProof")
      .def(nb::init<nb::handle, const nb::bytes&>(), "statement"_a, "witness"_a)
      .def("fault", &StatedProof::fault, nb::call_guard<nb::gil_scoped_release>())
      .def("leaves", &StatedProof::leaves, nb::call_guard<nb::gil_scoped_release>());
  nb::class_<SweptParts>(module, "SweptParts")
      .def(nb::new_(&swept), "statement"_a, "times"_a, "frames"_a)
      .def("keep_apart", [](const SweptParts& parts, const std::string& owner, const Matrix& rotation, const Numbers& translation) {
        return parts.keep_apart(owner, placed(rotation, translation));
      }, "owner"_a, "rotation"_a, "translation"_a);
}
