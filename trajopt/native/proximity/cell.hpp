// A robot among its obstacles as the loops need it: built from what Python made, never changed.
#pragma once

#include <cstdint>
#include <vector>

#include "bodies.hpp"
#include "obstacles.hpp"
#include "robot.hpp"

namespace proximity {

struct Pair {
  int first, second;  // bodies
};

// The tolerances that Coal works with: of GJK, and of EPA in penetration, the second where the first fails.
struct Accuracy {
  double gjk, epa, epa_again;
};

// What was done: bounds of distance that were compared, and calls of Coal.
struct Work {
  std::int64_t bounds = 0, distances = 0;
};

struct Cell {
  Robot robot;
  std::vector<Body> bodies;
  std::vector<Pair> pairs;
  Accuracy accuracy;

  std::vector<int> movers;             // bodies that joints carry and that occur in a pair
  std::vector<int> mover_of;           // place of each body among them, -1 for none
  std::vector<Place> still;            // of the bodies that stand still
  std::vector<int> between_movers;     // pairs of two movers
  std::vector<std::vector<int>> pair_with;  // mover, body that stands still -> pair, -1 for none
  Obstacles obstacles;

  Cell(const Cell&) = delete;
  Cell(Robot handed, std::vector<Body> all, std::vector<Pair> kept, const Accuracy& tolerances)
      : robot(std::move(handed)), bodies(std::move(all)), pairs(std::move(kept)), accuracy(tolerances) {
    std::vector<char> occurs(bodies.size(), 0);
    for (const Pair& pair : pairs) occurs[pair.first] = occurs[pair.second] = 1;
    mover_of.assign(bodies.size(), -1);
    still.resize(bodies.size());
    for (int body = 0; body < static_cast<int>(bodies.size()); ++body) {
      if (bodies[body].joint == 0) {
        still[body] = {bodies[body].rotation, bodies[body].centre};
        if (occurs[body]) obstacles.add(body, bodies[body]);
      } else if (occurs[body]) {
        mover_of[body] = static_cast<int>(movers.size());
        movers.push_back(body);
      }
    }
    obstacles.build();
    pair_with.assign(movers.size(), std::vector<int>(bodies.size(), -1));
    for (int index = 0; index < static_cast<int>(pairs.size()); ++index) {
      const int first = mover_of[pairs[index].first], second = mover_of[pairs[index].second];
      if (first >= 0 && second >= 0) {
        between_movers.push_back(index);
      } else {
        pair_with[first >= 0 ? first : second][first >= 0 ? pairs[index].second : pairs[index].first] = index;
      }
    }
  }
};

}  // namespace proximity
