#include "clearance_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace proof {

namespace {

constexpr double near_enough = 0.75;  // Share of the measured clearance at which a bound is near enough.
constexpr int surveyed = 65;          // Once a contact is found, contacts are looked for at so many times.

}  // namespace

double Windows::floor(double time, int pair) const {
  if (number[pair] < 0) return 0.0;
  const Window& window = windows[number[pair]];
  const double first = time <= window.until ? window.first_depth : infinite;
  const double last = time >= window.from ? window.last_depth : infinite;
  return -std::min(first, last);
}

Tally::Tally(size_t count) : proven(count, infinite), measured(count, infinite), time(count, 0.0) {}

void Tally::note(int pair, double distance, double when) {
  if (distance < measured[pair]) measured[pair] = distance, time[pair] = when;
}

ClearanceSearch::ClearanceSearch(const Bodies& bodies, const Candidates& candidates, Meter& meter,
                                 const Motion& motion, const Windows& windows, const Options& options)
    : free(bodies.pairs.size()), accepted(bodies.pairs.size()), bodies_(bodies), candidates_(candidates),
      meter_(meter), motion_(motion), windows_(windows), options_(options), far_(options.far),
      best_(bodies.levels.size(), infinite), beyond_(infinite), tight_time_(bodies.pairs.size(), 0.0), before_(meter.calls) {}

void ClearanceSearch::look_at_ends() {
  // At the ends, too, bodies that surfaces enclose are found: to get inside in between, or out, a strict pair would
  // have to meet. One that was let through a surface is looked for at all times.
  for (const double time : {motion_.begin(), motion_.end()}) look(*at(time), deciding_);
}

void ClearanceSearch::decide() {
  if (bodies_.pairs.empty()) return;
  deciding_ = true;
  far_ = 2.0 * options_.error;  // What is not looked at is farther than is required, whatever the error.
  look_at_ends();
  if (proven()) search();
  spread_beyond();
  deciding_ = false;
  far_ = options_.far;
}

void ClearanceSearch::run() {
  if (bodies_.pairs.empty()) return;
  decide();
  const std::vector<Contact> found = std::exchange(contacts, {});
  const Gap unproven = std::exchange(gap, {});
  if (found.empty() && unproven.pair < 0) decided_ = std::make_unique<std::pair<Tally, Tally>>(free, accepted);
  before_ = meter_.calls;
  samples_.clear();
  forget_bounds();
  look_at_ends();
  search();
  if (proven()) {
    if (nothing_near()) search();
    measure_near_pairs();
  } else if (!contacts.empty()) {
    for (int i = 0; i < surveyed; ++i) look(*at(motion_.begin() + motion_.duration() * i / (surveyed - 1)), true);
  }
  spread_beyond();
  // What was not proven stays so, whatever a second look says.
  contacts.insert(contacts.end(), found.begin(), found.end());
  if (proven()) gap = unproven;
}

// What the tree left out is farther than the nearest of it; pairs with windows are always listed.
void ClearanceSearch::spread_beyond() {
  for (size_t pair = 0; pair < bodies_.pairs.size(); ++pair) {
    if (windows_.number[pair] < 0) free.proven[pair] = std::min(free.proven[pair], beyond_);
  }
}

// Bounds that were good enough so far are not for what is wanted now.
void ClearanceSearch::forget_bounds() {
  beyond_ = infinite;
  std::fill(free.proven.begin(), free.proven.end(), infinite);
  std::fill(accepted.proven.begin(), accepted.proven.end(), infinite);
}

void ClearanceSearch::search() {
  std::vector<Cell> cells = first_cells();
  while (!cells.empty() && gap.pair < 0 && contacts.empty()) advance(cells);
}

std::shared_ptr<Snapshot> ClearanceSearch::at(double time) {
  ++configurations;
  return std::make_shared<Snapshot>(bodies_, time, motion_.joints(time).data());
}

void ClearanceSearch::look(Snapshot& at, bool only_contacts) {
  for (const int pair : candidates_.listed()) consider(pair, at, only_contacts);
  for (const int mover : candidates_.movers()) {
    double limit = bodies_.levels.back();
    for (size_t level = 0; level < best_.size() && !only_contacts; ++level) limit = std::max(limit, nearest(int(level)));
    candidates_.visit(mover, at.centre(mover), bodies_.form(mover).radius + limit + candidates_.reserve(),
                      [&](int pair) { consider(pair, at, only_contacts); });
  }
}

