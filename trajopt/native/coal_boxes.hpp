// Makes Coal's boxes the same in every process.
#pragma once

#include <coal/narrowphase/support_functions.h>

namespace coal_boxes {

// Coal grows boxes by 1e-10 where a direction has a zero, to prefer a side, but keeps what it found at the first
// call of a process for all later ones (`static const inflate`, Coal 3.0.2): the last bits of every distance from a
// box depended on what had been measured first. So the first call is made here, with a direction that has zeros.
inline void settle() {
  const coal::Box box(1.0, 1.0, 1.0);
  coal::Vec3s support;
  int hint = 0;
  coal::details::ShapeSupportData data;
  coal::details::getShapeSupport<coal::details::SupportOptions::NoSweptSphere>(&box, coal::Vec3s(1.0, 0.0, 0.0), support,
                                                                               hint, data);
}

}  // namespace coal_boxes
