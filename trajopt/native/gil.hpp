// The interpreter's lock: given back while a core computes, taken while it asks Python.
#pragma once

#include <nanobind/nanobind.h>

#include <utility>

#ifdef __GLIBCXX__
#include <cxxabi.h>
#include <unistd.h>
#endif

namespace gil {

// Calls Python. Before 3.14 Python ends a thread that asks for the lock when the interpreter has ended (a daemon that
// still computes), by unwinding its stack; that meets a destructor, and the process aborts. Here such a thread waits
// until the process is gone, as it does from 3.14 on.
template <class Call>
auto until_the_end(Call&& call) {
#ifdef __GLIBCXX__
  try {
    return call();
  } catch (abi::__forced_unwind&) {
    for (;;) pause();
  }
#else
  return call();
#endif
}

// As nanobind::gil_scoped_release.
class Released {
 public:
  Released() : state_(PyEval_SaveThread()) {}
  Released(const Released&) = delete;
  Released& operator=(const Released&) = delete;
  ~Released() {
    until_the_end([this] { PyEval_RestoreThread(state_); });
  }

 private:
  PyThreadState* state_;
};

// As nanobind::gil_scoped_acquire, whose functions let nothing unwind through them.
class Taken {
 public:
  Taken() {
    until_the_end([this] { state_ = PyGILState_Ensure(); });
  }
  Taken(const Taken&) = delete;
  Taken& operator=(const Taken&) = delete;
  ~Taken() { PyGILState_Release(state_); }

 private:
  PyGILState_STATE state_;
};

// Calls a function of Python's, with the lock.
template <class... Arguments>
nanobind::object call(const nanobind::callable& function, Arguments&&... arguments) {
  const nanobind::tuple given = nanobind::make_tuple(std::forward<Arguments>(arguments)...);
  PyObject* result = until_the_end([&] { return PyObject_CallObject(function.ptr(), given.ptr()); });
  if (result == nullptr) nanobind::raise_python_error();
  return nanobind::steal(result);
}

}  // namespace gil
