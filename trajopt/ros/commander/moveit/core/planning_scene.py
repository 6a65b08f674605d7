"""Stand-in for `moveit.core.planning_scene`: the objects around the robot, and collision checks."""

import logging
from typing import Any

from trajopt.files.messages import Constraints, document_of
from trajopt.files.messages import PlanningScene as PlanningSceneMessage
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.frames import reading_at
from trajopt.files.moveit.scene_messages import scene_message
from trajopt.optimise.kinematics import Validity
from trajopt.ros.commander.moveit.core.robot_model import InPart, RobotModel
from trajopt.ros.commander.moveit.core.robot_state import RobotState, judged, of_robot
from trajopt.ros.commander.planning_scene_interface import PlanningSceneInterface
from trajopt.ros.commander.world import World
from trajopt.scene.scene import Scene
from trajopt.server.move_group.outcome import MoveItCommanderException, speaks_moveit
from trajopt.values.arrays import Floats

_LOG = logging.getLogger("trajopt.ros.commander")
ALL = 0xFFFF


@speaks_moveit
class PlanningScene(InPart):
    """The scene of a world, read-only or writable, with a copy of the robot's positions at entry."""

    def __init__(self, robot_model: RobotModel, world: World | None = None, *, writable: bool = True) -> None:
        """Select a world; by default a new one with the robot alone."""
        self.name, self.robot_model, self.current_state = "", robot_model, RobotState(robot_model)
        self._world, self._writable = world or World(robot_model.robot), writable
        self.current_state.positions = self._world.positions

    @property
    def scene(self) -> Scene:
        return self._world.scene

    @property
    def planning_frame(self) -> str:
        """The root link."""
        return self.robot_model.model_frame

    @property
    def planning_scene_message(self) -> PlanningSceneMessage:
        """The whole scene, as a message."""
        return scene_message(self._world.scene, self._world.positions, ALL)

    def knows_frame_transform(self, *given: Any, frame_id: str = "") -> bool:
        """Return whether a frame, link or object exists; a preceding state argument is ignored."""
        scene, name = self._world.scene, frame_id or given[-1]
        return name in scene.frame_names or name in scene.objects

    def get_frame_transform(self, frame_id: str) -> Floats:
        """Return the placement of a frame, link or object in the root link, shape (4, 4)."""
        return self._world.scene.placement_of(frame_id, self._world.positions).homogeneous

    def apply_collision_object(self, collision_object_msg: Any, color_msg: Any = None) -> None:
        """Apply a CollisionObject: add, remove, append or move; colours are ignored."""
        self._interface().add_object(collision_object_msg)

    def process_attached_collision_object(self, object: Any) -> None:
        """Apply an AttachedCollisionObject: attach or detach."""
        self._interface().process_attached(object)

    def process_planning_scene_world(self, msg: Any) -> None:
        """Add the objects of a PlanningSceneWorld."""
        self._interface().apply_planning_scene(PlanningSceneMessage(is_diff=True, world=msg))

    def remove_all_collision_objects(self) -> None:
        """Remove all objects not attached."""
        self._interface().remove_world_object()

    def is_state_colliding(
        self, robot_state: Any = None, joint_model_group_name: str = "", verbose: bool = False
    ) -> bool:
        """Return whether the robot collides with itself or with an object.

        Args:
            joint_model_group_name: The group whose links are checked; all groups if empty.
        """
        found = self._judged(robot_state, joint_model_group_name)
        pairs = {(pair.first, pair.second) for each in found for pair in each.examination.collisions}
        if verbose and pairs:
            _LOG.info("in collision: %s", "; ".join(f"{one} and {other}" for one, other in sorted(pairs)))
        return bool(pairs)

    def is_state_valid(
        self, robot_state: Any = None, joint_model_group_name: str = "", verbose: bool = False
    ) -> bool:
        """Return whether a state is within limits and collision-free; see `is_state_colliding`."""
        found = self._judged(robot_state, joint_model_group_name)
        if verbose:
            _LOG.info("%s", "; ".join(str(each) for each in found))
        return all(each.valid for each in found)

    def is_state_constrained(
        self, state: RobotState, constraints: Constraints, verbose: bool = False
    ) -> bool:
        """Return whether a state satisfies constraints."""
        group = next(iter(self.robot_model.joint_model_group_names))
        (found,) = self._judged(state, group, constraints)
        if verbose:
            _LOG.info("%s", "; ".join(str(check) for check in found.checks))
        return all(check.holds for check in found.checks)

    def _judged(self, state: Any, group: str, constraints: Constraints | None = None) -> list[Validity]:
        if isinstance(state, str):  # MoveIt leaves the state out in front of the group
            state, group = None, state
        positions = self._world.positions if state is None else of_robot(state).positions
        scene, reading = self._world.scene, reading_at(self._world.scene, positions)
        required, scene = read_constraints(
            document_of(constraints or Constraints(), "constraints"), scene, reading
        )
        names = [self._world.group(group).name] if group else self.robot_model.joint_model_group_names
        return judged(scene, names, positions, required)

    def _interface(self) -> PlanningSceneInterface:
        if not self._writable:
            raise MoveItCommanderException(
                "the scene was entered with read_only(); read_write() may change it"
            )
        return PlanningSceneInterface(world=self._world)
