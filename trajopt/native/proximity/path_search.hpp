// RRT-Connect from one configuration to whichever is reached first of several, and its path shortened.
//
// Sources: Kuffner and LaValle, RRT-Connect, ICRA 2000; Geraerts and Overmars, Creating high-quality paths for motion
// planning, IJRR 2007 (shortening).
#pragma once

#include <functional>
#include <unordered_set>

#include "generator.hpp"
#include "lines.hpp"

namespace proximity {

struct PathRequest {
  std::vector<double> start, goals;  // n numbers, n numbers each
  std::vector<double> lower, upper;  // of the joints; start and goals lie within
  std::vector<double> unit;          // of length in each joint
  std::vector<double> reach;         // of each pair
  double step;                       // no body moves farther between looked-at configurations [m]
  std::int64_t looks, shortening;    // configurations that the search may look at, and each pass of shortening
  std::uint64_t seed;
};

struct FoundPath {
  std::vector<double> corners;  // n numbers each; none where no path was found
  bool exhausted = false;       // none was found, and the second half of the search entered hardly any new cells
  std::int64_t looked = 0;
  Work work;
};

class PathSearch {
 public:
  // `check` is called every so often with the configurations looked at so far; it may throw to stop.
  PathSearch(const Cell& cell, const PathRequest& asked, std::function<void(std::int64_t)> check);

  FoundPath operator()();

 private:
  // Longest branch [units].
  static constexpr double kBranch = 1.0;
  // Share of the samples that are drawn around a node, and how far from it at most [units]: twice a branch, so that some
  // of the branches towards them are shorter than a whole one.
  static constexpr double kLocal = 0.1, kWide = 2.0;
  // Side of the cells in which the ends of branches are counted [units]: half a branch. In two joints all are soon tried,
  // in six never.
  static constexpr double kCell = 0.5;
  // A search is exhausted if its second half entered no larger share of the cells; asked each time that the number of
  // samples has doubled, from so many on, of which the narrow way out of a place may take a thousand.
  static constexpr double kNew = 0.02;
  static constexpr std::int64_t kSure = 4096;
  // Configurations between two calls of `check`: a millisecond or two.
  static constexpr std::int64_t kPatience = 500;
  // Shortening ends after so many lines in a row that were not free: long paths leave the optimiser too few knots.
  static constexpr int kFutile = 20;

  using Node = std::vector<double>;

  struct Tree {
    std::vector<double> nodes;  // in units, n numbers each
    std::vector<int> parent;    // -1 for roots
    std::unordered_set<std::uint64_t> reached, blocked;  // cells in which a branch ended, or would have
    int count() const { return static_cast<int>(parent.size()); }
  };

  struct Nearest {
    int node;
    double distance;
  };

  bool free(const double* from, const double* to);
  void draw(const Tree& tree, Node& sample);
  int add(Tree& tree, const double* node, int parent);
  Nearest nearest(const Tree& tree, const double* node) const;
  Node between(const double* from, const double* to, double share) const;
  int extend(Tree& tree, const Nearest& from, const double* towards);
  std::uint64_t cell(const Node& node) const;
  bool exhausted() const;
  int connect(Tree& tree, const double* towards);
  std::vector<Node> searched();
  std::vector<Node> joined(const Tree& first, int at_first, const Tree& second, int at_second) const;
  void drop_corners(std::vector<Node>& path);
  void cut_corners(std::vector<Node>& path);
  double length(const double* from, const double* to) const;

  const PathRequest& asked_;
  std::function<void(std::int64_t)> check_;
  Lines lines_;
  Generator random_;
  const int dofs_;
  std::int64_t drawn_ = 0, checked_ = 0;
  std::vector<std::int64_t> entered_;  // samples drawn when a branch first ended in each of the cells
  Node from_, to_;  // of a line, out of units
};

}  // namespace proximity
