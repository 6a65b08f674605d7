// Tests in a few lines: TEST(name) { CHECK(...); }. Every failed check is printed; `main` returns how many there were.
#pragma once

#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

namespace check {

struct Test {
  const char* name;
  void (*run)();
};

inline std::vector<Test>& tests() {
  static std::vector<Test> all;
  return all;
}

inline int failures = 0;

inline bool add(const char* name, void (*run)()) {
  tests().push_back({name, run});
  return true;
}

inline void report(bool holds, const char* what, const char* file, int line) {
  if (holds) return;
  ++failures;
  std::printf("%s:%d: does not hold: %s\n", file, line, what);
}

inline void report_near(double value, double expected, double tolerance, const char* what, const char* file, int line) {
  if (std::abs(value - expected) <= tolerance) return;
  ++failures;
  std::printf("%s:%d: %s is %.17g, not %.17g\n", file, line, what, value, expected);
}

inline double uniform(std::mt19937& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

inline int whole(std::mt19937& rng, int low, int high) { return std::uniform_int_distribution<int>(low, high)(rng); }

}  // namespace check

#define TEST(name)                                                  \
  static void name();                                               \
  static const bool name##_is_added = check::add(#name, name);      \
  static void name()
#define CHECK(condition) check::report(condition, #condition, __FILE__, __LINE__)
#define CHECK_NEAR(value, expected, tolerance) \
  check::report_near(value, expected, tolerance, #value, __FILE__, __LINE__)
