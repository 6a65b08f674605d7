// Primal-dual interior point method with Mehrotra's predictor and corrector for a `Program`.
//
// Each penalised row, row x - bound = t - s with s, t >= 0, costs penalty t. Its multipliers, lambda of s >= 0 and
// nu of t >= 0, add up to the penalty: that is stationarity in t, and is kept exactly. Eliminating s, t and both
// multipliers leaves, with w = 1 / (s / lambda + t / nu) for each row,
//
//   (H + A' diag(w) A + Z_l / S_l + Z_u / S_u) dx = right-hand side,
//
// a band whose pattern is the same whatever the number of rows. Bounds are simple: x stays strictly inside.
// Included once for each kind of processor, after `tiles.hpp`.
// Source: Nocedal and Wright, Numerical Optimization (2006), section 16.6 and algorithm 16.4; the elimination of
// the slacks is worked out in docs/decisions/banded-qp.md.

constexpr double kBackOff = 0.995;  // of the longest step that keeps all slacks positive

// Numbers that stay positive, their reciprocals, and their changes. In lanes that are not taken all are zero.
struct Positive {
  Eights value, inverse, change;

  void resize(int groups) {
    for (Eights* each : {&value, &inverse, &change}) each->resize(groups);
  }
};

// What must not become negative, with its multipliers, and what their products aim at.
struct Products {
  Positive room, multiplier;
  Eights target;

  explicit Products(int groups) : target(groups) {
    room.resize(groups);
    multiplier.resize(groups);
  }
  int groups() const { return static_cast<int>(target.size()); }
};

class InteriorPoint {
 public:
  InteriorPoint(const Program& program, const Eights& lower, const Eights& upper, const Options& options)
      : program_(program),
        lower_(lower),
        upper_(upper),
        options_(options),
        variables_(program.variable_groups()),
        rows_(program.row_groups()),
        x_(variables_),
        dx_(variables_),
        stationarity_(variables_),
        to_lower_(variables_),
        to_upper_(variables_),
        below_(rows_),
        above_(rows_),
        excess_(rows_ + 1),
        weight_(rows_ + 1),
        along_(rows_ + 1),
        inverse_(variables_) {}

  Solution solve() {
    Solution solution;
    start();
    residuals();
    for (; solution.iterations < options_.max_iterations; ++solution.iterations) {
      if (error_bound() <= options_.accuracy) {
        solution.outcome = Outcome::kSolved;
        break;
      }
      invert();
      factorise_system();
      const int products = 2 * (program_.size() + program_.row_count());
      aim(0.0, false);
      direction();
      const double predicted = gap_after(longest_step());
      const double ratio = predicted / gap_;
      aim(ratio * ratio * ratio * gap_ / products, true);
      direction();
      take(std::min(1.0, kBackOff * longest_step()));
      residuals();
      if (!std::isfinite(gap_)) break;
    }
    if (solution.iterations == options_.max_iterations) solution.outcome = Outcome::kInaccurate;
    solution.reduction = reduction();
    solution.x = std::move(x_);
    return solution;
  }

 private:
  // At zero, or hardly inside the bounds that it is at: where a row is steep, as a limit of acceleration is, a small way
  // off already breaks it by far more than its slack. Slacks so that both products of a row are equal.
  void start() {
    for (int j = 0; j < variables_ * kLanes; ++j) {
      const double low = numbers(lower_)[j], high = numbers(upper_)[j], inside = options_.inside * (high - low);
      const double x = std::clamp(0.0, low + inside, high - inside);
      numbers(x_)[j] = x;
      numbers(to_lower_.room.value)[j] = x - low;
      numbers(to_upper_.room.value)[j] = high - x;
    }
    multiply(program_.rows, x_, along_);
    double total = 0.0;
    for (int row = 0; row < rows_ * kLanes; ++row) {
      if (numbers(program_.row_there)[row] == 0.0) continue;
      const double excess = numbers(along_)[row] - numbers(program_.bound)[row];
      const double t = std::max(excess, 0.0) + options_.start, s = std::max(-excess, 0.0) + options_.start;
      const double penalty = numbers(program_.penalty)[row], lambda = penalty * (t / (t + s));
      numbers(below_.room.value)[row] = s;
      numbers(above_.room.value)[row] = t;
      numbers(below_.multiplier.value)[row] = lambda;
      numbers(above_.multiplier.value)[row] = penalty - lambda;
      total += lambda * s;
    }
    const double centre = program_.row_count() > 0 ? total / program_.row_count() : options_.start;
    for (Products* each : {&to_lower_, &to_upper_}) {
      reciprocals(program_.variable_there, each->room);
      for (int k = 0; k < variables_; ++k) {
        for (int p = 0; p < kParts; ++p) part(each->multiplier.value[k], p) = centre * part(each->room.inverse[k], p);
      }
    }
    gap_ = gap_after(0.0);
  }

