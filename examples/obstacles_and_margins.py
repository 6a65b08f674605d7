"""Obstacles, a margin that is kept if possible, and a clearance that is proven.

A clearance holds at every instant; if it cannot, there is no plan, but a reason. A margin is a wish.
"""

import numpy as np

import trajopt as to


def cell(panda):
    """Return a robot between two walls, in front of a pillar."""
    return (
        to.Scene(panda)
        .add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("left", to.Box(0.5, 0.04, 0.6), to.placement((0.6, 0.45, 0.3)))
        .add("right", to.Box(0.5, 0.04, 0.6), to.placement((0.6, -0.45, 0.3)))
        .add("pillar", to.Cylinder(radius=0.04, length=0.5), to.placement((0.5, 0.0, 0.25)))
    )


def main():
    """Plan from one side of the pillar to the other, with more and more distance."""
    scene = cell(to.load("panda"))
    for name, world in {
        "nothing is required": scene.with_margin(world=0.0),
        "a margin of 30 mm": scene.with_margin(world=0.03),
        "a clearance of 30 mm": scene.with_clearance(world=0.03),
        "a clearance of 300 mm": scene.with_clearance(world=0.3),
    }.items():
        problem = to.Problem(
            scene=world,
            group="panda_arm",
            start="ready",
            waypoints={"this side": to.placement((0.5, -0.2, 0.25), rpy=(np.pi, 0, 0))},
            goal=to.placement((0.5, 0.2, 0.25), rpy=(np.pi, 0, 0)),
        )
        result = to.plan(problem)
        print(f"{name}: {result.reason}")
        for pair in result.certificate.pairs[:1] if result.verified else ():
            print(f"   {pair}")


if __name__ == "__main__":
    main()
