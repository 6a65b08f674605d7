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

Tracker::Tracker(const Cell& cell)
    : cell_(cell), kinematics_(cell.robot), narrow_(cell.accuracy), movers_(static_cast<int>(cell.movers.size())) {}

const ClosePairs& Tracker::close_pairs(const double* positions, int samples, const std::vector<double>& reach) {
  const bool same = samples == samples_ && reach == reach_;
  if (!same) {
    samples_ = samples;
    reach_ = reach;
    longest_reach_ = 0.0;
    for (double each : reach) longest_reach_ = std::max(longest_reach_, each);
    forget();
  }
  place_all(positions, samples);
  found_.clear();
  const int stretches = (samples + kStretch - 1) / kStretch;
  for (int stretch = 0; stretch < stretches; ++stretch) {
    const int begin = stretch * kStretch, end = std::min(begin + kStretch, samples);
    for (int mover = 0; mover < movers_; ++mover) {
      Neighbours& list = neighbours_[stretch * movers_ + mover];
      if (outdated(list, mover, begin, end)) list_obstacles(list, mover, begin, end);
      along_obstacles(list, mover, begin, end);
    }
    for (int sample = begin; sample < end; ++sample) between_movers(sample);
  }
  return found_;
}

// Samples other than last time: nothing is known of them.
void Tracker::forget() {
  joints_.resize(static_cast<size_t>(samples_) * cell_.robot.joints());
  places_.resize(static_cast<size_t>(samples_) * movers_);
  moved_.assign(static_cast<size_t>(samples_) * movers_, -1.0);
  neighbours_.assign(static_cast<size_t>((samples_ + kStretch - 1) / kStretch) * movers_, {});
  clear_between_.assign(static_cast<size_t>(samples_) * cell_.between_movers.size(), kNever);
}

void Tracker::place_all(const double* positions, int samples) {
  const int joints = cell_.robot.joints(), dofs = cell_.robot.dofs();
  for (int sample = 0; sample < samples; ++sample) {
    const auto& placed = kinematics_(positions + static_cast<size_t>(sample) * dofs);
    std::copy(placed.begin(), placed.end(), joints_.begin() + static_cast<size_t>(sample) * joints);
    for (int mover = 0; mover < movers_; ++mover) {
      const Body& body = cell_.bodies[cell_.movers[mover]];
      Place& before = places_[sample * movers_ + mover];
      const Place now = place(body, placed[body.joint]);
      double& sum = moved(sample, mover);
      sum = sum < 0.0 ? 0.0 : sum + motion(body, before, now);
      before = now;
    }
  }
}

const Place& Tracker::at(int sample, int body) const {
  const int mover = cell_.mover_of[body];
  return mover < 0 ? cell_.still[body] : places_[sample * movers_ + mover];
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
  Vector3 low = places_[begin * movers_ + mover].centre, high = low;
  list.since.clear();
  for (int sample = begin; sample < end; ++sample) {
    const Vector3& centre = places_[sample * movers_ + mover].centre;
    low = low.cwiseMin(centre);
    high = high.cwiseMax(centre);
    list.since.push_back(moved(sample, mover));
  }
  const Vector3 centre = (low + high) / 2.0;
  const double radius = (high - low).norm() / 2.0 + body.radius;
  std::vector<int> near;
  cell_.obstacles.near(centre, radius + longest_reach_ + kSkin, near);
  list.pair.clear();
  list.body.clear();
  for (int other : near) {
    const int pair = cell_.pair_with[mover][other];
    if (pair < 0) continue;
    const double apart = std::sqrt(outside_squared(cell_.bodies[other], cell_.still[other], centre)) - radius;
    ++work.bounds;
    if (apart > reach_[pair] + kSkin) continue;
    list.pair.push_back(pair);
    list.body.push_back(other);
  }
  list.clear.assign(list.pair.size() * (end - begin), kNever);
  list.listed = true;
}

void Tracker::along_obstacles(Neighbours& list, int mover, int begin, int end) {
  const Body& body = cell_.bodies[cell_.movers[mover]];
  double* clear = list.clear.data();
  for (size_t entry = 0; entry < list.pair.size(); ++entry) {
    const int pair = list.pair[entry];
    const Body& other = cell_.bodies[list.body[entry]];
    const Place& still = cell_.still[list.body[entry]];
    const double reach = reach_[pair];
    for (int sample = begin; sample < end; ++sample, ++clear) {
      const double sum = moved(sample, mover);
      if (*clear - sum > reach) continue;
      double distance = lower_bound(body, places_[sample * movers_ + mover], other, still, reach);
      ++work.bounds;
      if (distance <= reach) distance = measure(pair, sample);
      *clear = distance + sum;
    }
  }
}

void Tracker::between_movers(int sample) {
  const size_t count = cell_.between_movers.size();
  double* clear = clear_between_.data() + sample * count;
  for (size_t entry = 0; entry < count; ++entry, ++clear) {
    const int pair = cell_.between_movers[entry];
    const auto [first, second] = cell_.pairs[pair];
    const double sum = moved(sample, cell_.mover_of[first]) + moved(sample, cell_.mover_of[second]);
    if (*clear - sum > reach_[pair]) continue;
    double distance = lower_bound(cell_.bodies[first], at(sample, first), cell_.bodies[second], at(sample, second), reach_[pair]);
    ++work.bounds;
    if (distance <= reach_[pair]) distance = measure(pair, sample);
    *clear = distance + sum;
  }
}

// Ask Coal; a close pair becomes a row.
double Tracker::measure(int pair, int sample) {
  const auto [first, second] = cell_.pairs[pair];
  const Body &a = cell_.bodies[first], &b = cell_.bodies[second];
  const auto* placed = joints_.data() + static_cast<size_t>(sample) * cell_.robot.joints();
  const Nearest found =
      narrow_(a, transform(a, placed[a.joint]), b, transform(b, placed[b.joint]), reach_[pair]);
  ++work.distances;
  if (found.distance < reach_[pair]) add_row(pair, sample, found);
  return std::isnan(found.distance) ? kNever : found.distance;
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
  Eigen::Map<Eigen::VectorXd> row(found_.jacobian.data() + start, robot.dofs());
  const auto* placed = joints_.data() + static_cast<size_t>(sample) * robot.joints();
  const auto add = [&](int body, const Vector3& point, double sign) {
    for (int joint : robot.supports[cell_.bodies[body].joint]) {
      const auto& frame = placed[joint];
      const Vector3 linear = frame.rotation() * robot.axis[joint].linear();
      const Vector3 angular = frame.rotation() * robot.axis[joint].angular();
      const double speed = found.normal.dot(linear + angular.cross(point - frame.translation()));
      row += sign * speed * robot.expand.row(robot.model->joints[joint].idx_v()).transpose();
    }
  };
  add(cell_.pairs[pair].second, found.second, 1.0);
  add(cell_.pairs[pair].first, found.first, -1.0);
}

}  // namespace proximity
