"""Stand-in for `moveit.planning`: MoveItPy, its planning components and its planning scene."""

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from trajopt.files.messages import Constraints, MotionPlanRequest, MoveItErrorCodes
from trajopt.ros.commander.moveit.core.planning_scene import PlanningScene
from trajopt.ros.commander.moveit.core.robot_model import InPart, RobotModel
from trajopt.ros.commander.moveit.core.robot_state import RobotState, of_robot
from trajopt.ros.commander.moveit.core.robot_trajectory import RobotTrajectory
from trajopt.ros.commander.planning_scene_interface import PlanningSceneInterface
from trajopt.ros.commander.robot_states import state_positions
from trajopt.ros.commander.scripts import UnchangedMoveGroup
from trajopt.ros.commander.world import World, world_or_current
from trajopt.server.move_group.outcome import MoveItCommanderException, speaks_moveit
from trajopt.values.errors import shown

POSITION_TOLERANCE, ROTATION_TOLERANCE = 1e-3, 1e-2
"""MoveIt's tolerances of a pose goal [m, rad]."""


@dataclass(init=False)
class PlanRequestParameters(InPart):
    """Parameters of a planning request; the defaults are MoveIt's.

    Attributes:
        planning_attempts: Number of attempts; the motion of least duration is kept.
    """

    planner_id: str = ""
    planning_pipeline: str = ""
    planning_attempts: int = 1
    planning_time: float = 1.0
    max_velocity_scaling_factor: float = 1.0
    max_acceleration_scaling_factor: float = 1.0

    def __init__(self, moveit_py: Any = None, ns: str = "") -> None:
        """Set the defaults; parameters of a ROS node are not read."""


@dataclass(init=False)
class MultiPipelinePlanRequestParameters(InPart):
    """Parameters for several pipelines; only one exists here, and plans once."""

    multi_plan_request_parameters: list[PlanRequestParameters] = field(
        default_factory=list[PlanRequestParameters]
    )

    def __init__(self, moveit_py: Any, planning_pipeline_names: Sequence[str]) -> None:
        self.multi_plan_request_parameters = [
            PlanRequestParameters(moveit_py) for _ in planning_pipeline_names
        ]


@dataclass(frozen=True, eq=False)
class MotionPlanResponse(InPart):
    """Result of planning; true if a motion was found."""

    trajectory: RobotTrajectory
    planning_time: float
    error_code: MoveItErrorCodes
    start_state: RobotState
    planner_id: str

    def __bool__(self) -> bool:
        return self.error_code.val == MoveItErrorCodes.SUCCESS


@dataclass(frozen=True)
class ExecutionStatus(InPart):
    """Status of an execution, "SUCCEEDED" or "ABORTED"; true if the robot arrived, or started."""

    status: str

    def __bool__(self) -> bool:
        return self.status == "SUCCEEDED"


class _Group(UnchangedMoveGroup):
    """A group whose goal may be any one of several constraints messages."""

    goals: Sequence[Constraints] = ()

    def construct_motion_plan_request(self) -> MotionPlanRequest:
        request = super().construct_motion_plan_request()
        if self.goals:
            request.goal_constraints = list(self.goals)
        return request


