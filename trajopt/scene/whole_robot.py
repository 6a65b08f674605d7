"""The reduced model of any joints of a robot, regardless of its groups."""

from dataclasses import replace

from trajopt.robot.loading.groups import Group
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import ModelError, shown

WHOLE = "all that is simulated"
"""Name of the temporary group."""


def driven_joints(robot: Robot) -> tuple[str, ...]:
    """Return the joints with motors: all that do not mimic another."""
    return tuple(name for name in robot.joint_names if name not in robot.mimics)


def whole_robot(scene: Scene, joints: tuple[str, ...], start: Floats) -> ReducedModel:
    """Return the reduced model of any joints of a robot.

    Args:
        scene: Robot and scene.
        joints: Free joints.
        start: Positions of all joints [rad | m].

    Raises:
        ModelError: If the robot has a group with the name of the temporary one.
    """
    robot = scene.robot
    if WHOLE in robot.groups:
        raise ModelError(f"robot {shown(robot.name)} has a group {shown(WHOLE)}, a reserved name; rename it")
    group = Group(WHOLE, joints, robot.links, None)
    wider = replace(robot, groups={**robot.groups, WHOLE: group})
    return reduce_model(replace(scene, robot=wider), WHOLE, start)
