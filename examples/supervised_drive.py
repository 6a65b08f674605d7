"""A supervisor drives a simulated robot, and replans when an obstacle appears on the way.

In each cycle the next piece of the motion is proven together with a stop after it, so the robot can stop at
all times. For a real arm, give the supervisor a driver in place of `SimulatedExecutor` (docs/drivers.md).
"""

import numpy as np

import trajopt as to
from trajopt.driving import SimulatedExecutor, Supervisor

CYCLE = 0.02
"""Time from one cycle to the next [s]."""


def main():
    """Drive to a goal; after 0.2 s a crate stands on the way."""
    panda = to.load("panda")
    scene = to.Scene(panda).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    goal = to.placement((0.45, 0.35, 0.3), rpy=(np.pi, 0, 0))
    problem = to.Problem(scene=scene, group="panda_arm", start="ready", goal=goal)
    crate = scene.add("crate", to.Box(0.1, 0.1, 0.3), to.placement((0.45, 0.15, 0.4)))

    arm = SimulatedExecutor(scene, problem.start_positions)
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    while supervisor.busy:
        if arm.now() > 0.2 and supervisor.scene is not crate:
            arm.change(crate, begin=arm.now())  # the world changes ...
            supervisor.see(crate)  # ... and the camera sees it
        supervisor.cycle()
        arm.advance(CYCLE)  # of a real arm: sleep until the next cycle
    for event in supervisor.events:
        print(event)
    print(f"{len(arm.contacts_at_fault)} contacts at fault")


if __name__ == "__main__":
    main()
