// The bodies of a model, the pairs of them that must keep apart, and the frames in which pairs are looked at.
#pragma once

#include <memory>
#include <vector>

#include "arm.hpp"
#include "form.hpp"

namespace proof {

struct Body {
  std::shared_ptr<const Form> form;
  int joint;
  Pose in_joint;
  Vec centre = in_joint * form->centre;  // Of its bounding sphere, in the joint's frame [m].
};

// A body as seen from a joint's frame, by which joints it moves there.
struct Traveller {
  int body;
  int frame;
  std::vector<int> chain;  // Outermost first.
  int slot;                // Number among the travellers that do move; -1 for those that rest.

  bool rests() const { return slot < 0; }
};

// How far the points of a body may be from where its joints have them, growing with time [m].
struct Error {
  double radius = 0.0, velocity = 0.0, acceleration = 0.0;

  double at(double time) const { return radius + velocity * time + acceleration * time * time / 2.0; }
};

struct Pair {
  int first, second;             // Bodies.
  int frame;                     // Joint in whose frame both are looked at: innermost that carries both, or a plane's.
  int first_seen, second_seen;   // Travellers.
  bool planar, meshed, clouded;
  double radii;                  // Of both bounding spheres together [m].
  double required;               // Clearance [m].
  Error error;                   // Of both bodies together.
  int level;                     // Its number among all that are required.
};

struct Bodies {
  Arm arm;
  std::vector<Body> bodies;
  std::vector<Pair> pairs;
  std::vector<Traveller> travellers;
  std::vector<double> levels;  // Clearances that are required of some pair, the smallest first [m].
  size_t moving = 0;  // Travellers that do move.

  Bodies(Arm arm, std::vector<Body> bodies, const int64_t* first, const int64_t* second,
         const double* required, size_t count);

  const Form& form(int body) const { return *bodies[body].form; }

  // Number of the traveller that is a body seen from a joint's frame; there must be one.
  int seen_from(int body, int frame) const { return numbers_[key(body, frame)]; }

 private:
  std::vector<int> numbers_;  // Of travellers, by body and joint; -1 for none.
  size_t key(int body, int frame) const { return size_t(body) * arm.joints.size() + size_t(frame); }
  int traveller(int body, int frame);
};

// Where everything is at one moment; bodies are placed when asked for.
class Snapshot {
 public:
  Snapshot(const Bodies& bodies, double time, const double* positions);
  // From joint frames computed elsewhere.
  Snapshot(const Bodies& bodies, double time, std::vector<Pose> joints);

  const double time;
  const std::vector<Pose>& joints() const { return joints_; }
  // Of a traveller's shape in the frame it is seen from; the address stays.
  const Pose& seen(int traveller);
  // Centre of a body's bounding sphere in the world [m].
  const Vec& centre(int body) const { return centres_[body]; }

 private:
  const Bodies& bodies_;
  std::vector<Pose> joints_, seen_;
  std::vector<Vec> centres_;
  std::vector<char> known_;
};

// Distance of the bounding spheres of a pair, less its error [m]; minus infinity for half-spaces.
double sphere_gap(Snapshot& at, const Pair& pair);
// Smallest such distance, without the error, while each centre moves along the chord between its places at two moments.
double sphere_gap(const Bodies& bodies, Snapshot& early, Snapshot& late, const Pair& pair);

}  // namespace proof
