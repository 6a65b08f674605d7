"""Robots on wheels drive up to a table and reach for what stands on it, base and arm planned together."""

from collections.abc import Mapping
from functools import cache, partial
from pathlib import Path

import numpy as np
from trajopt_robots._example_robot_data import share_folder

import trajopt as to

from .drawing import drawn, near

_TIAGO_SRDF = Path(__file__).parent / "tiago.srdf"
HALL = ((-1.0, -3.0), (5.0, 3.0))
"""Where the bases may be: least and largest x and y [m]."""
ROBOTS = "example-robot-data/robots"


def past_column_pr2(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for the PR2, whose wheels are steered: it drives in every direction.

    What is hard: the goal is three metres away, a column stands in the straight way, and where the base
    has to stand for the arm to reach over the table is not said. Ten joints move at once, in metres and
    radians.

    Args:
        rng: Draws column, table and goal; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, _pr2(), "right_arm", "r_gripper_tool_frame", PR2_READY), rng)


def past_column_tiago(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem for Tiago, which drives on two wheels and cannot move sideways.

    What is hard: as for the PR2, and its wheels must roll all the way: what it lacks to the side it has to
    steer. Eleven joints.

    Args:
        rng: As for the PR2; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(partial(_problem, _tiago(), "whole_body", "arm_tool_link", TIAGO_READY), rng)


PR2_READY: Mapping[str, float] = {
    "torso_lift_joint": 0.1,
    "l_shoulder_pan_joint": 1.5,
    "l_shoulder_lift_joint": 1.0,
    "l_elbow_flex_joint": -2.0,
    "l_wrist_flex_joint": -0.5,
    "r_shoulder_pan_joint": -1.2,
    "r_shoulder_lift_joint": 0.6,
    "r_upper_arm_roll_joint": -1.0,
    "r_elbow_flex_joint": -1.8,
    "r_wrist_flex_joint": -0.6,
}
"""The left arm out of the way, the right one drawn in."""
TIAGO_READY: Mapping[str, float] = {
    "torso_lift_joint": 0.15,
    "arm_1_joint": 0.2,
    "arm_2_joint": -1.34,
    "arm_3_joint": -0.2,
    "arm_4_joint": 1.94,
    "arm_5_joint": -1.57,
    "arm_6_joint": 1.37,
}
"""The arm folded before the chest."""


@cache
def _pr2() -> to.Robot:
    folder = share_folder() / ROBOTS / "pr2_description"
    base = to.bases.planar_base(*HALL, velocity=(0.8, 1.0), acceleration=(0.8, 1.5), groups=("right_arm",))
    # Springs carry the weight of its arms; the URDF knows the motors only, which could not.
    return to.load(
        folder / "urdf/pr2.urdf",
        srdf=folder / "srdf/pr2.srdf",
        package_dirs=(share_folder(),),
        base=base,
        torque_scaling=np.inf,
    )


@cache
def _tiago() -> to.Robot:
    return to.load(
        share_folder() / ROBOTS / "tiago_description/robots/tiago_no_hand.urdf",
        srdf=_TIAGO_SRDF,
        package_dirs=(share_folder(),),
        base=to.bases.planar_base(
            *HALL, velocity=(0.8, 1.2), acceleration=(0.8, 1.5), drive=to.bases.Drive.DIFFERENTIAL
        ),
    )


def _problem(
    robot: to.Robot, group: str, tip: str, ready: Mapping[str, float], rng: np.random.Generator | None
) -> to.Problem:
    column = to.placement((near(rng, 1.5, 0.15), near(rng, 0.05, 0.2), 1.0))
    edge, side = near(rng, 3.1, 0.2), near(rng, 0.3, 0.4)
    scene = (
        to.Scene(robot)
        .add("column", to.Cylinder(0.25, 2.0), column)
        .add("table", to.Box(0.6, 1.2, 0.7), to.placement((edge + 0.3, side, 0.35)))
    )
    there = (edge + 0.1, side + near(rng, 0.0, 0.3), near(rng, 0.85, 0.05))
    goal = to.frame_placement(tip, to.placement(there), position_tolerance=5e-3, rotation_tolerance=0.1)
    return to.Problem(scene=scene, group=group, start=ready, goal=goal, name="past column")
