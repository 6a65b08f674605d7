"""The arms that problems are posed to: where their tool is, and a configuration to begin at."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

import trajopt as to


@dataclass(frozen=True, eq=False)
class Arm:
    """An arm and the names that a problem needs of it.

    Attributes:
        robot: The robot.
        group: Its planning group.
        tip: Tool frame; its z axis points out of the tool.
        hand: Links that may touch what the tool holds.
        ready: Configuration with the tool pointing down before the base, joint -> position [rad].
        width: Width of what is at the tool, along its y axis [m].
        reach: Distance from the base at which it works with ease [m].
    """

    robot: to.Robot
    group: str
    tip: str
    hand: tuple[str, ...]
    ready: Mapping[str, float]
    width: float
    reach: float

    def tip_at(self, point: np.ndarray, tolerance: float) -> to.Requirement:
        """Require the tool's origin at a point of the world, turned as it likes.

        Args:
            point: Shape (3,) [m].
            tolerance: Along each axis [m].
        """
        return to.frame_placement(
            self.tip, to.placement(point), position_tolerance=tolerance, rotation_tolerance=np.inf
        )

    def at(self, scene: to.Scene, *goals: to.Requirement) -> Mapping[str, float]:
        """Return a configuration that holds goals and is clear of a scene, joint -> position [rad].

        Raises:
            TrajoptError: If none was found.
        """
        problem = to.Problem(scene=scene, group=self.group, start=self.ready, goal=goals)
        found = to.goal_configurations(problem)
        if not found:
            raise to.TrajoptError(f"{self.robot.name} finds no configuration at {goals}")
        return {**self.ready, **dict(zip(problem.reduced.joint_names, found[0].tolist(), strict=True))}


@cache
def panda() -> Arm:
    """Return the Panda with its hand: seven joints."""
    robot = to.load("panda")
    return Arm(
        robot,
        "panda_arm",
        "panda_hand_tcp",
        ("panda_hand", "panda_leftfinger", "panda_rightfinger"),
        {**robot.state("ready"), "panda_finger_joint1": 0.02, "panda_finger_joint2": 0.02},
        width=0.21,
        reach=0.55,
    )


@cache
def ur5() -> Arm:
    """Return the UR5 without a gripper: six joints."""
    joints = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    ready = (-0.245, -1.67, 1.875, -1.776, -1.571, -1.816)
    return Arm(
        to.load("ur5"),
        "manipulator",
        "tool0",
        ("wrist_3_link", "tool0", "ee_link"),
        {f"{joint}_joint": value for joint, value in zip(joints, ready, strict=True)},
        width=0.08,
        reach=0.6,
    )


@cache
def xarm7() -> Arm:
    """Return the xArm7 without a gripper: seven joints."""
    ready = (0.0, -0.2, 0.0, 0.806, 0.0, 1.007, 0.0)
    return Arm(
        to.load("xarm7"),
        "xarm7",
        "link_eef",
        ("link_eef", "link7"),
        {f"joint{count}": value for count, value in enumerate(ready, start=1)},
        width=0.08,
        reach=0.5,
    )


@cache
def two_pandas() -> Arm:
    """Return two Pandas as one arm of fourteen joints; its tool is that of the left one."""
    robot = to.load("two_pandas")
    fingers = {f"{side}_panda_finger_joint{count}": 0.02 for side in ("left", "right") for count in (1, 2)}
    return Arm(
        robot,
        "both",
        "left_panda_hand_tcp",
        tuple(f"{side}_{link}" for side in ("left", "right") for link in panda().hand),
        {**robot.state("ready", group="both"), **fingers},
        width=0.21,
        reach=0.55,
    )


def pointing(
    arm: Arm,
    point: tuple[float, float, float],
    direction: tuple[float, float, float],
    *,
    position_tolerance: float = 2e-3,
    cone: float = 0.1,
    frame: str = "",
) -> tuple[to.Requirement, to.Requirement]:
    """Require the tool at a point, pointing along a direction within a cone, free to spin.

    Args:
        arm: The arm.
        point: Of the tool, in the world [m].
        direction: Of the tool's z axis, in the world.
        position_tolerance: Per axis of the world [m].
        cone: Largest angle between the two [rad].
        frame: What is at the point in place of the tool frame.
    """
    held = frame or arm.tip
    return (
        to.frame_placement(
            held, to.placement(point), position_tolerance=position_tolerance, rotation_tolerance=np.inf
        ),
        to.axis_alignment(held, direction=direction, tolerance=cone),
    )


ROD = 0.2
"""Length of the rod that an arm without a gripper holds [m]."""


def with_rod(arm: Arm, scene: to.Scene) -> to.Scene:
    """Return the scene with a rod in the arm's flange, as "rod", and its end as the frame "rod_tip"."""
    return scene.add(
        "rod",
        to.Cylinder(0.02, ROD),
        to.placement((0.0, 0.0, ROD / 2 + 0.001)),
        frame=arm.tip,
        touch_links=arm.hand,
    ).add("rod_tip", [], to.placement((0.0, 0.0, ROD)), frame=arm.tip)