// The nearest that pairs of a level have come, within the bounds in which it is of interest [m].
double ClearanceSearch::nearest(int level) const {
  const double least = bodies_.levels[level];
  return std::clamp(best_[level], least, least + far_);
}

// Measure a pair if it is too near or, unless only that counts, comes nearer than all of its level before.
void ClearanceSearch::consider(int pair, Snapshot& at, bool only_contacts) {
  const bool accept = windows_.accept(at.time, pair);
  const double limit = accept ? 0.0 : only_contacts ? required(pair) : nearest(bodies_.pairs[pair].level);
  if (!bodies_.pairs[pair].planar && sphere_gap(at, bodies_.pairs[pair]) > limit + options_.error) return;
  const Measured found = meter_.measure(pair, at, std::max(limit, options_.error));
  if (found.exact) judge(pair, at.time, doubted(pair, at, found.distance));
}

void ClearanceSearch::judge(int pair, double time, double distance) {
  if (windows_.accept(time, pair)) accepted.note(pair, distance, time);
  else note_free(pair, distance, time);
  if (!decided_ && distance <= floor(time, pair)) contacts.push_back({pair, time, distance});
}

void ClearanceSearch::note_free(int pair, double distance, double time) {
  free.note(pair, distance, time);
  double& best = best_[bodies_.pairs[pair].level];
  best = std::min(best, distance);
}

// What the distance must exceed: the clearance that is required, or minus the accepted depth [m].
double ClearanceSearch::floor(double time, int pair) const {
  return windows_.accept(time, pair) ? windows_.floor(time, pair) : required(pair);
}

// Measure again, by search, what is deeper than the contact that is accepted then.
double ClearanceSearch::doubted(int pair, Snapshot& at, double distance) {
  const double least = floor(at.time, pair);
  if (least >= 0.0 || distance > least) return distance;
  return std::max(distance, meter_.search_depth(pair, at));
}

// What bounds must exceed: the floor, or when measuring near the smallest distance measured [m].
double ClearanceSearch::target(double time, int pair) const {
  if (deciding_ || windows_.accept(time, pair)) return floor(time, pair);
  const double least = required(pair), best = best_[bodies_.pairs[pair].level];
  const double near = std::max(best - options_.resolution, least + near_enough * (best - least));
  return std::max(std::min(near, least + far_), least);
}

std::vector<ClearanceSearch::Cell> ClearanceSearch::first_cells() {
  std::vector<double> edges = windows_.edges;
  const int count = deciding_ ? int(options_.intervals) : first_intervals;
  for (int i = 0; i <= count; ++i) edges.push_back(motion_.begin() + motion_.duration() * i / count);
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<Cell> cells;
  auto early = at(edges[0]);
  for (size_t i = 1; i < edges.size() && contacts.empty(); ++i) {
    const auto late = at(edges[i]);
    look(*late, deciding_);
    cells.push_back({edges[i - 1], edges[i], early, late, {}, true});
    early = late;
  }
  return cells;
}

// List the pairs of a cell that may come nearer than `far` in it.
void ClearanceSearch::list_near(Cell& cell, Reach& here) {
  cell.pairs = candidates_.listed();
  for (const int mover : candidates_.movers()) {
    // Obstacles are looked at in the world, in which the travel of a mover is the same for all.
    const double off = travel(bodies_.seen_from(mover, 0), here).from_middle;
    const double reserve = candidates_.reserve(), farthest = bodies_.levels.back() + far_ + reserve;
    const double radius = bodies_.form(mover).radius + off + farthest;
    const double nearest = candidates_.visit(mover, here.middle->centre(mover), radius,
                                             [&](int pair) { cell.pairs.push_back(pair); });
    beyond_ = std::min(beyond_, nearest - (radius - farthest) - reserve - options_.error);
  }
}

