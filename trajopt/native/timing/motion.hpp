// A trajectory: quintic polynomials between points with positions, velocities and accelerations.
#pragma once

#include "grid.hpp"

namespace timing {

class Motion {
 public:
  Motion() = default;
  Motion(Numbers times, Table q, Table v, Table a)
      : times(std::move(times)), q(std::move(q)), v(std::move(v)), a(std::move(a)) {}

  // Times a path: a point at each grid point.
  Motion(const DiscretisedPath& on, const Profile& profile) : times(profile.times), q(on.q), v(on.dq), a(on.dq) {
    for (std::size_t i = 0; i < on.points(); ++i) {
      const double speed = std::sqrt(profile.x[i]);
      for (std::size_t joint = 0; joint < joints(); ++joint) {
        v[i][joint] = on.dq[i][joint] * speed;
        a[i][joint] = on.dq[i][joint] * profile.u[i] + on.ddq[i][joint] * profile.x[i];
      }
    }
  }

  std::size_t pieces() const { return times.size() - 1; }
  std::size_t joints() const { return q.columns; }
  double duration() const { return times.back(); }
  double width(std::size_t piece) const { return times[piece + 1] - times[piece]; }

  // The same path run slower: times multiplied by a factor.
  Motion slowed(double factor) const {
    Motion slow = *this;
    for (double& each : slow.times) each *= factor;
    for (double& each : slow.v.values) each /= factor;
    for (double& each : slow.a.values) each /= factor * factor;
    return slow;
  }

  // The polynomials of a piece.
  class Piece {
   public:
    Piece(const Motion& motion, std::size_t piece)
        : width(motion.width(piece)), square_(width * width), third_(1.0 / (square_ * width)), fourth_(third_ / width),
          fifth_(fourth_ / width), q_(motion.q[piece]), v_(motion.v[piece]), a_(motion.a[piece]), n_(motion.joints()) {}

    // Coefficients of one joint, highest power of the time since the first point first.
    void coefficients(std::size_t joint, double c[6]) const {
      const double q = q_[joint], v = v_[joint], a = a_[joint], h = width;
      // Residuals of position, velocity, acceleration at the end after the quadratic from the start.
      const double dq = q_[n_ + joint] - q - v * h - a * square_ / 2.0;
      const double dv = (v_[n_ + joint] - v - a * h) * h, da = (a_[n_ + joint] - a) * square_;
      c[0] = (6.0 * dq - 3.0 * dv + da / 2.0) * fifth_, c[1] = (-15.0 * dq + 7.0 * dv - da) * fourth_;
      c[2] = (10.0 * dq - 4.0 * dv + da / 2.0) * third_, c[3] = a / 2.0, c[4] = v, c[5] = q;
    }

    const double width;

   private:
    double square_, third_, fourth_, fifth_;
    const double *q_, *v_, *a_;  // at the first point; the second follows
    std::size_t n_;
  };

  // The state when a part of the time of a piece has passed.
  void within(std::size_t piece, double part, double* position, double* velocity, double* acceleration) const {
    const Piece polynomials(*this, piece);
    const double t = part * polynomials.width;
    for (std::size_t joint = 0; joint < joints(); ++joint) {
      double c[6];
      polynomials.coefficients(joint, c);
      position[joint] = ((((c[0] * t + c[1]) * t + c[2]) * t + c[3]) * t + c[4]) * t + c[5];
      velocity[joint] = (((5.0 * c[0] * t + 4.0 * c[1]) * t + 3.0 * c[2]) * t + 2.0 * c[3]) * t + c[4];
      acceleration[joint] = ((20.0 * c[0] * t + 12.0 * c[1]) * t + 6.0 * c[2]) * t + 2.0 * c[3];
    }
  }

  Numbers times;  // from 0
  Table q, v, a;  // (points, joints)
};

// States of a motion, one after the other.
struct States {
  Table q, v, a;

  States(std::size_t count, std::size_t joints) : q(count, joints), v(count, joints), a(count, joints) {}

  void point(std::size_t row, const Motion& motion, std::size_t point) {
    q.set(row, motion.q[point]), v.set(row, motion.v[point]), a.set(row, motion.a[point]);
  }
  void within(std::size_t row, const Motion& motion, std::size_t piece, double part) {
    motion.within(piece, part, q[row], v[row], a[row]);
  }
};

}  // namespace timing
