#include "path_search.hpp"

#include <limits>

namespace proximity {

PathSearch::PathSearch(const Cell& cell, const PathRequest& asked, std::function<void(std::int64_t)> check)
    : asked_(asked),
      check_(std::move(check)),
      lines_(cell, asked.reach, asked.step),
      random_(asked.seed),
      dofs_(cell.robot.dofs()),
      from_(dofs_),
      to_(dofs_) {}

FoundPath PathSearch::operator()() {
  std::vector<Node> path = searched();
  if (!path.empty()) {
    drop_corners(path);
    cut_corners(path);
    drop_corners(path);
  }
  FoundPath result;
  for (const Node& node : path) {
    for (int joint = 0; joint < dofs_; ++joint) result.corners.push_back(node[joint] * asked_.unit[joint]);
  }
  result.exhausted = path.empty() && exhausted();
  result.looked = lines_.clear.looked;
  result.work = lines_.clear.work;
  return result;
}

// Whether a line is free; its ends are in units, as everything here is.
bool PathSearch::free(const double* from, const double* to) {
  if (lines_.clear.looked - checked_ >= kPatience) {
    checked_ = lines_.clear.looked;
    check_(checked_);
  }
  for (int joint = 0; joint < dofs_; ++joint) {
    from_[joint] = from[joint] * asked_.unit[joint];
    to_[joint] = to[joint] * asked_.unit[joint];
  }
  return lines_.free(from_.data(), to_.data());
}

int PathSearch::add(Tree& tree, const double* node, int parent) {
  tree.nodes.insert(tree.nodes.end(), node, node + dofs_);
  tree.parent.push_back(parent);
  return tree.count() - 1;
}

PathSearch::Nearest PathSearch::nearest(const Tree& tree, const double* node) const {
  Nearest best{-1, std::numeric_limits<double>::infinity()};
  const double* at = tree.nodes.data();
  for (int index = 0; index < tree.count(); ++index, at += dofs_) {
    double square = 0.0;
    for (int joint = 0; joint < dofs_; ++joint) square += (at[joint] - node[joint]) * (at[joint] - node[joint]);
    if (square < best.distance) best = {index, square};
  }
  best.distance = std::sqrt(best.distance);
  return best;
}

PathSearch::Node PathSearch::between(const double* from, const double* to, double share) const {
  Node node(to, to + dofs_);
  if (share < 1.0) {
    for (int joint = 0; joint < dofs_; ++joint) node[joint] = from[joint] + share * (to[joint] - from[joint]);
  }
  return node;
}

// Grow a branch from a node; -1 where something is in its way.
int PathSearch::extend(Tree& tree, const Nearest& from, const double* towards) {
  const double* root = tree.nodes.data() + static_cast<size_t>(from.node) * dofs_;
  const Node tip = between(root, towards, kBranch / std::max(from.distance, kBranch));
  const bool clear = free(root, tip.data());
  if ((clear ? tree.reached : tree.blocked).insert(cell(tip)).second) entered_.push_back(drawn_);
  return clear ? add(tree, tip.data(), from.node) : -1;
}

// The number of a cell; two share one hardly ever.
std::uint64_t PathSearch::cell(const Node& node) const {
  std::uint64_t number = 0;
  for (double position : node) number = Generator(number + static_cast<std::int64_t>(std::floor(position / kCell))).next();
  return number;
}

// Whether the second half of the search entered hardly any new cell.
bool PathSearch::exhausted() const {
  const auto second_half = std::upper_bound(entered_.begin(), entered_.end(), drawn_ / 2);
  return drawn_ >= kSure && entered_.end() - second_half <= kNew * entered_.size();
}

// Grow branches towards a configuration until it is reached, or something is in the way: -1.
int PathSearch::connect(Tree& tree, const double* towards) {
  Nearest from = nearest(tree, towards);
  while (from.distance > 0.0) {
    const int tip = extend(tree, from, towards);
    if (tip < 0) return -1;
    from = {tip, from.distance <= kBranch ? 0.0 : from.distance - kBranch};
  }
  return from.node;
}

// Draw a configuration: anywhere, or around a node of the tree that is to grow, which finds the way out of narrow places.
void PathSearch::draw(const Tree& tree, Node& sample) {
  ++drawn_;
  const bool local = random_.uniform() < kLocal;
  const int node = static_cast<int>(random_.uniform() * tree.count());
  const double wide = kWide * random_.uniform();
  for (int joint = 0; joint < dofs_; ++joint) {
    const double low = asked_.lower[joint] / asked_.unit[joint], high = asked_.upper[joint] / asked_.unit[joint];
    const double share = random_.uniform();
    const double around = tree.nodes[static_cast<size_t>(node) * dofs_ + joint] + wide * (2.0 * share - 1.0);
    sample[joint] = local ? std::clamp(around, low, high) : low + share * (high - low);
  }
}

std::vector<PathSearch::Node> PathSearch::searched() {
  Tree trees[2];
  Node sample(dofs_);
  const auto root = [&](Tree& tree, const double* positions) {
    for (int joint = 0; joint < dofs_; ++joint) sample[joint] = positions[joint] / asked_.unit[joint];
    add(tree, sample.data(), -1);
  };
  root(trees[0], asked_.start.data());
  for (size_t goal = 0; goal < asked_.goals.size(); goal += dofs_) root(trees[1], asked_.goals.data() + goal);
  for (int goal = 0; goal < trees[1].count(); ++goal) {
    const double* end = trees[1].nodes.data() + static_cast<size_t>(goal) * dofs_;
    if (free(trees[0].nodes.data(), end)) return joined(trees[0], 0, trees[1], goal);
  }
  // Whatever is drawn counts too: where there is nothing else than what the trees hold already, this ends.
  const auto often = [&] { return drawn_ >= kSure && (drawn_ & (drawn_ - 1)) == 0; };
  while (lines_.clear.looked < asked_.looks && drawn_ < asked_.looks && !(often() && exhausted())) {
    const bool backward = trees[1].count() < trees[0].count();
    Tree &grown = trees[backward], &other = trees[!backward];
    draw(grown, sample);
    const Nearest from = nearest(grown, sample.data());
    if (from.distance == 0.0) continue;
    const int tip = extend(grown, from, sample.data());
    if (tip < 0) continue;
    const Node reached(grown.nodes.end() - dofs_, grown.nodes.end());
    const int met = connect(other, reached.data());
    if (met >= 0) return backward ? joined(other, met, grown, tip) : joined(grown, tip, other, met);
  }
  return {};
}

// The path from the first tree's root to the second's; where they meet they hold the same configuration.
std::vector<PathSearch::Node> PathSearch::joined(const Tree& first, int at_first, const Tree& second,
                                                   int at_second) const {
  std::vector<Node> path;
  const auto take = [&](const Tree& tree, int node) {
    for (; node >= 0; node = tree.parent[node]) {
      const double* at = tree.nodes.data() + static_cast<size_t>(node) * dofs_;
      path.emplace_back(at, at + dofs_);
    }
  };
  take(first, at_first);
  std::reverse(path.begin(), path.end());
  if (length(path.back().data(), second.nodes.data() + static_cast<size_t>(at_second) * dofs_) == 0.0) path.pop_back();
  take(second, at_second);
  return path;
}

// From each corner go straight to the last one that can be reached so.
void PathSearch::drop_corners(std::vector<Node>& path) {
  const std::int64_t allowed = lines_.clear.looked + asked_.shortening;
  for (size_t corner = 0; corner + 2 < path.size(); ++corner) {
    for (size_t last = path.size() - 1; last > corner + 1; --last) {
      if (lines_.clear.looked >= allowed) return;
      if (!free(path[corner].data(), path[last].data())) continue;
      path.erase(path.begin() + corner + 1, path.begin() + last);
      break;
    }
  }
}

// Between two places drawn anywhere along the path go straight, where that is free.
void PathSearch::cut_corners(std::vector<Node>& path) {
  const std::int64_t allowed = lines_.clear.looked + asked_.shortening;
  for (int futile = 0; futile < kFutile && path.size() > 2 && lines_.clear.looked < allowed;) {
    std::vector<double> along(1, 0.0);
    for (size_t leg = 1; leg < path.size(); ++leg) {
      along.push_back(along.back() + length(path[leg - 1].data(), path[leg].data()));
    }
    double places[2] = {random_.uniform() * along.back(), random_.uniform() * along.back()};
    if (places[0] > places[1]) std::swap(places[0], places[1]);
    size_t legs[2];
    Node ends[2];
    for (int end = 0; end < 2; ++end) {
      const auto after = std::upper_bound(along.begin() + 1, along.end() - 1, places[end]);
      const size_t leg = legs[end] = after - along.begin();
      ends[end] = between(path[leg - 1].data(), path[leg].data(), (places[end] - along[leg - 1]) / (along[leg] - along[leg - 1]));
    }
    ++futile;
    // Places between the corners were not checked themselves.
    if (legs[0] == legs[1] || !free(ends[0].data(), ends[0].data())) continue;
    if (!free(ends[0].data(), ends[1].data())) continue;
    futile = 0;
    path.erase(path.begin() + legs[0], path.begin() + legs[1]);
    path.insert(path.begin() + legs[0], ends, ends + 2);
  }
}

double PathSearch::length(const double* from, const double* to) const {
  double square = 0.0;
  for (int joint = 0; joint < dofs_; ++joint) square += (from[joint] - to[joint]) * (from[joint] - to[joint]);
  return std::sqrt(square);
}

}  // namespace proximity
