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
    boxes_.push_back({body.centre, extent, index});
  }

  void build() {
    if (boxes_.size() <= kFew) return;
    std::vector<coal::CollisionObject*> raw;
    for (const Box& box : boxes_) {
      objects_.push_back(std::make_unique<coal::CollisionObject>(std::make_shared<coal::Box>(2.0 * box.extent),
                                                                 Matrix3::Identity(), box.centre));
      objects_.back()->setUserData(reinterpret_cast<void*>(static_cast<std::intptr_t>(box.index)));
      raw.push_back(objects_.back().get());
    }
    tree_.registerObjects(raw);
    tree_.setup();
  }

  // Append all bodies whose box is nearer to a point than a radius.
  void near(const Vector3& centre, double radius, std::vector<int>& found) const {
    found.insert(found.end(), everywhere_.begin(), everywhere_.end());
    if (objects_.empty()) {
      for (const Box& box : boxes_) {
        if ((((box.centre - centre).cwiseAbs() - box.extent).array() <= radius).all()) found.push_back(box.index);
      }
      return;
    }
    // The tree looks only at the box around it.
    coal::CollisionObject ball(anything_, coal::Transform3s(), false);
    ball.setUserData(kBall);
    ball.getAABB() = coal::AABB(centre - Vector3::Constant(radius), centre + Vector3::Constant(radius));
    Collect collect(found);
    tree_.collide(&ball, &collect);
  }

 private:
  // So few boxes are all looked at sooner than a tree is climbed down.
  static constexpr std::size_t kFew = 128;

  // A body's axis-aligned box.
  struct Box {
    Vector3 centre, extent;
    int index;
  };

  static int index_of(const coal::CollisionObject& object) {
    return static_cast<int>(reinterpret_cast<std::intptr_t>(object.getUserData()));
  }

  struct Collect : coal::CollisionCallBackBase {
    explicit Collect(std::vector<int>& target) : found(target) {}
    bool collide(coal::CollisionObject* one, coal::CollisionObject* other) override {
      found.push_back(index_of(one->getUserData() == kBall ? *other : *one));
      return false;
    }
    std::vector<int>& found;
  };

  static inline void* const kBall = reinterpret_cast<void*>(std::intptr_t{-1});

  const std::shared_ptr<coal::CollisionGeometry> anything_ = std::make_shared<coal::Sphere>(1.0);
  std::vector<std::unique_ptr<coal::CollisionObject>> objects_;
  std::vector<Box> boxes_;
  std::vector<int> everywhere_;
  coal::DynamicAABBTreeCollisionManager tree_;
};

}  // namespace proximity
