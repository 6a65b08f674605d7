// Values of JSON as Python has read them: each function refuses other kinds and sizes with a sentence.
#pragma once

#include <nanobind/nanobind.h>

#include <initializer_list>

#include "statement.hpp"

namespace checker {

namespace nb = nanobind;

constexpr int MOST = 100'000, MOST_JOINTS = 1'000, MOST_PARTS = 5'000, MOST_KNOTS = 20'000;
constexpr double LARGEST = 1e12;

using Where = const char*;

inline nb::dict mapping(Where where, nb::handle value) {
  demand(PyDict_CheckExact(value.ptr()), std::string(where) + " must be an object");
  return nb::borrow<nb::dict>(value);
}

inline nb::list items(Where where, nb::handle value, int most = MOST) {
  demand(PyList_CheckExact(value.ptr()) && PyList_GET_SIZE(value.ptr()) <= most,
         std::string(where) + " must be a list of at most " + std::to_string(most) + " entries");
  return nb::borrow<nb::list>(value);
}

inline double number(Where where, nb::handle value, double least = -LARGEST, double most = LARGEST) {
  double found = NOT_A_NUMBER;
  if (PyFloat_CheckExact(value.ptr())) found = PyFloat_AS_DOUBLE(value.ptr());
  else if (PyLong_CheckExact(value.ptr())) found = PyLong_AsDouble(value.ptr());
  if (PyErr_Occurred()) PyErr_Clear(), found = NOT_A_NUMBER;  // an integer beyond all doubles
  demand(least <= found && found <= most, std::string(where) + " must be a number within its range");
  return found;
}
inline double size(Where where, nb::handle value) { return number(where, value, 0.0); }
inline double unless_null(Where where, nb::handle value, double none) {
  return value.is_none() ? none : number(where, value);
}

inline bool flag(Where where, nb::handle value) {
  demand(PyBool_Check(value.ptr()), std::string(where) + " must be true or false");
  return value.ptr() == Py_True;
}

inline std::string text(Where where, nb::handle value) {
  const bool fits = PyUnicode_CheckExact(value.ptr()) && PyUnicode_GET_LENGTH(value.ptr()) <= 1000 &&
                    nb::cast<bool>(value.attr("isprintable")());
  Py_ssize_t length = 0;
  const char* found = fits ? PyUnicode_AsUTF8AndSize(value.ptr(), &length) : nullptr;
  if (PyErr_Occurred()) PyErr_Clear();
  demand(found != nullptr, std::string(where) + " must be a printable text of at most 1000 characters");
  return std::string(found, static_cast<std::size_t>(length));
}

inline int below(Where where, nb::handle value, long most) {
  const long found = PyLong_CheckExact(value.ptr()) ? PyLong_AsLong(value.ptr()) : -1;
  if (PyErr_Occurred()) PyErr_Clear();
  demand(0 <= found && found < most, std::string(where) + " must be a whole number from 0 to below " + std::to_string(most));
  return static_cast<int>(found);
}

// An object with the named fields and no others.
class Fields {
 public:
  Fields(Where where, nb::handle value, std::initializer_list<Where> names) : fields_(mapping(where, value)) {
    bool fits = fields_.size() == names.size();
    for (Where name : names) fits = fits && fields_.contains(name);
    demand(fits, std::string(where) + " must have exactly its fields");
  }
  nb::object operator[](Where name) const { return nb::object(fields_[name]); }

 private:
  nb::dict fields_;
};

// A list with some number of entries.
inline nb::list row(Where where, nb::handle value, std::size_t count) {
  nb::list found = items(where, value);
  demand(found.size() == count, std::string(where) + " must have " + std::to_string(count) + " entries");
  return found;
}

inline std::vector<double> numbers(Where where, nb::handle value) {
  std::vector<double> found;
  for (nb::handle each : items(where, value)) found.push_back(number(where, each));
  demand(!found.empty(), std::string(where) + " must not be empty");
  return found;
}

template <std::size_t N>
std::array<double, N> tuple(Where where, nb::handle value, double least = -LARGEST) {
  std::array<double, N> found;
  std::size_t at = 0;
  for (nb::handle each : row(where, value, N)) found[at++] = number(where, each, least);
  return found;
}

// A vector that is to be normalised: its largest number must be near 1.
template <std::size_t N>
std::array<double, N> direction(Where where, nb::handle value) {
  const auto found = tuple<N>(where, value);
  double largest = 0.0;
  for (const double each : found) largest = larger(largest, std::abs(each));
  demand(0.5 <= largest && largest <= 2.0, std::string(where) + " must have a largest number near 1");
  return found;
}

inline Vec point(Where where, nb::handle value) {
  const auto found = tuple<3>(where, value);
  return {found[0], found[1], found[2]};
}

inline Place place(Where where, nb::handle value, int joints) {
  const Fields fields(where, value, {"joint", "rotation", "translation"});
  return {below("the joint of a place", fields["joint"], joints + 1),
          rotation_of(direction<4>("the rotation of a place", fields["rotation"])),
          point("the translation of a place", fields["translation"])};
}

}  // namespace checker
