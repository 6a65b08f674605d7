"""Two arms: a goal that places one tool relative to the other, and a motion of both arms together."""

import numpy as np

import trajopt as to

LEFT, RIGHT = "left_panda_hand_tcp", "right_panda_hand_tcp"


def main():
    """Plan both arms together."""
    arms = to.load("two_pandas")
    print(list(arms.groups))
    facing = to.frame_placement(
        RIGHT, to.placement((0, 0, 0.2), rpy=(np.pi, 0, 0)), reference=LEFT, position_tolerance=2e-3
    )
    problem = to.Problem(scene=to.Scene(arms), group="both", start="ready", goal=facing)
    plan = to.plan(problem).require()
    print(plan.certificate)
    print(f"the arms meet after {plan.trajectory.duration:.2f} s")


if __name__ == "__main__":
    main()
