// Reading a statement and a witness from Python: only values of the stated kind and size are accepted.
#pragma once

#include <nanobind/nanobind.h>

#include "statement.hpp"

namespace checker {

namespace nb = nanobind;

Statement read_statement(nb::handle value);
Witness read_witness(const std::string& data, const Statement& statement);

}  // namespace checker