@speaks_moveit
class PlanningComponent(InPart):
    """Plans motions of one group."""

    def __init__(self, joint_model_group_name: str, moveit_py_instance: "MoveItPy") -> None:
        self._moveit, self._world = moveit_py_instance, moveit_py_instance.world
        self._group = _Group(joint_model_group_name, world=self._world)
        self._group.set_goal_position_tolerance(POSITION_TOLERANCE)
        self._group.set_goal_orientation_tolerance(ROTATION_TOLERANCE)
        self._start: RobotState | None = None
        self._has_goal = False

    @property
    def planning_group_name(self) -> str:
        return self._group.get_name()

    @property
    def named_target_states(self) -> list[str]:
        return self._group.get_named_targets()

    def get_named_target_state_values(self, name: str) -> dict[str, float]:
        return self._group.get_named_target_values(name)

    def set_start_state_to_current_state(self) -> bool:
        self._start = None
        self._group.set_start_state_to_current_state()
        return True

    def set_start_state(self, configuration_name: str | None = None, robot_state: Any = None) -> bool:
        _one_of(configuration_name=configuration_name, robot_state=robot_state)
        start = self._moveit.current_state() if robot_state is None else of_robot(robot_state).__copy__()
        if configuration_name is not None:
            start.joint_positions = self.get_named_target_state_values(configuration_name)
        self._start = start
        self._group.set_start_state(start.message())
        return True

    def get_start_state(self) -> RobotState:
        return self._moveit.current_state() if self._start is None else self._start.__copy__()

    def set_goal_state(
        self,
        configuration_name: str | None = None,
        robot_state: Any = None,
        pose_stamped_msg: Any = None,
        pose_link: str | None = None,
        motion_plan_constraints: Sequence[Constraints] | None = None,
    ) -> bool:
        """Plan to one of a named state, a RobotState, a pose of a link, or alternative constraints."""
        _one_of(
            configuration_name=configuration_name,
            robot_state=robot_state,
            pose_stamped_msg=pose_stamped_msg,
            motion_plan_constraints=motion_plan_constraints,
        )
        if (pose_stamped_msg is None) != (pose_link is None):
            raise MoveItCommanderException("set_goal_state: pose_stamped_msg and pose_link belong together")
        if motion_plan_constraints is not None and len(motion_plan_constraints) == 0:
            raise MoveItCommanderException("set_goal_state: motion_plan_constraints is empty")
        self._group.clear_pose_targets()
        self._group.goals = tuple(motion_plan_constraints or ())
        if configuration_name is not None:
            self._group.set_named_target(configuration_name)
        elif robot_state is not None:
            names = self._group.get_active_joints()
            values = of_robot(robot_state).joint_positions
            self._group.set_joint_value_target({name: values[name] for name in names})
        elif pose_stamped_msg is not None:
            self._group.set_pose_target(pose_stamped_msg, pose_link or "")
        self._has_goal = True
        return True

    def set_path_constraints(self, path_constraints: Constraints) -> bool:
        self._group.set_path_constraints(path_constraints)
        return True

    def set_workspace(
        self, min_x: float, min_y: float, min_z: float, max_x: float, max_y: float, max_z: float
    ) -> None:
        self._group.set_workspace([min_x, min_y, min_z, max_x, max_y, max_z])

    def unset_workspace(self) -> None:
        self._group.set_workspace([])

    def plan(
        self,
        single_plan_parameters: PlanRequestParameters | None = None,
        multi_plan_parameters: MultiPipelinePlanRequestParameters | None = None,
        *,
        parameters: PlanRequestParameters | None = None,
    ) -> MotionPlanResponse:
        """Plan a motion and verify it.

        Args:
            multi_plan_parameters: Parameters for several pipelines; only the first are used.
            parameters: Another name of `single_plan_parameters`.
        """
        if not self._has_goal:
            raise MoveItCommanderException("plan: no goal is set: call set_goal_state")
        chosen = single_plan_parameters or parameters or PlanRequestParameters()
        if multi_plan_parameters is not None:
            chosen = multi_plan_parameters.multi_plan_request_parameters[0]
        group = self._group
        group.set_planning_pipeline_id(chosen.planning_pipeline)
        group.set_planner_id(chosen.planner_id)
        group.set_num_planning_attempts(chosen.planning_attempts)
        group.set_planning_time(chosen.planning_time)
        group.set_max_velocity_scaling_factor(chosen.max_velocity_scaling_factor)
        group.set_max_acceleration_scaling_factor(chosen.max_acceleration_scaling_factor)
        _, message, seconds, code = group.plan()
        start, model = self.get_start_state(), self._moveit.get_robot_model()
        trajectory = RobotTrajectory(model)
        trajectory.joint_model_group_name = group.get_name()
        trajectory.set_robot_trajectory_msg(start, message)
        return MotionPlanResponse(trajectory, seconds, code, start, group.get_planner_id())


