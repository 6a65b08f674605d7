"""RobotCommander: structure and state of a robot, with MoveIt's API."""

from collections.abc import Sequence
from typing import Any

from trajopt.files import messages as msg
from trajopt.files.messages import is_message
from trajopt.files.moveit.frames import pose_of
from trajopt.files.moveit.scene_messages import state_message
from trajopt.robot.loading.urdf import MeshReference
from trajopt.ros.commander.conversions import stamped
from trajopt.ros.commander.move_group import MoveGroupCommander
from trajopt.ros.commander.robot_states import joint_names, link_names, state_positions
from trajopt.ros.commander.world import World, world_or_current
from trajopt.scene.scene import Scene
from trajopt.server.move_group.outcome import MoveItCommanderException, speaks_moveit
from trajopt.values.arrays import Floats
from trajopt.values.errors import FrameNotFound, GroupNotFound, JointNotFound, shown
from trajopt.values.shapes.shapes import Box, Cylinder, Sphere

GREY = (0.5, 0.5, 0.5, 1.0)


def markers(scene: Scene, positions: Floats, links: Sequence[str]) -> msg.MarkerArray:
    """Return a marker for every visual element of links, at positions of all joints [rad | m]."""
    robot = scene.robot
    for link in links:
        if link not in robot.links:
            raise FrameNotFound("link", link, robot.links)
    found: list[msg.Marker] = []
    for element in robot.visuals:
        if element.link not in links:
            continue
        where = scene.placement_of(element.link, positions) * element.placement
        marker = msg.Marker(
            msg.Header(frame_id=robot.links[0]), element.link, len(found), pose=pose_of(where)
        )
        marker.color = msg.ColorRGBA(*(element.colour or GREY))
        match element.geometry:
            case MeshReference(path=path, scale=scale):
                marker.type, marker.mesh_resource = msg.Marker.MESH_RESOURCE, f"file://{path}"
                marker.scale = msg.Vector3(*scale)
            case Box(x=x, y=y, z=z):
                marker.type, marker.scale = msg.Marker.CUBE, msg.Vector3(x, y, z)
            case Sphere(radius=radius):
                marker.type, marker.scale = msg.Marker.SPHERE, msg.Vector3(2 * radius, 2 * radius, 2 * radius)
            case Cylinder(radius=radius, length=length):
                marker.type, marker.scale = msg.Marker.CYLINDER, msg.Vector3(2 * radius, 2 * radius, length)
            case _:
                continue  # URDF has no other primitives.
        found.append(marker)
    return msg.MarkerArray(found)


class Joint:
    """A joint of a robot."""

    def __init__(self, robot: "RobotCommander", name: str) -> None:
        self._robot = robot
        self._name = name

    def name(self) -> str:
        return self._name

    def variable_count(self) -> int:
        """Return the number of position variables: 1, or 0 for a fixed joint."""
        return int(self._name in self._robot.world.robot.joint_names)

    def bounds(self) -> list[float]:
        """Return its lower and upper limits [rad | m]; empty for a fixed joint."""
        robot = self._robot.world.robot
        if not self.variable_count():
            return []
        place = int(robot.index([self._name])[0])
        return [float(robot.limits.lower[place]), float(robot.limits.upper[place])]

    def min_bound(self) -> float | list[float]:
        return self.bounds()[0] if self.variable_count() else []

    def max_bound(self) -> float | list[float]:
        return self.bounds()[1] if self.variable_count() else []

    def value(self) -> float | list[float]:
        """Return the current position [rad | m]; empty for a fixed joint."""
        world = self._robot.world
        return float(world.positions[world.robot.index([self._name])[0]]) if self.variable_count() else []

    def move(self, position: float, wait: bool = True) -> bool:
        """Move only this joint, by the smallest group that contains it [rad | m]."""
        owner = self._robot.get_default_owner_group(self._name)
        if owner is None:
            raise MoveItCommanderException(f"joint {shown(self._name)} is in no group and cannot be moved")
        group = self._robot.get_group(owner)
        group.set_joint_value_target(group.get_current_joint_values())
        group.set_joint_value_target(self._name, position)
        return group.go(wait=wait)


class Link:
    """A link of a robot."""

    def __init__(self, robot: "RobotCommander", name: str) -> None:
        self._robot = robot
        self._name = name

    def name(self) -> str:
        return self._name

    def pose(self) -> msg.PoseStamped:
        world = self._robot.world
        return stamped(
            world.scene.placement_of(self._name, world.positions), self._robot.get_planning_frame()
        )


