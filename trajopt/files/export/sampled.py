"""Motions as samples: CSV, messages of ROS 2 and MoveIt, logs."""

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from trajopt.files.export.exporter import Exported
from trajopt.files.log.logs import PLAN, Log, McapLog, RerunLog
from trajopt.files.log.robot_messages import RobotMessages, motion, write_joint_states
from trajopt.files.moveit.trajectories import (
    planar_joints,
    trajectory_document,
    trajectory_message,
    write_message,
    write_trajectory,
)
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import write_text
from trajopt.values.errors import ShapeError, listed
from trajopt.values.errors.arguments import checked, checked_class
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
        motion = _at_rate(trajectory, hz)
        write_message(path, _joint_trajectory(motion))
        return Exported(path, len(motion.times), motion.duration, _notes(trajectory, motion, hz))


@dataclass(frozen=True)
class FollowJointTrajectory:
    """The goal of `control_msgs/action/FollowJointTrajectory`; the controller's own tolerances apply."""

    @checked
    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
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
class RobotTrajectoryMessage:
    """`moveit_msgs/RobotTrajectory`, for MoveIt's `execute`."""

    @checked
    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
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


TABLE_RATE = 100.0
"""Default sample rate, common for control loops in Python [1/s]."""


@dataclass(frozen=True)
class Csv:
    """One row per sample: time, then position, velocity and acceleration of each joint, in SI units."""

    @checked
    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        rate = TABLE_RATE if hz is None else hz
        samples = trajectory.sampled(rate)
        assert samples.velocities is not None and samples.accelerations is not None
        columns = [
            f"{what}_{name}"
            for what in ("position", "velocity", "acceleration")
            for name in samples.joint_names
        ]
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(["time", *columns])
        for time, *rows in zip(
            samples.times, samples.positions, samples.velocities, samples.accelerations, strict=True
        ):
            table.writerow([float(time), *(float(value) for row in rows for value in row)])
        write_text(path, text.getvalue())
        notes = (
            f"{rate:g} samples per second; the last row is the end itself, its step may be shorter",
            "time in s; positions in rad or m, with velocities and accelerations per s and s^2",
            *excess(trajectory, samples),
        )
        return Exported(path, len(samples.times), samples.duration, notes)


DERIVATIVES = ("positions", "velocities", "accelerations")
PARTS = tuple(np.linspace(0.0, 1.0 - 1e-9, 21).tolist())
"""Points between two samples for comparing derivatives, as fractions of the interval."""
NEGLIGIBLE = 0.01
"""Smallest peak of a joint, as a fraction of the largest peak of all joints; nearly motionless joints have
large ratios.
"""
LEAST = 1e-3
"""Smallest reported excess, as a fraction of the peak; the timing keeps an equal margin to the limits."""


def excess(motion: Trajectory, samples: Trajectory) -> Iterator[str]:
    """Yield a note for each derivative that is larger between the samples than in the motion."""
    for order in (1, 2):
        reached = _peaks(samples, samples.times, order)
        peak = np.maximum(_peaks(motion, samples.times, order), _peaks(motion, motion.times, order))
        parts = reached / np.maximum(peak, max(NEGLIGIBLE * peak.max(), np.finfo(np.float64).tiny)) - 1.0
        worst = int(parts.argmax())
        if parts[worst] > LEAST:
            yield (
                f"loses: between the samples, {DERIVATIVES[order]} of polynomials through them are up to "
                f"{parts[worst]:.1%} larger than in the motion ({motion.joint_names[worst]}); "
                "plan with lower scaling, or take more samples per second"
            )


def _peaks(motion: Trajectory, times: Floats, order: int) -> Floats:
    steps = np.diff(times)
    return np.max([np.abs(motion(times[:-1] + part * steps, order)).max(axis=0) for part in PARTS], axis=0)


RATE = 50.0
"""Default sample rate, as in recorded runs [1/s]."""


@checked_class
@dataclass(frozen=True)
class Mcap:
    """A log of a motion that begins at time 0: the motion, joint states, and of a plan frames and scene."""

    reduced: ReducedModel | None = None

    def with_model(self, reduced: ReducedModel) -> "Mcap":
        return self if self.reduced is not None else replace(self, reduced=reduced)

    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        log, rate = self._log(), RATE if hz is None else hz
        samples = trajectory.sampled(rate)
        log.add(PLAN, 0.0, motion(0.0, trajectory))
        notes = (f"{rate:g} samples per second, and the motion's own points in {PLAN.name}", "rad, m and s")
        assert samples.velocities is not None and samples.accelerations is not None
        states = np.stack((samples.positions, samples.velocities, samples.accelerations), axis=1)
        write_joint_states(log, samples.joint_names, samples.times, states)
        if self.reduced is None:
            notes = (*notes, "without frames and scene: those of a plan or bundle are included")
        else:
            positions = samples.ordered(self.reduced.joint_names).positions
            RobotMessages(self.reduced).write(log, samples.times, positions, samples.times)
        log.save(path)
        return Exported(path, len(samples.times), samples.duration, notes)

    def _log(self) -> Log:
        return McapLog()


class Rerun(Mcap):
    """A log of a motion for Rerun's viewer; otherwise as `Mcap`."""

    def _log(self) -> Log:
        return RerunLog()
