"""Stand-in for `moveit.core.robot_model`: a robot and its groups."""

from collections.abc import Sequence

import numpy as np

from trajopt.robot.load import load
from trajopt.robot.loading.groups import Group
from trajopt.robot.robot import Robot
from trajopt.ros.commander.robot_states import joint_names, link_names
from trajopt.ros.commander.world import group_named
from trajopt.scene.scene import Scene
from trajopt.server.move_group.outcome import NoStandIn, speaks_moveit
from trajopt.values.arrays import floats
from trajopt.values.errors import GroupNotFound


class InPart:
    """A partial stand-in for a class of moveit_py; its other members raise."""

    def __getattr__(self, name: str) -> object:
        """Refuse a member without a stand-in, except special names of Python."""
        if name.startswith("_"):
            raise AttributeError(name)
        there = sorted(each for each in dir(type(self)) if not each.startswith("_"))
        raise NoStandIn(f"{type(self).__name__}.{name} has no stand-in; there are: {', '.join(there)}")


@speaks_moveit
class JointModelGroup(InPart):
    """A group of joints."""

    def __init__(self, robot: Robot, group: Group) -> None:
        self._robot, self._group = robot, group

    @property
    def name(self) -> str:
        return self._group.name

    @property
    def joint_model_names(self) -> list[str]:
        return joint_names(self._robot, self._group)

    @property
    def active_joint_model_names(self) -> list[str]:
        return list(self._group.joints)

    @property
    def link_model_names(self) -> list[str]:
        return link_names(self._robot, self._group)

    @property
    def eef_name(self) -> str:
        """Name of the end effector that this group forms; empty if none."""
        effectors = self._robot.end_effectors.items()
        return next((name for name, each in effectors if each.group == self._group.name), "")

    def satisfies_position_bounds(self, values: Sequence[float], margin: float = 0.0) -> bool:
        """Return whether positions of the active joints are within their limits [rad | m]."""
        given = floats("values", values, (len(self._group.joints),))
        limits, columns = self._robot.limits, self._robot.index(self._group.joints)
        lower, upper = limits.lower[columns] - margin, limits.upper[columns] + margin
        return bool(((lower <= given) & (given <= upper)).all())


@speaks_moveit
class RobotModel(InPart):
    """A robot."""

    def __init__(self, urdf_xml_path: str, srdf_xml_path: str) -> None:
        self._take(load(urdf_xml_path, srdf=srdf_xml_path), np.random.default_rng(0))

    @classmethod
    def of(cls, robot: Robot, rng: np.random.Generator) -> "RobotModel":
        model = cls.__new__(cls)
        model._take(robot, rng)
        return model

    def _take(self, robot: Robot, rng: np.random.Generator) -> None:
        self.robot, self.rng, self.scene = robot, rng, Scene(robot)

    @property
    def name(self) -> str:
        return self.robot.name

    @property
    def model_frame(self) -> str:
        return self.robot.links[0]

    @property
    def joint_model_group_names(self) -> list[str]:
        return list(self.robot.groups)

    @property
    def joint_model_groups(self) -> list[JointModelGroup]:
        return [JointModelGroup(self.robot, group) for group in self.robot.groups.values()]

    @property
    def end_effectors(self) -> list[JointModelGroup]:
        return [self.get_joint_model_group(each.group) for each in self.robot.end_effectors.values()]

    def has_joint_model_group(self, joint_model_group_name: str) -> bool:
        """Return whether the group exists; the robot's name as a prefix is optional."""
        try:
            group_named(self.robot, joint_model_group_name)
        except GroupNotFound:
            return False
        return True

    def get_joint_model_group(self, joint_model_group_name: str) -> JointModelGroup:
        return JointModelGroup(self.robot, group_named(self.robot, joint_model_group_name))

    def get_model_info(self) -> str:
        return repr(self.robot)
