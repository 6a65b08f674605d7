// Certified gap between two convex parts that each move from one place to another, by the algorithm of Gilbert,
// Johnson and Keerthi (IEEE J. Robotics and Automation 1988) on the hull of their differences at both times.
//
// Along a unit direction n the gap at time t is min_B n x - max_A n x. Whatever the algorithm's tolerances do,
// the smaller of the gaps at both times is a lower bound of the distance at both, and with chords in the place
// of paths, of all times between: what is returned as `gap` is one, from the support functions alone.
#pragma once

#include "form.hpp"

namespace proof {

// A convex shape, or a triangle or box of a mesh's tree, or a part of a cloud.
struct Part {
  const Form* form;
  int node = -1;  // Of the form's tree; -1 for the form itself.

  Vec support(const Vec& direction) const;
  double rounding() const { return node < 0 || form->points != nullptr ? form->rounding : 0.0; }
};

// Two parts, each at its place at both times, in one frame; equal pointers stand for one place.
struct Sweep {
  Part first, second;
  const Pose* first_at[2];
  const Pose* second_at[2];

  // Point of the difference b - a that is farthest against the direction, at either time.
  Vec lowest(const Vec& direction) const;
};

struct Separation {
  double gap;     // Proven lower bound of the distance [m]; -infinity if none was found.
  double upper;   // Distance of the hull's nearest known point [m]: no larger gap exists.
  Vec direction;  // Unit direction of the gap, from a to b.
  bool overlap;   // The cores overlap: no direction separates them.
};

enum class Aim {
  Prove,    // End, too, once no gap can be as large.
  Measure,  // Otherwise find the largest gap.
};

// Look for a direction along which the gap is at least `enough`, starting with a guess of any length.
Separation separate(const Sweep& sweep, const Vec& guess, double enough, Aim aim);

}  // namespace proof