  void residuals() {
    multiply(program_.hessian, x_, stationarity_);
    for (int k = 0; k < variables_; ++k) {
      for (int p = 0; p < kParts; ++p) {
        part(stationarity_[k], p) += part(program_.gradient[k], p) - part(to_lower_.multiplier.value[k], p) +
                                     part(to_upper_.multiplier.value[k], p);
      }
    }
    add_rows(program_.rows, below_.multiplier.value, stationarity_);
    multiply(program_.rows, x_, along_);
    for (int k = 0; k < rows_; ++k) {
      for (int p = 0; p < kParts; ++p) part(excess_[k], p) = part(along_[k], p) - part(program_.bound[k], p);
    }
  }

  // By how much the objective exceeds its least value, at most: the duality gap, and what is left of the gradient
  // times the way that any variable could still go.
  double error_bound() const {
    Vec total[kParts] = {};
    for (int k = 0; k < variables_; ++k) {
      for (int p = 0; p < kParts; ++p) {
        const Vec left = part(stationarity_[k], p);
        total[p] += (left < 0.0 ? -left : left) * (part(upper_[k], p) - part(lower_[k], p));
      }
    }
    return gap_ + sum(total);
  }

  static void reciprocals(const Eights& there, Positive& of) {
    const int groups = static_cast<int>(of.value.size());
    for (int k = 0; k < groups; ++k) {
      for (int p = 0; p < kParts; ++p) {
        const Vec taken = part(there[k], p);
        part(of.inverse[k], p) = taken / (part(of.value[k], p) + (1.0 - taken));
      }
    }
  }

  void invert() {
    for (Products* each : {&to_lower_, &to_upper_}) {
      reciprocals(program_.variable_there, each->room);
      reciprocals(program_.variable_there, each->multiplier);
    }
    for (Products* each : {&below_, &above_}) {
      reciprocals(program_.row_there, each->room);
      reciprocals(program_.row_there, each->multiplier);
    }
    for (int k = 0; k < rows_; ++k) {
      for (int p = 0; p < kParts; ++p) {
        const Vec taken = part(program_.row_there[k], p);
        const Vec compliance = part(below_.room.value[k], p) * part(below_.multiplier.inverse[k], p) +
                               part(above_.room.value[k], p) * part(above_.multiplier.inverse[k], p);
        part(weight_[k], p) = taken / (compliance + (1.0 - taken));
      }
    }
  }

  void factorise_system() {
    system_ = program_.hessian;
    for (int k = 0; k < variables_; ++k) {
      Eight added;
      for (int p = 0; p < kParts; ++p) {
        part(added, p) = part(to_lower_.multiplier.value[k], p) * part(to_lower_.room.inverse[k], p) +
                         part(to_upper_.multiplier.value[k], p) * part(to_upper_.room.inverse[k], p);
      }
      for (int c = 0; c < kLanes; ++c) system_.tile(k, 0).column[c].lane[c] += added.lane[c];
    }
    add_outers(program_.rows, weight_, system_);
    factorise(system_, inverse_);
  }

  void aim(double target, bool corrected) {
    const double share = corrected ? 1.0 : 0.0;
    for (Products* each : {&to_lower_, &to_upper_, &below_, &above_}) {
      for (int k = 0; k < each->groups(); ++k) {
        for (int p = 0; p < kParts; ++p) {
          part(each->target[k], p) = target - share * part(each->multiplier.change[k], p) * part(each->room.change[k], p);
        }
      }
    }
  }

