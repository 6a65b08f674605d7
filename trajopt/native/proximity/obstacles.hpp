// Bodies that stand still, in Coal's tree of axis-aligned boxes: which of them are near a ball?
#pragma once

#include <coal/broadphase/broadphase_dynamic_AABB_tree.h>
#include <coal/shape/geometric_shapes.h>

#include <cstdint>
#include <vector>

#include "bodies.hpp"

namespace proximity {

class Obstacles {
 public:
  // Bodies whose sphere is at least this large (half-spaces) are near everything.
  static constexpr double kUnbounded = 1e3;

  void add(int index, const Body& body) {
    if (body.radius >= kUnbounded) {
      everywhere_.push_back(index);
      return;
    }
    const Vector3 extent = body.rotation.cwiseAbs() * body.half;
    objects_.push_back(ball_box(body.centre, extent));
    objects_.back()->setUserData(reinterpret_cast<void*>(static_cast<std::intptr_t>(index)));
  }

  void build() {
    std::vector<coal::CollisionObject*> raw;
    for (const auto& object : objects_) raw.push_back(object.get());
    if (!raw.empty()) tree_.registerObjects(raw);
    tree_.setup();
  }

  // Append all bodies whose box is nearer to a point than a radius.
  void near(const Vector3& centre, double radius, std::vector<int>& found) const {
    found.insert(found.end(), everywhere_.begin(), everywhere_.end());
    if (objects_.empty()) return;
    const auto ball = ball_box(centre, Vector3::Constant(radius));
    Collect collect(found);
    tree_.collide(ball.get(), &collect);
  }

 private:
  struct Collect : coal::CollisionCallBackBase {
    explicit Collect(std::vector<int>& target) : found(target) {}
    bool collide(coal::CollisionObject* one, coal::CollisionObject* other) override {
      void* tag = one->getUserData() == kBall ? other->getUserData() : one->getUserData();
      found.push_back(static_cast<int>(reinterpret_cast<std::intptr_t>(tag)));
      return false;
    }
    std::vector<int>& found;
  };

  static inline void* const kBall = reinterpret_cast<void*>(std::intptr_t{-1});

  static std::unique_ptr<coal::CollisionObject> ball_box(const Vector3& centre, const Vector3& extent) {
    auto object = std::make_unique<coal::CollisionObject>(std::make_shared<coal::Box>(2.0 * extent),
                                                          Matrix3::Identity(), centre);
    object->setUserData(kBall);
    return object;
  }

  std::vector<std::unique_ptr<coal::CollisionObject>> objects_;
  std::vector<int> everywhere_;
  coal::DynamicAABBTreeCollisionManager tree_;
};

}  // namespace proximity
