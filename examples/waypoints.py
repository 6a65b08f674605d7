"""Waypoints: the tool passes four corners without a stop, and points down between the first and the last."""

import numpy as np

import trajopt as to

DOWN = (np.pi, 0.0, 0.0)
"""Orientation of the tool: its z axis points down [rad]."""


def main():
    """Plan through the corners of a rectangle, and report the lowest speed between them."""
    panda = to.load("panda")
    scene = to.Scene(panda).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    corners = {
        "near left": to.placement((0.4, 0.2, 0.3), rpy=DOWN),
        "far left": to.placement((0.6, 0.2, 0.3), rpy=DOWN),
        "far right": to.placement((0.6, -0.2, 0.3), rpy=DOWN),
        "near right": to.placement((0.4, -0.2, 0.3), rpy=DOWN),
    }
    upright = to.axis_alignment("panda_hand_tcp", direction=(0, 0, -1), tolerance=0.05)
    problem = to.Problem(
        scene=scene,
        group="panda_arm",
        start="ready",
        goal="ready",
        waypoints=corners,
        constraints=[to.during(upright, after="near left", until="near right")],
    )
    plan = to.plan(problem).require()
    print(plan.certificate)
    motion = plan.trajectory
    inner = np.linspace(0.05, 0.95, 1000) * motion.duration  # at both ends it stands
    slowest = np.abs(motion(inner, 1)).max(axis=1).min()
    print(f"{motion.duration:.2f} s; on the way the fastest joint has at least {slowest:.2f} rad/s")


if __name__ == "__main__":
    main()
