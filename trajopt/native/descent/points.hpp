// A program over knots made of parts, and its points.
#pragma once

#include <functional>
#include <memory>
#include <variant>

#include "timed_blocks.hpp"

namespace descent {

// Rows that something outside evaluates, all at once at each point: the number in its answer.
struct Outside {
  std::size_t number;
};

struct Part {
  Role role;
  std::variant<Linear, Distances, DistancesInTime, Frames, Torques, Outside> rows;
};

// What was evaluated outside: rows of each part, what they were made of, and configurations evaluated for them.
struct Answer {
  Answer() = default;
  Answer(const Answer&) = delete;
  Answer(Answer&&) = default;
  Answer& operator=(Answer&&) = default;

  std::vector<Rows> rows;
  std::shared_ptr<const void> kept;
  std::int64_t configurations = 0;
};

// Everything at one point; never changed.
struct Point {
  Point() = default;
  Point(const Point&) = delete;

  std::vector<double> x;
  std::vector<Rows> rows;  // of each part
  std::shared_ptr<const void> kept;
  double cost = 0.0, violation = 0.0;
  bool feasible = true;

  double merit(double penalty) const { return cost + penalty * violation; }
};

// What was done so far.
struct Work {
  std::int64_t configurations = 0, bounds = 0, distances = 0;
};

// Not for several threads at once.
class Program {
 public:
  // Called where parts are asked for; each call names its own, so that no program keeps what may keep it.
  using Ask = std::function<Answer(const double* x)>;

  Program(Variables variables, std::vector<double> lower, std::vector<double> upper, std::vector<double> scale,
          robot::RobotQuery& query);

  void add(Part part) { parts_.push_back(std::move(part)); }
  std::shared_ptr<const Point> at(std::vector<double> x, const Ask& ask);
  // The program of a step around a point.
  banded::Program quadratic(const Point& point, double penalty) const;

  const Variables& variables() const { return variables_; }
  const std::vector<Part>& parts() const { return parts_; }
  const std::vector<double>& lower() const { return lower_; }
  const std::vector<double>& upper() const { return upper_; }
  const std::vector<double>& scale() const { return scale_; }
  robot::RobotQuery& robot() { return query_; }
  const Work& work() const { return work_; }

 private:
  Variables variables_;
  std::vector<double> lower_, upper_;  // of each variable
  std::vector<double> scale_;          // of each joint
  // Bounds and distances of all that is asked.
  robot::Work asked() const;

  robot::RobotQuery& query_;
  std::vector<Part> parts_;
  Work work_;
};

}  // namespace descent