  void direction() {
    Eights& scaled = below_.multiplier.change;  // -w (excess + below / lambda - above / nu), before row dx is known
    for (int k = 0; k < rows_; ++k) {
      for (int p = 0; p < kParts; ++p) {
        const Vec shift = part(below_.target[k], p) * part(below_.multiplier.inverse[k], p) -
                          part(above_.target[k], p) * part(above_.multiplier.inverse[k], p);
        part(scaled[k], p) = -part(weight_[k], p) * (part(excess_[k], p) + shift);
      }
    }
    for (int k = 0; k < variables_; ++k) {
      for (int p = 0; p < kParts; ++p) {
        part(dx_[k], p) =
            (part(to_lower_.target[k], p) * part(to_lower_.room.inverse[k], p) - part(to_lower_.multiplier.value[k], p)) -
            (part(to_upper_.target[k], p) * part(to_upper_.room.inverse[k], p) - part(to_upper_.multiplier.value[k], p)) -
            part(stationarity_[k], p);
      }
    }
    add_rows(program_.rows, scaled, dx_);
    solve_in_place(system_, inverse_, dx_);
    multiply(program_.rows, dx_, along_);
    for (int k = 0; k < rows_; ++k) {
      for (int p = 0; p < kParts; ++p) {
        const Vec change = part(weight_[k], p) * part(along_[k], p) - part(scaled[k], p);
        part(below_.multiplier.change[k], p) = change;
        part(above_.multiplier.change[k], p) = -change;
        const Vec s = part(below_.room.value[k], p), t = part(above_.room.value[k], p);
        part(below_.room.change[k], p) =
            (part(below_.target[k], p) - s * change) * part(below_.multiplier.inverse[k], p) - s;
        part(above_.room.change[k], p) =
            (part(above_.target[k], p) + t * change) * part(above_.multiplier.inverse[k], p) - t;
      }
    }
    change_of_bounds(1.0, to_lower_);
    change_of_bounds(-1.0, to_upper_);
  }

  void change_of_bounds(double sign, Products& bound) const {
    for (int k = 0; k < variables_; ++k) {
      for (int p = 0; p < kParts; ++p) {
        const Vec change = sign * part(dx_[k], p), multiplier = part(bound.multiplier.value[k], p);
        part(bound.room.change[k], p) = change;
        part(bound.multiplier.change[k], p) =
            (part(bound.target[k], p) - multiplier * change) * part(bound.room.inverse[k], p) - multiplier;
      }
    }
  }

  double longest_step() const {
    Eight most;  // of what vanishes first
    fill(kBackOff, most);
    for (const Products* products : {&to_lower_, &to_upper_, &below_, &above_}) {
      for (const Positive* each : {&products->room, &products->multiplier}) {
        for (int k = 0; k < products->groups(); ++k) {
          for (int p = 0; p < kParts; ++p) {
            const Vec slope = -part(each->change[k], p) * part(each->inverse[k], p);
            part(most, p) = slope > part(most, p) ? slope : part(most, p);
          }
        }
      }
    }
    return 1.0 / *std::max_element(most.lane, most.lane + kLanes);
  }

  double gap_after(double step) const {
    Vec total[kParts] = {};
    for (const Products* each : {&to_lower_, &to_upper_, &below_, &above_}) {
      for (int k = 0; k < each->groups(); ++k) {
        for (int p = 0; p < kParts; ++p) {
          total[p] += (part(each->multiplier.value[k], p) + step * part(each->multiplier.change[k], p)) *
                      (part(each->room.value[k], p) + step * part(each->room.change[k], p));
        }
      }
    }
    return sum(total);
  }

  void take(double step) {
    for (int k = 0; k < variables_; ++k) {
      for (int p = 0; p < kParts; ++p) part(x_[k], p) += step * part(dx_[k], p);
    }
    Vec total[kParts] = {};
    for (Products* each : {&to_lower_, &to_upper_, &below_, &above_}) {
      for (int k = 0; k < each->groups(); ++k) {
        for (int p = 0; p < kParts; ++p) {
          Vec& multiplier = part(each->multiplier.value[k], p);
          Vec& room = part(each->room.value[k], p);
          multiplier += step * part(each->multiplier.change[k], p);
          room += step * part(each->room.change[k], p);
          total[p] += multiplier * room;
        }
      }
    }
    gap_ = sum(total);
  }

  // Of 1/2 x'Hx + g'x + the penalised excess; good after `residuals`.
  double reduction() {
    multiply(program_.hessian, x_, dx_);
    double found = 0.0;
    for (int j = 0; j < variables_ * kLanes; ++j) {
      found -= (0.5 * numbers(dx_)[j] + numbers(program_.gradient)[j]) * numbers(x_)[j];
    }
    for (int row = 0; row < rows_ * kLanes; ++row) {
      const double before = std::max(0.0, -numbers(program_.bound)[row]);
      found += numbers(program_.penalty)[row] * (before - std::max(0.0, numbers(excess_)[row]));
    }
    return found;
  }

  const Program& program_;
  const Eights &lower_, &upper_;
  Options options_;
  int variables_, rows_;  // groups of eight

  Eights x_, dx_, stationarity_;
  double gap_ = 0.0;  // of the products
  Products to_lower_, to_upper_;  // of variables
  Products below_, above_;        // of rows: s and lambda, t and nu
  Eights excess_, weight_, along_;
  Band system_;
  Eights inverse_;
};
