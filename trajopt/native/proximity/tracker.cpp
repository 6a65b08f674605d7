#include "tracker.hpp"

namespace proximity {

namespace {
constexpr double kNever = -std::numeric_limits<double>::infinity();

void append(std::vector<double>& target, const Vector3& value) {
  target.insert(target.end(), value.data(), value.data() + 3);
}
}  // namespace

void ClosePairs::clear() {
  sample.clear();
  pair.clear();
  for (auto* numbers : {&distance, &normal, &first, &second, &jacobian}) numbers->clear();
}

// Pairs of which nothing is known.
void Tracker::Watched::reset() {
  least.assign(pair.size(), kNever);
  clear.resize(pair.size());
  for (auto& bounds : clear) bounds.fill(kNever);
  across.resize(pair.size());
  known.assign(pair.size(), 0);
  close.assign(pair.size(), 0);
}

Tracker::Tracker(const Cell& cell)
    : cell_(cell), kinematics_(cell.robot), narrow_(cell.accuracy), movers_(static_cast<int>(cell.movers.size())) {
  for (const Pair& pair : cell.pairs) both_.push_back({mover(pair.first), mover(pair.second)});
}

const ClosePairs& Tracker::close_pairs(const double* positions, int samples, const std::vector<double>& reach,
                                       const std::vector<double>& aim) {
  if (samples != samples_) {
    pass_on(positions, samples);
    begin_anew(samples);
  }
  positions_.assign(positions, positions + static_cast<size_t>(samples) * cell_.robot.dofs());
  reach_ = reach;
  aim_ = aim;
  widen(reach);
  place_all(positions);
  found_.clear();
  for (int begin = 0; begin < samples; begin += kStretch) along_stretch(begin, std::min(begin + kStretch, samples));
  return found_;
}

// Samples other than last time: no bound is known of them.
void Tracker::begin_anew(int samples) {
  samples_ = samples;
  const int stretches = (samples_ + kStretch - 1) / kStretch;
  joints_.resize(static_cast<size_t>(samples_) * cell_.robot.joints());
  places_.resize(static_cast<size_t>(samples_) * movers_);
  moved_.assign(static_cast<size_t>(samples_) * (movers_ + 1), -1.0);
  for (int sample = 0; sample < samples_; ++sample) moved(sample, movers_) = 0.0;
  listed_.clear();
  longest_listed_ = 0.0;
  neighbours_.resize(static_cast<size_t>(stretches) * movers_);
  for (Neighbours& list : neighbours_) list.listed = false;
  between_.resize(stretches);
  for (Watched& pairs : between_) {
    pairs.pair = cell_.between_movers;
    pairs.reset();
  }
}

// Other samples of a motion: each takes the contacts of the one that it is nearest to.
void Tracker::pass_on(const double* positions, int samples) {
  const int dofs = cell_.robot.dofs();
  std::vector<std::vector<Contact>> contacts(samples);
  const auto apart = [&](int sample, int old) {
    const Eigen::Map<const Eigen::VectorXd> now(positions + static_cast<size_t>(sample) * dofs, dofs);
    return (now - Eigen::Map<const Eigen::VectorXd>(positions_.data() + static_cast<size_t>(old) * dofs, dofs)).squaredNorm();
  };
  for (int sample = 0, near = 0; samples_ > 0 && sample < samples; ++sample) {
    while (near + 1 < samples_ && apart(sample, near + 1) <= apart(sample, near)) ++near;
    contacts[sample] = contacts_[near];
  }
  contacts_ = std::move(contacts);
}

// Bounds hold whatever the reach is; lists of obstacles hold for those that they were made for.
void Tracker::widen(const std::vector<double>& reach) {
  listed_.resize(reach.size(), kNever);
  bool wider = false;
  for (size_t pair = 0; pair < reach.size(); ++pair) {
    if (!(reach[pair] > listed_[pair])) continue;
    listed_[pair] = reach[pair];
    longest_listed_ = std::max(longest_listed_, reach[pair]);
    wider = true;
  }
  if (!wider) return;
  for (Neighbours& list : neighbours_) list.listed = false;
}

void Tracker::place_all(const double* positions) {
  const int joints = cell_.robot.joints(), dofs = cell_.robot.dofs();
  for (int sample = 0; sample < samples_; ++sample) {
    const auto& placed = kinematics_(positions + static_cast<size_t>(sample) * dofs);
    std::copy(placed.begin(), placed.end(), joints_.begin() + static_cast<size_t>(sample) * joints);
    for (int mover = 0; mover < movers_; ++mover) {
      const Body& body = cell_.bodies[cell_.movers[mover]];
      Place& before = places_[static_cast<size_t>(sample) * movers_ + mover];
      const Place now = place(body, placed[body.joint]);
      double& sum = moved(sample, mover);
      sum = sum < 0.0 ? 0.0 : sum + motion(body, before, now);
      before = now;
    }
  }
}

void Tracker::along_stretch(int begin, int end) {
  farthest_.assign(movers_ + 1, 0.0);
  for (int sample = begin; sample < end; ++sample) {
    for (int mover = 0; mover < movers_; ++mover) farthest_[mover] = std::max(farthest_[mover], moved(sample, mover));
  }
  steps_.assign(static_cast<size_t>(movers_ + 1) * kStretch, -1.0);
  std::fill(steps_.end() - kStretch, steps_.end(), 0.0);
  for (int mover = 0; mover < movers_; ++mover) {
    Neighbours& list = neighbours_[static_cast<size_t>(begin / kStretch) * movers_ + mover];
    if (outdated(list, mover, begin, end)) list_obstacles(list, mover, begin, end);
    watch(list.pairs, begin, end);
  }
  watch(between_[begin / kStretch], begin, end);
}

const Place& Tracker::at(int sample, int body) const {
  const int mover = cell_.mover_of[body];
  return mover < 0 ? cell_.still[body] : place_of(sample, mover);
}

bool Tracker::outdated(const Neighbours& list, int mover, int begin, int end) const {
  if (!list.listed) return true;
  for (int sample = begin; sample < end; ++sample) {
    if (moved(sample, mover) - list.since[sample - begin] > kSkin) return true;
  }
  return false;
}

void Tracker::list_obstacles(Neighbours& list, int mover, int begin, int end) {
  const Body& body = cell_.bodies[cell_.movers[mover]];
  Vector3 low = place_of(begin, mover).centre, high = low;
  for (int sample = begin; sample < end; ++sample) {
    const Vector3& centre = place_of(sample, mover).centre;
    low = low.cwiseMin(centre);
    high = high.cwiseMax(centre);
    list.since[sample - begin] = moved(sample, mover);
  }
  const Vector3 centre = (low + high) / 2.0;
  const double radius = (high - low).norm() / 2.0 + body.radius;
  near_.clear();
  cell_.obstacles.near(centre, radius + longest_listed_ + kSkin, near_);
  list.pairs.pair.clear();
  for (int other : near_) {
    const int pair = cell_.pair_with[mover][other];
    if (pair < 0) continue;
    const double apart = std::sqrt(outside_squared(cell_.bodies[other], cell_.still[other], centre)) - radius;
    ++work.bounds;
    if (apart <= listed_[pair] + kSkin) list.pairs.pair.push_back(pair);
  }
  list.pairs.reset();
  list.listed = true;
}

void Tracker::watch(Watched& pairs, int begin, int end) {
  for (size_t entry = 0; entry < pairs.pair.size(); ++entry) {
    const Both& both = both_[pairs.pair[entry]];
    if (pairs.least[entry] - farthest_[both.first] - farthest_[both.second] > reach_[pairs.pair[entry]]) continue;
    follow(pairs, entry, begin, end);
  }
}

// Follow a pair from sample to sample.
void Tracker::follow(Watched& pairs, size_t entry, int begin, int end) {
  const int pair = pairs.pair[entry];
  const Both both = both_[pair];
  const double reach = reach_[pair];
  double least = std::numeric_limits<double>::infinity(), before = kNever;
  for (int sample = begin; sample < end; ++sample) {
    const int place = sample - begin;
    double& clear = pairs.clear[entry][place];
    const double sum = moved(sample, both);
    double bound = clear - sum;
    if (!(bound > reach)) {
      if (before > reach) bound = std::max(bound, before - step(both.first, sample, place) - step(both.second, sample, place));
      if (!(bound > reach)) bound = apart(pairs, entry, sample, place);
      clear = bound + sum;
    }
    least = std::min(least, clear);
    before = bound;
  }
  pairs.least[entry] = least;
}

// How far a mover is from where it is at the sample before, at most.
double Tracker::step(int mover, int sample, int place) {
  double& known = steps_[static_cast<size_t>(mover) * kStretch + place];
  if (known < 0.0) {
    known = motion(cell_.bodies[cell_.movers[mover]], place_of(sample - 1, mover), place_of(sample, mover));
  }
  return known;
}

// How far apart a pair is, at least. Where it was nearest at last, here or else at the sample before, is carried along
// with its bodies. What was within reach there is measured otherwise; of all else it is asked first whether they are
// apart along the direction that is known, then their spheres and boxes.
double Tracker::apart(Watched& pairs, size_t entry, int sample, int place) {
  const int pair = pairs.pair[entry];
  const auto [first, second] = cell_.pairs[pair];
  const Body &a = cell_.bodies[first], &b = cell_.bodies[second];
  const double reach = reach_[pair];
  const std::uint8_t here = 1 << place, before = here >> 1, known = pairs.known[entry], close = pairs.close[entry];
  const bool fresh = pairs.clear[entry][place] == kNever, within = close & here || (fresh && close & before);
  const Contact* contact = within || fresh ? kept(pair, sample) : nullptr;
  if (contact == nullptr && fresh && close & before) contact = kept(pair, sample - 1);
  Nearest found;
  if (contact != nullptr && carried(*contact, sample, found)) {
    ++work.bounds;
    if (found.distance < reach) add_row(pair, sample, found);
    return noted(pairs, entry, place, found);
  }
  if (!within) {
    const Place &at_a = at(sample, first), &at_b = at(sample, second);
    if (known & (here | before)) {
      ++work.bounds;
      const Vector3 across = pairs.across[entry][known & here ? place : place - 1];
      const double along = narrow_.along(a, at_a, b, at_b, across);
      if (along > reach) {
        pairs.across[entry][place] = across;
        pairs.known[entry] |= here;
        return along;
      }
    }
    ++work.bounds;
    const double bound = lower_bound(a, at_a, b, at_b, reach);
    if (bound > reach) return bound;
  }
  found = measure(pair, sample);
  keep(pair, sample, found);
  return noted(pairs, entry, place, found);
}

// Note whether a pair is within reach, and the direction along which it is not.
double Tracker::noted(Watched& pairs, size_t entry, int place, const Nearest& found) {
  const auto [first, second] = cell_.pairs[pairs.pair[entry]];
  const std::uint8_t here = 1 << place;
  std::uint8_t &known = pairs.known[entry], &close = pairs.close[entry];
  const bool beyond = found.distance > reach_[pairs.pair[entry]];
  close = beyond ? close & ~here : close | here;
  known &= ~here;
  if (beyond && NarrowPhase::has_direction(cell_.bodies[first], cell_.bodies[second], found)) {
    known |= here;
    pairs.across[entry][place] = found.normal;
  }
  return std::isnan(found.distance) ? kNever : found.distance;
}

const Tracker::Contact* Tracker::kept(int pair, int sample) const {
  for (const Contact& contact : contacts_[sample]) {
    if (contact.pair == pair) return &contact;
  }
  return nullptr;
}

// Two bodies are no farther apart than their points that were nearest, and no nearer than along the direction that was
// between these, as either body carries it: where both agree well enough, nothing is measured.
bool Tracker::carried(const Contact& contact, int sample, Nearest& found) {
  const auto [first, second] = cell_.pairs[contact.pair];
  const Place &at_a = at(sample, first), &at_b = at(sample, second);
  found.first = at_a.rotation * contact.first + at_a.centre;
  found.second = at_b.rotation * contact.second + at_b.centre;
  const double most = (found.second - found.first).norm(), aim = aim_[contact.pair];
  if (!(most > aim)) return false;
  const auto agree = [&](const Vector3& normal) {
    found.normal = normal;
    found.distance = narrow_.along(cell_.bodies[first], at_a, cell_.bodies[second], at_b, normal);
    return most - found.distance <= kInexact * (found.distance - aim);
  };
  return agree(at_b.rotation * contact.normal_second) || agree(at_a.rotation * contact.normal_first);
}

// Keep where a pair is nearest, if the pair can be asked along a direction.
void Tracker::keep(int pair, int sample, const Nearest& found) {
  const auto [first, second] = cell_.pairs[pair];
  auto& kept = contacts_[sample];
  const auto same = [&](const Contact& contact) { return contact.pair == pair; };
  const auto place = std::find_if(kept.begin(), kept.end(), same);
  if (!(found.distance > aim_[pair] && found.distance <= reach_[pair]) ||
      !NarrowPhase::has_direction(cell_.bodies[first], cell_.bodies[second], found)) {
    if (place != kept.end()) kept.erase(place);
    return;
  }
  const Place &at_a = at(sample, first), &at_b = at(sample, second);
  const Contact contact{pair, at_a.rotation.transpose() * (found.first - at_a.centre),
                        at_b.rotation.transpose() * (found.second - at_b.centre),
                        at_a.rotation.transpose() * found.normal, at_b.rotation.transpose() * found.normal};
  if (place == kept.end()) {
    kept.push_back(contact);
  } else {
    *place = contact;
  }
}

// Ask Coal; a close pair becomes a row.
Nearest Tracker::measure(int pair, int sample) {
  const auto [first, second] = cell_.pairs[pair];
  const Body &a = cell_.bodies[first], &b = cell_.bodies[second];
  if (a.element != nullptr || b.element != nullptr) return measure_cloud(pair, sample);
  const auto* placed = joints_.data() + static_cast<size_t>(sample) * cell_.robot.joints();
  const Nearest found = narrow_(a, transform(a, at(sample, first), placed[a.joint]), b,
                                transform(b, at(sample, second), placed[b.joint]), reach_[pair]);
  ++work.distances;
  if (found.distance < reach_[pair]) add_row(pair, sample, found);
  return found;
}

// Of a cloud several balls or cubes become rows.
Nearest Tracker::measure_cloud(int pair, int sample) {
  const auto [first, second] = cell_.pairs[pair];
  const Body &a = cell_.bodies[first], &b = cell_.bodies[second];
  const auto* placed = joints_.data() + static_cast<size_t>(sample) * cell_.robot.joints();
  const auto& found = clouds_.rows(a, transform(a, at(sample, first), placed[a.joint]), b,
                                   transform(b, at(sample, second), placed[b.joint]), reach_[pair]);
  clouds_.tell(work);
  for (const Nearest& each : found) add_row(pair, sample, each);
  if (!found.empty()) return found.front();
  return {clouds_.beyond(), Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
}

// d(q + dq) = d + n . (J_second - J_first) dq, a joint's column being v + w x (p - o) with its velocity (v, w) at
// unit speed and its origin o: no Jacobian is built for it.
void Tracker::add_row(int pair, int sample, const Nearest& found) {
  const Robot& robot = cell_.robot;
  found_.sample.push_back(sample);
  found_.pair.push_back(pair);
  found_.distance.push_back(found.distance);
  append(found_.normal, found.normal);
  append(found_.first, found.first);
  append(found_.second, found.second);
  const size_t start = found_.jacobian.size();
  found_.jacobian.resize(start + robot.dofs(), 0.0);
  double* row = found_.jacobian.data() + start;
  const auto* placed = joints_.data() + static_cast<size_t>(sample) * robot.joints();
  const auto &carries_first = robot.supports[cell_.bodies[cell_.pairs[pair].first].joint];
  const auto &carries_second = robot.supports[cell_.bodies[cell_.pairs[pair].second].joint];
  // What carries both moves them as one.
  size_t common = 0;
  while (common < std::min(carries_first.size(), carries_second.size()) && carries_first[common] == carries_second[common]) {
    ++common;
  }
  const auto add = [&](const std::vector<int>& joints, const Vector3& point, double sign) {
    for (size_t next = common; next < joints.size(); ++next) {
      const int joint = joints[next];
      const auto& frame = placed[joint];
      const Vector3 linear = frame.rotation() * robot.axis[joint].linear();
      const Vector3 angular = frame.rotation() * robot.axis[joint].angular();
      const double speed = found.normal.dot(linear + angular.cross(point - frame.translation()));
      for (const Drive& drive : robot.driven[joint]) row[drive.joint] += sign * speed * drive.factor;
    }
  };
  add(carries_second, found.second, 1.0);
  add(carries_first, found.first, -1.0);
}

}  // namespace proximity
