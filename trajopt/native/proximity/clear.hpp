// Whether every pair keeps at least its reach at a configuration: yes or no, the cheapest test first.
//
// What undercut its reach lately is asked first: neighbouring configurations mostly touch the same thing. Then come
// spheres and boxes of all pairs; for those that these leave within reach the direction along which the pair was
// apart last, and Coal.
#pragma once

#include <cstdint>
#include <vector>

#include "cell.hpp"
#include "cloud_phase.hpp"
#include "narrow.hpp"

namespace proximity {

using Places = std::vector<Place, Eigen::aligned_allocator<Place>>;

class Clear {
 public:
  Clear(const Cell& cell, std::vector<double> reach);

  bool operator()(const double* positions);

  // Place the moving bodies, and ask nothing.
  void place_at(const double* positions);

  // Where the moving bodies were at the configuration that was asked or placed last.
  const Places& places() const { return places_; }

  // The largest motion bound of any moving body between two of these.
  double motion_between(const Places& from, const Places& to) const;

  std::int64_t looked = 0;  // configurations
  Work work;

 private:
  // Bodies that stand still are looked up in their tree where there are more; below, asking each is cheaper.
  static constexpr int kFew = 32;
  static constexpr size_t kRemembered = 6;

  // A body that stands still, as the sphere around a moving one has to keep away from it.
  struct Still {
    Vector3 centre;
    double square;  // of the centres' distance at which the spheres keep the pair's reach
    int pair, body;
  };

  // Two moving bodies, likewise.
  struct Moving {
    int first, second;  // movers
    double square;
    int pair;
  };

  bool bounds_keep(int pair);
  bool keeps(int pair);
  void remember(int pair);
  void collect();
  void collect_near(int mover);
  void doubt(int pair, const Body& a, const Place& at_a, const Body& b, const Place& at_b);
  const Place& at(int body) const;

  const Cell& cell_;
  std::vector<double> reach_;
  double longest_reach_ = 0.0;
  Kinematics kinematics_;
  NarrowPhase narrow_;
  CloudPhase clouds_{narrow_};
  const Placements* placed_ = nullptr;
  Places places_;                             // by mover
  std::vector<std::vector<Still>> with_still_;  // by mover, in the order of the bodies
  std::vector<Moving> between_;
  std::vector<char> many_;                    // mover -> whether these are looked up in the tree
  std::vector<int> remembered_;               // pairs that undercut their reach, the last one first
  std::vector<int> doubtful_;                 // pairs that spheres and boxes leave within reach
  std::vector<Vector3> across_;               // pair -> direction along which it was apart, zero where none is known
  std::vector<int> near_;
  std::vector<int> struck_;                   // pair with a cloud -> which of its balls or cubes was too near at last
};

}  // namespace proximity
