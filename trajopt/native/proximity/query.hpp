// What one thread asks a cell with.
#pragma once

#include "../robot_query.hpp"
#include "tracker.hpp"

namespace proximity {

struct Query : robot::RobotQuery {
  // stands_for: of each pair of the cell the pair that is asked about; as they are where it is empty.
  Query(const Cell& asked, std::vector<int> stands_for, int count)
      : cell(asked), kinematics(asked.robot), tracker(asked), stands_for_(std::move(stands_for)), pairs_(count) {}
  explicit Query(const Cell& asked) : Query(asked, {}, static_cast<int>(asked.pairs.size())) {}

  int positions() const override { return cell.robot.dofs(); }
  int joints() const override { return cell.robot.joints(); }
  int pairs() const override { return pairs_; }

  robot::Near near(const double* positions, int samples, const std::vector<double>& reach,
                   const std::vector<double>& aim) override {
    const ClosePairs& found = close_pairs(positions, samples, reach, aim);
    return {found.pair.size(), found.sample.data(), found.pair.data(), found.distance.data(), found.jacobian.data()};
  }

  // Near pairs by the numbers that are asked about.
  const ClosePairs& close_pairs(const double* positions, int samples, const std::vector<double>& reach,
                                const std::vector<double>& aim) {
    if (stands_for_.empty()) return tracker.close_pairs(positions, samples, reach, aim);
    reach_.resize(stands_for_.size());
    aim_.resize(stands_for_.size());
    for (std::size_t pair = 0; pair < reach_.size(); ++pair) {
      reach_[pair] = reach[stands_for_[pair]];
      aim_[pair] = aim[stands_for_[pair]];
    }
    found_ = tracker.close_pairs(positions, samples, reach_, aim_);
    for (std::int64_t& pair : found_.pair) pair = stands_for_[pair];
    return found_;
  }

  void see(const robot::View& view, const double* positions, robot::Seen& seen) override {
    const auto& placed = kinematics(positions);
    const auto &carrier = placed[view.joint], &base = placed[view.base];
    const Vector3 point = carrier.act(view.point);
    const Matrix3 to_base = (base.rotation() * view.base_rotation).transpose();
    seen.point = to_base * (point - base.act(view.base_origin));
    seen.rotation = to_base * carrier.rotation() * view.rotation;
    seen.point_rate.setZero(3, cell.robot.dofs());
    seen.spin.setZero(3, cell.robot.dofs());
    const auto add = [&](int carried, double sign) {
      for (int joint : cell.robot.supports[carried]) {
        const auto by_group = cell.robot.expand.row(cell.robot.column(joint));
        const Vector3 angular = placed[joint].rotation() * cell.robot.axis[joint].angular();
        const Vector3 linear = placed[joint].rotation() * cell.robot.axis[joint].linear() +
                               angular.cross(point - placed[joint].translation());
        seen.point_rate += sign * (to_base * linear) * by_group;
        seen.spin += sign * (to_base * angular) * by_group;
      }
    };
    add(view.joint, 1.0);
    add(view.base, -1.0);
  }

  robot::Work work() const override { return {tracker.work.bounds, tracker.work.distances}; }

  const Cell& cell;
  Kinematics kinematics;
  Tracker tracker;

 private:
  std::vector<int> stands_for_;
  int pairs_;
  std::vector<double> reach_, aim_;
  ClosePairs found_;
};

}  // namespace proximity
