"""A dynamic obstacle: a box crosses the way, and the motion keeps clear of it at every time.

The place of the box is known with an error that grows with time; the proof counts it.
"""

import numpy as np

import trajopt as to


def main():
    """Plan with the box and without it, and compare the durations."""
    panda = to.load("panda")
    still = to.Scene(panda).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    track = to.Track.through([0.0, 2.0], [to.placement((0.45, 0.5, 0.4)), to.placement((0.45, -0.5, 0.4))])
    crossing = still.add(
        "box",
        to.Box(0.2, 0.2, 0.4),
        motion=to.Prediction(track, error=(0.01, 0.02, 0.0), until=6.0),  # [m, m/s, m/s^2] and [s]
    )
    goal = to.placement((0.4, 0.3, 0.3), rpy=(np.pi, 0, 0))
    for name, scene in (("alone", still), ("with the box", crossing)):
        plan = to.plan(to.Problem(scene=scene, group="panda_arm", start="ready", goal=goal)).require()
        print(f"{name}: {plan.trajectory.duration:.2f} s")
    print(plan.certificate)


if __name__ == "__main__":
    main()
