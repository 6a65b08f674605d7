#include "clear.hpp"

namespace proximity {

Clear::Clear(const Cell& cell, std::vector<double> reach)
    : cell_(cell), reach_(std::move(reach)), kinematics_(cell.robot), narrow_(cell.accuracy) {
  for (double each : reach_) longest_reach_ = std::max(longest_reach_, each);
  places_.resize(cell.movers.size());
  across_.assign(cell.pairs.size(), Vector3::Zero());
  struck_.assign(cell.pairs.size(), -1);
  const auto square = [&](int first, int second, int pair) {
    const double apart = cell.bodies[first].radius + cell.bodies[second].radius + reach_[pair];
    return apart * apart;
  };
  for (int pair : cell.between_movers) {
    const auto [first, second] = cell.pairs[pair];
    between_.push_back({cell.mover_of[first], cell.mover_of[second], square(first, second, pair), pair});
  }
  for (size_t mover = 0; mover < cell.movers.size(); ++mover) {
    auto& still = with_still_.emplace_back();
    for (int body = 0; body < static_cast<int>(cell.bodies.size()); ++body) {
      const int pair = cell.pair_with[mover][body];
      if (pair < 0) continue;
      still.push_back({cell.still[body].centre, square(cell.movers[mover], body, pair), pair, body});
    }
    many_.push_back(still.size() > kFew);
  }
}

void Clear::place_at(const double* positions) {
  placed_ = &kinematics_(positions);
  for (size_t mover = 0; mover < places_.size(); ++mover) {
    const Body& body = cell_.bodies[cell_.movers[mover]];
    places_[mover] = place(body, (*placed_)[body.joint]);
  }
}

bool Clear::operator()(const double* positions) {
  ++looked;
  place_at(positions);
  for (int pair : remembered_) {
    if (!bounds_keep(pair) && !keeps(pair)) {
      remember(pair);
      return false;
    }
  }
  collect();
  for (int pair : doubtful_) {
    if (!keeps(pair)) {
      remember(pair);
      return false;
    }
  }
  return true;
}

double Clear::motion_between(const Places& from, const Places& to) const {
  double largest = 0.0;
  for (size_t mover = 0; mover < places_.size(); ++mover) {
    const Body& body = cell_.bodies[cell_.movers[mover]];
    if (body.radius < Obstacles::kUnbounded) largest = std::max(largest, motion(body, from[mover], to[mover]));
  }
  return largest;
}

const Place& Clear::at(int body) const {
  const int mover = cell_.mover_of[body];
  return mover < 0 ? cell_.still[body] : places_[mover];
}

bool Clear::bounds_keep(int pair) {
  const auto [first, second] = cell_.pairs[pair];
  const Body &a = cell_.bodies[first], &b = cell_.bodies[second];
  const Place &at_a = at(first), &at_b = at(second);
  ++work.bounds;
  const double spheres = a.radius + b.radius + reach_[pair];
  if ((at_a.centre - at_b.centre).squaredNorm() > spheres * spheres) return true;
  return bounds_exceed(a, at_a, b, at_b, reach_[pair]);
}

bool Clear::keeps(int pair) {
  const auto [first, second] = cell_.pairs[pair];
  const Body &a = cell_.bodies[first], &b = cell_.bodies[second];
  const double reach = reach_[pair];
  const Place &at_a = at(first), &at_b = at(second);
  if (a.element != nullptr || b.element != nullptr) {
    const bool kept = clouds_.keeps(a, transform(a, at_a, (*placed_)[a.joint]), b, transform(b, at_b, (*placed_)[b.joint]), reach,
                                    struck_[pair]);
    clouds_.tell(work);
    return kept;
  }
  Vector3& across = across_[pair];
  if (!across.isZero(0.0)) {
    ++work.bounds;
    if (narrow_.along(a, at_a, b, at_b, across) > reach) return true;
  }
  ++work.distances;
  const auto& placed = *placed_;
  const Nearest found = narrow_.keeping(a, transform(a, at_a, placed[a.joint]), b, transform(b, at_b, placed[b.joint]), reach);
  const bool kept = found.distance >= reach;
  if (kept && narrow_.has_direction(a, b, found)) across = found.normal;
  return kept;
}

void Clear::remember(int pair) {
  auto found = std::find(remembered_.begin(), remembered_.end(), pair);
  if (found == remembered_.end()) {
    if (remembered_.size() < kRemembered) remembered_.push_back(pair);
    found = remembered_.end() - 1;
    *found = pair;
  }
  std::rotate(remembered_.begin(), found, found + 1);
}

void Clear::collect() {
  doubtful_.clear();
  for (size_t mover = 0; mover < places_.size(); ++mover) {
    if (many_[mover]) {
      collect_near(static_cast<int>(mover));
      continue;
    }
    const Body& body = cell_.bodies[cell_.movers[mover]];
    const Place& here = places_[mover];
    work.bounds += with_still_[mover].size();
    for (const Still& still : with_still_[mover]) {
      if ((here.centre - still.centre).squaredNorm() > still.square) continue;
      doubt(still.pair, body, here, cell_.bodies[still.body], cell_.still[still.body]);
    }
  }
  work.bounds += between_.size();
  for (const Moving& both : between_) {
    const Place &first = places_[both.first], &second = places_[both.second];
    if ((first.centre - second.centre).squaredNorm() > both.square) continue;
    doubt(both.pair, cell_.bodies[cell_.movers[both.first]], first, cell_.bodies[cell_.movers[both.second]], second);
  }
}

void Clear::doubt(int pair, const Body& a, const Place& at_a, const Body& b, const Place& at_b) {
  if (!bounds_exceed(a, at_a, b, at_b, reach_[pair])) doubtful_.push_back(pair);
}

void Clear::collect_near(int mover) {
  near_.clear();
  cell_.obstacles.near(places_[mover].centre, cell_.bodies[cell_.movers[mover]].radius + longest_reach_, near_);
  for (int other : near_) {
    const int pair = cell_.pair_with[mover][other];
    if (pair >= 0 && !bounds_keep(pair)) doubtful_.push_back(pair);
  }
}

}  // namespace proximity
