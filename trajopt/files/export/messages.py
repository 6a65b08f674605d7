"""Messages of ROS 2 and MoveIt, as accepted by `ros2 action send_goal` and `ros2 topic pub`."""

from dataclasses import dataclass
from pathlib import Path

from trajopt.files.export.exporter import Exported
from trajopt.files.export.sampled import excess
from trajopt.files.moveit.trajectories import (
    planar_joints,
    trajectory_document,
    trajectory_message,
    write_message,
    write_trajectory,
)
from trajopt.values.errors import ShapeError, listed
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Interpolation, Trajectory

BETWEEN = {
    Interpolation.LINEAR: "positions only: controllers go in straight lines between the points",
    Interpolation.CUBIC: "with velocities: controllers go along cubic polynomials between the points",
    Interpolation.QUINTIC: "with velocities and accelerations: controllers go along quintic polynomials",
}
AS_PLANNED = "the motion's own points: between them the controller goes along the motion itself"


@dataclass(frozen=True)
class JointTrajectory:
    """`trajectory_msgs/JointTrajectory`, for the topic of a `joint_trajectory_controller`."""

    @checked
    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        """Write a motion, by default its own points; see `Exporter.write`."""
        motion = _at_rate(trajectory, hz)
        write_message(path, _joint_trajectory(motion))
        return Exported(path, len(motion.times), motion.duration, _notes(trajectory, motion, hz))


@dataclass(frozen=True)
class FollowJointTrajectory:
    """The goal of `control_msgs/action/FollowJointTrajectory`; the controller's own tolerances apply."""

    @checked
    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        """Write a motion, by default its own points; see `Exporter.write`."""
        motion = _at_rate(trajectory, hz)
        goal: dict[str, object] = {
            "trajectory": _joint_trajectory(motion),
            "path_tolerance": list[object](),
            "goal_tolerance": list[object](),
            "goal_time_tolerance": {"sec": 0, "nanosec": 0},
        }
        write_message(path, goal)
        notes = (*_notes(trajectory, motion, hz), "no tolerances: those in the controller's parameters apply")
        return Exported(path, len(motion.times), motion.duration, notes)


@dataclass(frozen=True)
class RobotTrajectory:
    """`moveit_msgs/RobotTrajectory`, for MoveIt's `execute`."""

    @checked
    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        """Write a motion, by default its own points; see `Exporter.write`."""
        motion = _at_rate(trajectory, hz)
        write_trajectory(motion, path)
        return Exported(path, len(motion.times), motion.duration, _notes(trajectory, motion, hz))


def _at_rate(trajectory: Trajectory, hz: float | None) -> Trajectory:
    return trajectory if hz is None else trajectory.sampled(hz)


def _notes(trajectory: Trajectory, written: Trajectory, hz: float | None) -> tuple[str, ...]:
    if hz is None:
        return AS_PLANNED, BETWEEN[written.interpolation]
    where = f"{hz:g} samples per second; the last point is the end itself"
    return where, BETWEEN[written.interpolation], *excess(trajectory, written)


def _joint_trajectory(motion: Trajectory) -> dict[str, object]:
    planar = planar_joints(motion.joint_names)
    if planar:
        raise ShapeError(
            "trajectory",
            f"moves a base in the plane ({listed(planar)}), for which a JointTrajectory has no place; "
            "export it to moveit",
        )
    return trajectory_document(trajectory_message(motion).joint_trajectory)
