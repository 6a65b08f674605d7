// How far a hull stands out of a mesh: bounded from both sides by dividing its faces.
#pragma once

#include "room.hpp"

namespace covers {

struct StandOut {
  double found = 0.0;  // A point of the hull's faces stands out so far [m],
  double bound = 0.0;  // and none farther than this.
  Samples beyond;      // Points found farther out than was asked for.
};

struct Question {
  double enough;        // A bound this low ends the search [m].
  double too_far;       // So do points found farther out than this,
  size_t wanted;        // if there are so many.
  double accuracy;      // And the bound so near to what was found.
  int most_points;      // And so many points looked at: then the bound is what is known.
};

// A hull holds no place farther from the mesh than its faces do, but those that nothing can enter through its faces.
// What the room tells to be solid or shut does not count; without a room all of the faces is outside.
StandOut stand_out(const Hull& hull, const Surface& surface, const Room* room, const Question& question);

}  // namespace covers