@speaks_moveit
class PlanningSceneMonitor(InPart):
    """Gives a script read and write access to a world's scene."""

    def __init__(self, robot_model: RobotModel, world: World) -> None:
        self._model, self._world = robot_model, world

    @property
    def name(self) -> str:
        return "planning_scene_monitor"

    @contextmanager
    def read_only(self) -> Generator[PlanningScene]:
        yield PlanningScene(self._model, self._world, writable=False)

    @contextmanager
    def read_write(self) -> Generator[PlanningScene]:
        """Open the scene for changes; the next plan uses each change."""
        yield PlanningScene(self._model, self._world, writable=True)

    def process_collision_object(self, collision_object_msg: Any, color_msg: Any = None) -> bool:
        with self.read_write() as scene:
            scene.apply_collision_object(collision_object_msg)
        return True

    def process_attached_collision_object(self, attached_collision_object_msg: Any) -> bool:
        with self.read_write() as scene:
            scene.process_attached_collision_object(attached_collision_object_msg)
        return True

    def new_planning_scene_message(self, scene: Any) -> bool:
        """Replace the scene by a message, or change it if the message is a difference."""
        return PlanningSceneInterface(world=self._world).apply_planning_scene(scene)

    def wait_for_current_robot_state(self, *_: object) -> bool:
        """Return immediately; the state is always known."""
        return True


@speaks_moveit
class MoveItPy(InPart):
    """The robot of a world, its groups and its scene."""

    def __init__(
        self,
        node_name: str = "moveit_py",
        name_space: str = "",
        launch_params_filepaths: Sequence[str] = (),
        config_dict: Any = None,
        provide_planning_service: bool = True,
        remappings: Any = None,
        *,
        world: World | None = None,
    ) -> None:
        """Select a world, by default the one of the `with` block; of the rest only `node_name` counts."""
        self.world = world_or_current(world)
        self.world.node.name = node_name
        self._model = RobotModel.of(self.world.robot, self.world.rng)

    def get_planning_component(self, planning_component_name: str) -> PlanningComponent:
        return PlanningComponent(planning_component_name, self)

    def get_planning_scene_monitor(self) -> PlanningSceneMonitor:
        return PlanningSceneMonitor(self._model, self.world)

    def get_robot_model(self) -> RobotModel:
        return self._model

    def current_state(self) -> RobotState:
        state = RobotState(self._model)
        state.positions = state_positions(None, self.world)
        return state

    def execute(
        self,
        *given: Any,
        robot_trajectory: RobotTrajectory | None = None,
        group_name: str = "",
        blocking: bool = True,
        controllers: Sequence[str] = (),
    ) -> ExecutionStatus:
        """Execute a motion.

        Args:
            given: The motion; in some versions of MoveIt the name of the group precedes it.
        """
        motions = [each for each in (*given, robot_trajectory) if isinstance(each, RobotTrajectory)]
        if len(motions) != 1:
            raise MoveItCommanderException(f"execute: give one RobotTrajectory, not {shown(given)}")
        blocking = next((each for each in given if isinstance(each, bool)), blocking)
        group = UnchangedMoveGroup(motions[0].joint_model_group_name or group_name, world=self.world)
        done = group.execute(motions[0].get_robot_trajectory_msg(), wait=blocking)
        return ExecutionStatus("SUCCEEDED" if done else "ABORTED")

    def shutdown(self) -> None:
        self.world.node.end()


def _one_of(**given: object) -> None:
    stated = [name for name, value in given.items() if value is not None]
    if len(stated) != 1:
        raise MoveItCommanderException(
            f"give one of {', '.join(given)}" + (f", not {' and '.join(stated)}" if stated else "")
        )
