"""A line and an arc: the tool follows a curve to 0.1 mm and 0.1 degrees, proven at every instant."""

import trajopt as to
from trajopt.tasks.cartesian import FollowOptions, arc_through, follow, follows_curve, line

TOOL = "panda_hand_tcp"


def main():
    """Follow a line to the side and then an arc, with the tool at 0.1 m/s at most."""
    panda = to.load("panda")
    scene = to.Scene(panda).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    here = scene.placement_of(TOOL, "ready")
    corner = here * to.placement((0.0, 0.15, 0.0))  # in the axes of the tool
    end = corner * to.placement((0.15, 0.15, 0.0))
    over = (corner * to.placement((0.11, 0.04, 0.0))).translation
    curve = line(here, corner) + arc_through(corner, over, end)
    print(f"the curve is {curve.length:.3f} m long")
    followed = follow(
        scene,
        follows_curve(TOOL, curve),
        group="panda_arm",
        start="ready",
        options=FollowOptions(tool_speed=(to.tool_speed(TOOL, linear=0.1),)),
    )
    print(followed.explain())  # the pair, limit or jump that ends it, if it is not followed to its end
    plan = followed.require()
    print(f"{plan.trajectory.duration:.2f} s, {1e3 * followed.deviation:.3f} mm from the curve at most")


if __name__ == "__main__":
    main()