void ClearanceSearch::advance(std::vector<Cell>& cells) {
  std::vector<Cell> next;
  for (Cell& cell : cells) {
    Reach here = reach(cell);
    if (cell.fresh) {
      samples_.insert(samples_.end(), {here.middle, cell.late});
      list_near(cell, here);
    }
    std::vector<int> left;
    for (const int pair : cell.pairs) {
      if (!prove(pair, here)) left.push_back(pair);
    }
    if (left.empty()) continue;
    for (const int pair : left) consider(pair, *here.middle, deciding_);
    if (!contacts.empty()) return;
    const double middle = here.middle->time;
    const bool spent = double(meter_.calls - before_) > options_.most_distances;
    if (middle - cell.begin < options_.smallest_interval || spent) {
      if (decided_) {
        keep_decided(left, middle);
        continue;
      }
      gap = {left.front(), cell.begin, cell.end};
      return;
    }
    next.push_back({cell.begin, middle, cell.early, here.middle, left, false});
    next.push_back({middle, cell.end, here.middle, cell.late, std::move(left), false});
  }
  cells = std::move(next);
}

// Where bounds cannot be brought as near as is wanted, those that decided stay.
void ClearanceSearch::keep_decided(const std::vector<int>& pairs, double time) {
  for (const int pair : pairs) {
    const bool accept = windows_.accept(time, pair);
    double& bound = (accept ? accepted : free).proven[pair];
    bound = std::min(bound, (accept ? decided_->second : decided_->first).proven[pair]);
  }
}

bool ClearanceSearch::prove(int number, Reach& here) {
  const Pair& pair = bodies_.pairs[number];
  const double middle = here.middle->time;
  const bool accept = windows_.accept(middle, number);
  const double wanted = target(middle, number);
  if (wanted == -infinite) return true;
  const double grown = pair.error.at(here.end), grows = grown - pair.error.at(middle);
  const Travel one = travel(pair.first_seen, here), other = travel(pair.second_seen, here);
  const double off = one.from_middle + other.from_middle;
  const double length = here.end - here.begin;
  const double bulge = (one.acceleration + other.acceleration) * length * length / 8.0;
  double bound = pair.planar ? -infinite : sphere_gap(*here.middle, pair) - grows - off - options_.error;
  const bool chords = here.chords && bulge <= off;
  if (!(bound > wanted) && !pair.planar && chords) {
    bound = sphere_gap(bodies_, *here.early, *here.late, pair) - grown - bulge - options_.error;
  }
  if (!(bound > wanted)) {
    const double slack = (chords ? bulge : off) + grown + options_.error;
    Snapshot& early = chords ? *here.early : *here.middle;
    Snapshot& late = chords ? *here.late : *here.middle;
    bound = meter_.prove(number, early, late, std::max(wanted + slack, slack)) - slack;
    if (bound > wanted && windows_.number[number] >= 0 && meter_.encloses(number, *here.middle)) bound = -infinite;
    // Contact that is accepted to some depth: no direction separates, but depth changes by no more than the travel.
    if (!(bound > wanted) && accept && wanted < 0.0) bound = middle_distance(number, here, off) - grows - off;
  }
  if (!(bound > wanted)) return false;
  Tally& tally = accept ? accepted : free;
  if (bound < tally.proven[number]) {
    tally.proven[number] = bound;
    if (!accept) tight_time_[number] = middle;
  }
  return true;
}

// Measure a pair in contact that is accepted; an exact mesh counts as its hull, which has a depth.
double ClearanceSearch::middle_distance(int pair, Reach& here, double off) {
  double distance = meter_.measure(pair, *here.middle, infinite).distance;
  if (bodies_.pairs[pair].meshed && distance <= off) {
    distance = std::min(distance, meter_.measure_hulls(pair, *here.middle));
  }
  distance = doubted(pair, *here.middle, distance);
  judge(pair, here.middle->time, distance);
  return distance;
}

Travel ClearanceSearch::travel(int number, Reach& here) {
  const Traveller& traveller = bodies_.travellers[number];
  if (traveller.rests()) return {};
  if (!here.known[traveller.slot]) {
    here.travels[traveller.slot] = proof::travel(bodies_, traveller, *here.middle, here.bounds);
    here.known[traveller.slot] = 1;
  }
  return here.travels[traveller.slot];
}

ClearanceSearch::Reach ClearanceSearch::reach(const Cell& cell) {
  const double middle = (cell.begin + cell.end) / 2.0;
  const size_t count = bodies_.moving;
  return {cell.begin, cell.end, cell.early, at(middle), cell.late, motion_.bounds(cell.begin, cell.end),
          motion_.smooth || !motion_.position.breaks(cell.begin, cell.end), std::vector<Travel>(count),
          std::vector<char>(count, 0)};
}

}  // namespace proof
