// What nanobind says at the interpreter's end: nothing, unless TRAJOPT_REPORT_LEAKS is set.
#pragma once

#include <nanobind/nanobind.h>

#include <cstdlib>

namespace leaks {

// A thread that still runs when the interpreter ends keeps what its frames hold, which nanobind takes for leaks and
// prints: it means nothing to whoever runs the program, and nobody can free it. Our tests set the variable, so that a
// true leak is seen. The cores are in a domain of nanobind's of their own; other packages' reports stay theirs.
inline void settle() { nanobind::set_leak_warnings(std::getenv("TRAJOPT_REPORT_LEAKS") != nullptr); }

}  // namespace leaks
