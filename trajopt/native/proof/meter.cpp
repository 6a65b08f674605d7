#include "meter.hpp"

#include "cloud_distance.hpp"
#include "coal_depth.hpp"
#include "cloud_points.hpp"
#include "surface_tree.hpp"

namespace proof {

namespace {

const Form& solid(const Form& form) { return form.kind == Kind::Mesh ? *form.hull : form; }

// Distance of convex forms, or that it is no less than `within`.
double convex_gap(const Form& first, const Pose& first_at, const Form& second, const Pose& second_at, Vec& guess,
                  double within, bool& exact) {
  if (guess.isZero()) guess = second_at.p - first_at.p;
  const Sweep still{{&first}, {&second}, {&first_at, &first_at}, {&second_at, &second_at}};
  const Separation found = separate(still, guess, within, Aim::Measure);
  exact = found.gap < within;
  if (!found.overlap) guess = found.direction;
  if (!exact || (!found.overlap && found.upper - found.gap <= doubtful)) return found.gap;
  return std::max(found.gap, signed_distance(first, first_at, second, second_at));
}

double any_convex_gap(const Form& first, const Pose& first_at, const Form& second, const Pose& second_at, Vec& guess,
                      double within) {
  bool exact = true;
  return convex_gap(first, first_at, second, second_at, guess, within, exact);
}

// How large a part of a form's tree is that has parts of its own; negative where it has none.
double extent(const Form& form, int node) {
  if (node < 0) return -1.0;
  if (form.points != nullptr) return node < form.points->part_of(0) ? form.points->half(node).norm() : -1.0;
  const auto& at = form.tree->nodes[node];
  return at.leaf() ? -1.0 : at.radius;
}

template <typename Take>
void open(const Form& form, int node, Take take) {
  if (form.points != nullptr) {
    form.points->open(node, take);
  } else {
    take(form.tree->nodes[node].right);
    take(form.tree->nodes[node].left);
  }
}

int root(const Form& form) { return form.kind == Kind::Mesh || form.points != nullptr ? 0 : -1; }

}  // namespace

Meter::Meter(const Bodies& bodies, double error)
    : bodies_(bodies), error_(error), guess_(bodies.pairs.size(), Vec::Zero()) {}

Measured Meter::measure(int number, Snapshot& at, double within) {
  const Pair& pair = bodies_.pairs[number];
  const double error = taken_off(pair, at);
  ++calls;
  if (pair.planar) {
    const double distance = height(pair, at) - error;
    return {distance, distance < within};
  }
  const double limit = within + error;
  if (pair.meshed) {
    const double distance = surface_distance(number, at, limit);
    if (distance > error && !encloses(number, at)) return {distance - error, distance < limit};
    // Surfaces have no depth: in contact, and around what is enclosed, the hulls stand for them.
    return {std::min(std::max(distance, 0.0) - error, measure_hulls(number, at)), true};
  }
  if (pair.clouded) {
    const double distance = union_distance(pair, at, limit);
    return {distance - error, distance < limit};
  }
  bool exact = true;
  const double distance = convex_distance(bodies_.form(pair.first), bodies_.form(pair.second), pair, at,
                                          guess_[number], limit, exact);
  return {distance - error, exact};
}

double Meter::measure_hulls(int number, Snapshot& at) {
  const Pair& pair = bodies_.pairs[number];
  ++calls;
  if (pair.clouded) return union_distance(pair, at, infinite) - taken_off(pair, at);
  Vec guess = Vec::Zero();
  bool exact = true;
  return convex_distance(solid(bodies_.form(pair.first)), solid(bodies_.form(pair.second)), pair, at, guess, infinite,
                         exact) - taken_off(pair, at);
}

double Meter::search_depth(int number, Snapshot& at) {
  const Pair& pair = bodies_.pairs[number];
  ++calls;
  if (pair.planar || pair.clouded) return -infinite;
  return largest_gap(solid(bodies_.form(pair.first)), at.seen(pair.first_seen), solid(bodies_.form(pair.second)),
                     at.seen(pair.second_seen)) - taken_off(pair, at);
}

bool Meter::encloses(int number, Snapshot& at) const {
  const Pair& pair = bodies_.pairs[number];
  const int seen[2] = {pair.first_seen, pair.second_seen}, body[2] = {pair.first, pair.second};
  for (const int shell : {0, 1}) {
    const Form& mesh = bodies_.form(body[shell]);
    if (mesh.shell == nullptr) continue;
    const Pose where = at.seen(seen[shell]).inverse() * at.seen(seen[1 - shell]);
    for (const Vec& point : bodies_.form(body[1 - shell]).representatives) {
      if (mesh.shell->encloses(where * point)) return true;
    }
  }
  return false;
}

double Meter::prove(int number, Snapshot& early, Snapshot& late, double needed) {
  const Pair& pair = bodies_.pairs[number];
  ++calls;
  if (pair.planar) {
    const double least = std::min(height(pair, early), height(pair, late));
    return least >= needed ? least : -infinite;
  }
  Vec& guess = guess_[number];
  if (guess.isZero()) guess = late.seen(pair.second_seen).p - late.seen(pair.first_seen).p;
  double least = infinite;
  open_.assign(1, roots(pair));
  while (!open_.empty()) {
    const Parts parts = open_.back();
    open_.pop_back();
    const Separation found = separate(sweep(pair, early, late, parts), guess, needed, Aim::Prove);
    guess = found.direction;
    if (found.gap >= needed) {
      least = std::min(least, found.gap);
    } else if (!split(pair, parts)) {
      return -infinite;
    }
  }
  return least;
}

Sweep Meter::sweep(const Pair& pair, Snapshot& early, Snapshot& late, Parts parts) const {
  const Pose *first = &early.seen(pair.first_seen), *second = &early.seen(pair.second_seen);
  const bool first_rests = bodies_.travellers[pair.first_seen].rests();
  const bool second_rests = bodies_.travellers[pair.second_seen].rests();
  return {{&bodies_.form(pair.first), parts.first},
          {&bodies_.form(pair.second), parts.second},
          {first, first_rests ? first : &late.seen(pair.first_seen)},
          {second, second_rests ? second : &late.seen(pair.second_seen)}};
}

double Meter::height(const Pair& pair, Snapshot& at) const {
  const bool first = bodies_.form(pair.first).kind == Kind::Plane;
  const Pose& plane = at.seen(first ? pair.first_seen : pair.second_seen);
  const Pose& body = at.seen(first ? pair.second_seen : pair.first_seen);
  const Vec normal = plane.R.col(2);
  const Form& form = solid(bodies_.form(first ? pair.second : pair.first));
  return normal.dot(body.p - plane.p) - form.reach(-(body.R.transpose() * normal));
}

double Meter::convex_distance(const Form& first, const Form& second, const Pair& pair, Snapshot& at, Vec& guess,
                              double within, bool& exact) {
  return convex_gap(first, at.seen(pair.first_seen), second, at.seen(pair.second_seen), guess, within, exact);
}

double Meter::union_distance(const Pair& pair, Snapshot& at, double within) const {
  const Form &first = solid(bodies_.form(pair.first)), &second = solid(bodies_.form(pair.second));
  const Pose &first_at = at.seen(pair.first_seen), &second_at = at.seen(pair.second_seen);
  if (first.points != nullptr) return cloud_distance(first, first_at, second, second_at, within, any_convex_gap);
  return cloud_distance(second, second_at, first, first_at, within, any_convex_gap);
}

double Meter::surface_distance(int number, Snapshot& at, double within) {
  const Pair& pair = bodies_.pairs[number];
  Vec& guess = guess_[number];
  if (guess.isZero()) guess = at.seen(pair.second_seen).p - at.seen(pair.first_seen).p;
  double best = within;
  open_.assign(1, roots(pair));
  while (!open_.empty()) {
    const Parts parts = open_.back();
    open_.pop_back();
    Separation found = separate(sweep(pair, at, at, parts), guess, best, Aim::Prove);
    if (found.gap >= best) continue;
    if (split(pair, parts)) continue;
    found = separate(sweep(pair, at, at, parts), found.direction, best, Aim::Measure);
    if (found.overlap) return -infinite;
    guess = found.direction;
    best = std::min(best, found.gap);
  }
  return best;
}

Meter::Parts Meter::roots(const Pair& pair) const {
  return {root(bodies_.form(pair.first)), root(bodies_.form(pair.second))};
}

// Put the parts of the larger inner node of two in the place of both; false if both are leaves.
bool Meter::split(const Pair& pair, Parts parts) {
  const Form &one = bodies_.form(pair.first), &other = bodies_.form(pair.second);
  const double first = extent(one, parts.first), second = extent(other, parts.second);
  if (first < 0.0 && second < 0.0) return false;
  if (first >= second) {
    open(one, parts.first, [&](int inner) { open_.push_back({inner, parts.second}); });
  } else {
    open(other, parts.second, [&](int inner) { open_.push_back({parts.first, inner}); });
  }
  return true;
}

}  // namespace proof
