"""A first plan: a Panda carries a cup past a pillar, and the cup stays upright.

python examples/first_plan.py            # plan and prove
python examples/first_plan.py cup.gif    # also simulate the motion, and draw it
"""

import sys

import numpy as np

import trajopt as to


def main():
    """Plan, print the certificate, and draw the motion if a file is named."""
    panda = to.load("panda")
    scene = (
        to.Scene(panda)
        .add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("pillar", to.Cylinder(radius=0.05, length=0.8), to.placement((0.55, 0.0, 0.4)))
    )
    problem = to.Problem(
        scene=scene,
        group="panda_arm",
        start="ready",
        goal=to.placement((0.4, 0.3, 0.3), rpy=(np.pi, 0, 0)),  # of the group's tool
        constraints=[to.axis_alignment("panda_hand_tcp", direction=(0, 0, -1), tolerance=0.1)],
    )
    print(problem)
    result = to.plan(problem)
    print(result.reason)  # one sentence, also if there is no plan
    plan = result.require()
    print(plan.certificate)
    print(f"the motion takes {plan.trajectory.duration:.2f} s")
    if len(sys.argv) > 1:
        print(to.simulate(plan).summary())
        to.render(plan, sys.argv[1])


if __name__ == "__main__":
    main()
