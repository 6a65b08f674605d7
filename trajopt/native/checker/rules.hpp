// Rules of requirements.
#pragma once

#include <nanobind/nanobind.h>

#include "statement.hpp"

namespace checker {

// Read a requirement.
Rule read_rule(nanobind::handle value, const Statement& statement);

}  // namespace checker
