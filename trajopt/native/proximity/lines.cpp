#include "lines.hpp"

namespace proximity {

bool Lines::free(const double* from, const double* to) {
  used_ = 0;
  if (!clear(to)) return false;
  const int last = keep_places();
  clear.place_at(from);
  const int first = keep_places();
  double turn = 0.0;
  for (int joint = 0; joint < dofs_; ++joint) turn += std::abs(to[joint] - from[joint]);
  waiting_.assign(1, {0.0, 1.0, first, last});
  // First in, first out: all stretches of one length before any that is shorter.
  for (size_t next = 0; next < waiting_.size(); ++next) {
    const Stretch whole = waiting_[next];
    const bool short_enough = (whole.to - whole.from) * turn <= kTurn;
    if (short_enough && clear.motion_between(looked_[whole.first], looked_[whole.last]) <= step_) continue;
    const double middle = 0.5 * (whole.from + whole.to);
    if (!clear_at(from, to, middle)) return false;
    const int place = keep_places();
    waiting_.push_back({whole.from, middle, whole.first, place});
    waiting_.push_back({middle, whole.to, place, whole.last});
  }
  return true;
}

bool Lines::clear_at(const double* from, const double* to, double share) {
  for (int joint = 0; joint < dofs_; ++joint) between_[joint] = from[joint] + share * (to[joint] - from[joint]);
  return clear(between_.data());
}

int Lines::keep_places() {
  if (used_ == static_cast<int>(looked_.size())) looked_.emplace_back();
  looked_[used_] = clear.places();
  return used_++;
}

}  // namespace proximity
