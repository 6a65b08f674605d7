#include "candidates.hpp"

#include <algorithm>

namespace proof {

Candidates::Candidates(const Bodies& bodies, const std::vector<char>& always) : bodies_(bodies) {
  const size_t count = bodies.bodies.size();
  std::vector<char> standing(count, 0);
  row_of_.assign(count, -1);
  for (size_t number = 0; number < bodies.pairs.size(); ++number) {
    const Pair& pair = bodies.pairs[number];
    const bool first_stands = bodies.bodies[pair.first].joint == 0;
    const bool second_stands = bodies.bodies[pair.second].joint == 0;
    if (pair.planar || always[number] || first_stands == second_stands) {
      listed_.push_back(int(number));
      continue;
    }
    const int mover = first_stands ? pair.second : pair.first, obstacle = first_stands ? pair.first : pair.second;
    if (row_of_[mover] < 0) {
      row_of_[mover] = int(movers_.size());
      movers_.push_back(mover);
      pair_of_.resize(pair_of_.size() + count, -1);
    }
    pair_of_[size_t(row_of_[mover]) * count + obstacle] = int(number);
    standing[obstacle] = 1;
    reserve_ = std::max(reserve_, pair.error.radius);
  }
  std::vector<int> obstacles;
  for (size_t body = 0; body < count; ++body) {
    if (standing[body]) obstacles.push_back(int(body));
  }
  tree_ = ObstacleTree(bodies, obstacles);
}

}  // namespace proof