def _first(args: Sequence[Any], kind: type) -> Any:
    return next((each for each in args if isinstance(each, kind)), None)


@speaks_moveit
class RobotCommander:
    """Structure and state of a robot; its groups, joints and links are also attributes."""

    group_kind: type[MoveGroupCommander] = MoveGroupCommander

    def __init__(
        self, robot_description: str = "robot_description", ns: str = "", *, world: World | None = None
    ) -> None:
        """Select a world, by default the one of the enclosing `with` block."""
        self.world = world_or_current(world)
        self._groups: dict[str, MoveGroupCommander] = {}

    def get_planning_frame(self) -> str:
        """Return the root link."""
        return self.get_root_link()

    def get_robot_markers(self, *args: Any) -> msg.MarkerArray:
        """Return markers that display the robot.

        Args:
            args: Empty for the current state; a RobotState, or joint -> position [rad | m], optionally
                followed by names of links; or the name of a group, optionally followed by joint -> position.
        """
        values, group, chosen = (_first(args, kind) for kind in (dict, str, list))
        state = next((each for each in args if is_message(each, "joint_state")), None)
        if len(args) != sum(each is not None for each in (values, state, group, chosen)):
            raise MoveItCommanderException(f"get_robot_markers: cannot make sense of {shown(args)}")
        links = self.get_link_names(group) if chosen is None else list(chosen)
        positions = state_positions(values if state is None else state, self.world)
        return markers(self.world.scene, positions, links)

    def get_root_link(self) -> str:
        """Return the name of the root link."""
        return self.world.robot.links[0]

    def get_active_joint_names(self, group: str | None = None) -> list[str]:
        """Return the names of the driven joints of a group or the robot."""
        robot = self.world.robot
        if group is not None:
            return list(self.world.group(group).joints)
        return [joint for joint in robot.joint_names if joint not in robot.mimics]

    def get_joint_names(self, group: str | None = None) -> list[str]:
        """Return the names of all joints of a group or the robot, including fixed and mimic joints."""
        robot = self.world.robot
        return joint_names(robot, None if group is None else self.world.group(group))

    def get_link_names(self, group: str | None = None) -> list[str]:
        """Return the names of the links of a group or the robot."""
        robot = self.world.robot
        return link_names(robot, None if group is None else self.world.group(group))

    def get_group_names(self) -> list[str]:
        """Return the names of the groups."""
        return list(self.world.robot.groups)

    def get_current_state(self) -> msg.RobotState:
        """Return the current joint positions and the attached objects."""
        return state_message(self.world.scene, self.world.positions)

    def get_current_variable_values(self) -> dict[str, float]:
        """Return the current joint positions, joint -> position [rad | m]."""
        return dict(zip(self.world.robot.joint_names, self.world.positions.tolist(), strict=True))

    def get_joint(self, name: str) -> Joint:
        """Return a joint."""
        if name not in self.get_joint_names():
            raise JointNotFound("joint", name, self.get_joint_names())
        return Joint(self, name)

    def get_link(self, name: str) -> Link:
        """Return a link."""
        if name not in self.get_link_names():
            raise FrameNotFound("link", name, self.get_link_names())
        return Link(self, name)

    def get_group(self, name: str) -> MoveGroupCommander:
        """Return the commander of a group: the same object on every call."""
        if name not in self._groups:
            self._groups[name] = self.group_kind(name, world=self.world)
        return self._groups[name]

    def has_group(self, name: str) -> bool:
        """Return whether the group exists; the robot's name as a prefix is optional."""
        try:
            self.world.group(name)
        except GroupNotFound:
            return False
        return True

    def get_default_owner_group(self, joint_name: str) -> str | None:
        """Return the group of fewest links with a joint; None if none has it."""
        owners = [group for group in self.get_group_names() if joint_name in self.get_joint_names(group)]
        return min(owners, key=lambda group: len(self.get_link_names(group)), default=None)

    def __getattr__(self, name: str) -> MoveGroupCommander | Joint | Link:
        if name.startswith("_") or name == "world":  # Not there before the constructor has run.
            raise AttributeError(name)
        if name in self.world.robot.groups:
            return self.get_group(name)
        if name in self.get_joint_names():
            return Joint(self, name)
        if name in self.get_link_names():
            return Link(self, name)
        raise AttributeError(f"RobotCommander has no attribute, group, joint or link {shown(name)}")
