"""What a script sets about planning: tolerances, time, planner, speed."""

from collections.abc import Sequence
from dataclasses import replace

from trajopt.problem.tool_speed import tool_speed
from trajopt.ros.commander.group_base import GroupBase
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.server.move_group.settings import PIPELINE, PLANNERS, one_or_three, per_axis, scaling
from trajopt.values.arrays import floats, number
from trajopt.values.errors import SolverNotFound


class GroupSettings(GroupBase):
    """What a script sets about planning."""

    def get_goal_tolerance(self) -> tuple[float, float | list[float], float | list[float]]:
        """Return the tolerances of joints [rad | m], positions [m] and orientations [rad]."""
        position, orientation = self.get_goal_position_tolerance(), self.get_goal_orientation_tolerance()
        return self.get_goal_joint_tolerance(), position, orientation

    def get_goal_joint_tolerance(self) -> float:
        """Return how far a joint may be from its goal [rad | m]."""
        return self._settings.joint_tolerance

    def get_goal_position_tolerance(self) -> float | list[float]:
        """Return how far the end effector may be from its goal along each axis of it [m]."""
        return one_or_three(self._settings.position_tolerance)

    def get_goal_orientation_tolerance(self) -> float | list[float]:
        """Return how far the end effector may be turned from its goal about each axis of it [rad]."""
        return one_or_three(self._settings.orientation_tolerance)

    def set_goal_tolerance(self, value: float) -> None:
        """Set the tolerances of joints, positions and orientations to one number [rad | m]."""
        self.set_goal_joint_tolerance(value)
        self.set_goal_position_tolerance(value)
        self.set_goal_orientation_tolerance(value)

    def set_goal_joint_tolerance(self, value: float) -> None:
        """Set how far a joint may be from its goal [rad | m]."""
        tolerance = per_axis("goal joint tolerance", [value] * 3)[0]
        self._settings = replace(self._settings, joint_tolerance=tolerance)

    def set_goal_position_tolerance(self, value: float | Sequence[float]) -> None:
        """Set how far the end effector may be off along the axes of its goal: one number or three [m].

        Infinity leaves an axis free.
        """
        tolerance = per_axis("goal position tolerance", value)
        self._settings = replace(self._settings, position_tolerance=tolerance)

    def set_goal_orientation_tolerance(self, value: float | Sequence[float]) -> None:
        """Set how far the end effector may be turned about the axes of its goal: one or three [rad].

        Pi or more leaves an axis free.
        """
        tolerance = per_axis("goal orientation tolerance", value)
        self._settings = replace(self._settings, orientation_tolerance=tolerance)

    def allow_looking(self, value: bool) -> None:
        """Take note: there is nothing to look around with, the scene is what the script says."""

    def allow_replanning(self, value: bool) -> None:
        """Choose whether `go` plans once more where the scene was changed while it planned."""
        self._settings = replace(self._settings, replanning=bool(value))

    def set_planning_time(self, seconds: float) -> None:
        """Set the time to plan for [s]."""
        if not number("planning time", seconds) > 0.0:
            raise MoveItCommanderException(f"planning time must be positive, is {seconds:g} s")
        self._settings = replace(self._settings, planning_time=float(seconds))

    def get_planning_time(self) -> float:
        """Return the time to plan for [s]."""
        return self._settings.planning_time

    def set_planning_pipeline_id(self, planning_pipeline: str) -> None:
        """Choose the pipeline: there is one, "trajopt"."""
        if planning_pipeline not in ("", PIPELINE):
            raise SolverNotFound("planning pipeline", planning_pipeline, (PIPELINE,))

    def get_planning_pipeline_id(self) -> str:
        """Return the name of the pipeline."""
        return PIPELINE

    def set_planner_id(self, planner_id: str) -> None:
        """Choose a method of planning, by a name of `get_interface_description`; the usual one if empty."""
        if planner_id not in ("", *PLANNERS):
            raise SolverNotFound("planner", planner_id, PLANNERS)
        self._settings = replace(self._settings, planner=planner_id or PLANNERS[0])

    def get_planner_id(self) -> str:
        """Return the name of the method of planning."""
        return self._settings.planner

    def set_num_planning_attempts(self, num_planning_attempts: int) -> None:
        """Set how often to plan; of several motions the one of least duration is taken."""
        if num_planning_attempts < 1:
            raise MoveItCommanderException(f"there must be one attempt at least, not {num_planning_attempts}")
        self._settings = replace(self._settings, attempts=int(num_planning_attempts))

    def set_workspace(self, ws: Sequence[float]) -> None:
        """Set the box in which a mobile base may be; it holds no arm back, as in MoveIt.

        Args:
            ws: Nothing, [min x, min y, max x, max y] or [min x, min y, min z, max x, max y, max z] [m].

        Raises:
            MoveItCommanderException: If it is of another length.
        """
        if len(ws) not in (0, 4, 6):
            raise MoveItCommanderException(f"a workspace has 0, 4 or 6 numbers, not {len(ws)}")
        values = floats("workspace", ws, (len(ws),)).tolist() or [0.0] * 6
        if len(values) == 4:
            values = [*values[:2], 0.0, *values[2:], 0.0]
        self._settings = replace(self._settings, workspace=tuple(values))

    def set_max_velocity_scaling_factor(self, value: float) -> None:
        """Set the factor on all velocity limits, in (0, 1]; it is 0.1 until then."""
        self._settings = replace(self._settings, velocity_scaling=scaling("velocity scaling", value))

    def set_max_acceleration_scaling_factor(self, value: float) -> None:
        """Set the factor on all acceleration limits, in (0, 1]; it is 0.1 until then."""
        factor = scaling("acceleration scaling", value)
        self._settings = replace(self._settings, acceleration_scaling=factor)

    def limit_max_cartesian_link_speed(self, speed: float, link_name: str = "") -> None:
        """Set the largest speed of a link, the end effector if there is none named [m/s]."""
        limited = tool_speed(self._link(link_name), linear=speed)
        self._settings = replace(self._settings, tool_speed=limited)

    def clear_max_cartesian_link_speed(self) -> None:
        """Lift the limit on the speed of a link."""
        self._settings = replace(self._settings, tool_speed=None)

    def set_support_surface_name(self, value: str) -> None:
        """Name the object that `place` puts objects down on; empty for none."""
        if value:
            self._world.scene.object(value)
        self._settings = replace(self._settings, support_surface=value)
