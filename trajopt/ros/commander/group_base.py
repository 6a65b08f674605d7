"""What every part of a group's commander shares: its world, its joints, its end effector, its frame."""

from collections.abc import Mapping

from trajopt.files.moveit.frames import world_names
from trajopt.planning.result import Result
from trajopt.ros.commander.moveit_msgs.msg import Constraints, RobotState, TrajectoryConstraints
from trajopt.ros.commander.targets import PoseTarget, Targets
from trajopt.ros.commander.world import World, world_or_current
from trajopt.scene.group_tools import end_link
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.server.move_group.settings import Settings
from trajopt.tasks.cartesian import Followed
from trajopt.tasks.grasping import PickPlaceResult
from trajopt.values.arrays import Floats
from trajopt.values.errors import FrameNotFound, shown
from trajopt.values.placement import WORLD, Placement


class GroupBase:
    """A group of joints of a world's robot, and what a script has set about it."""

    def __init__(
        self,
        name: str,
        robot_description: str = "robot_description",
        ns: str = "",
        wait_for_servers: float = 5.0,
        *,
        world: World | None = None,
    ) -> None:
        """Choose a group.

        Args:
            name: Name of the group.
            robot_description: As in MoveIt; the world has the robot.
            ns: As in MoveIt; there are no namespaces.
            wait_for_servers: As in MoveIt; there is no server to wait for.
            world: The world; the one of the block around when None.

        Raises:
            MoveItCommanderException: If there is no such group, or no world.
        """
        self._world = world_or_current(world)
        self._group = self._world.group(name)
        self._tip = end_link(self._world.robot, self._group.name)
        self._reference = self._planning_frame
        self._settings = Settings()
        self._targets = Targets(self._current())
        self._start = RobotState(is_diff=True)
        self._path_constraints: Constraints = Constraints()
        self._trajectory_constraints: TrajectoryConstraints = TrajectoryConstraints()
        self._known_constraints: Mapping[str, Constraints] = {}
        self._remembered: dict[str, list[float]] = {}
        self._result: Result | None = None
        self._followed: Followed | None = None
        self._pick_place: PickPlaceResult | None = None

    @property
    def _planning_frame(self) -> str:
        return self._world.robot.links[0]

    def _current(self) -> dict[str, float]:
        """Return where the group's joints are now, joint -> position [rad | m]."""
        here = self._world.positions[self._world.robot.index(self._group.joints)]
        return dict(zip(self._group.joints, here.tolist(), strict=True))

    def _link(self, name: str) -> str:
        """Return the link that a script means: the end effector where it names none.

        Raises:
            MoveItCommanderException: If the group has no end effector.
            FrameNotFound: If there is no such link, tool frame or attached object.
        """
        scene = self._world.scene
        link = name or self._tip
        if not link:
            raise MoveItCommanderException(
                f"group {shown(self._group.name)} is not a chain and has no end effector; "
                "set_end_effector_link says which"
            )
        known = (*scene.frame_names, *(key for key in scene.objects if scene.holder(key).link != WORLD))
        if link not in known:
            raise FrameNotFound("link", link, known)
        return link

    def _frame(self, name: str) -> str:
        """Return a frame's name in the scene.

        Raises:
            FrameNotFound: If it is none.
        """
        scene = self._world.scene
        if name in world_names(scene.robot):
            return WORLD
        scene.holder(name)
        return name

    def _placed(self, target: PoseTarget, positions: Floats) -> Placement:
        """Return where a target is in the world while the robot stands at positions."""
        return self._world.scene.placement_of(self._frame(target.frame), positions) * target.placement
