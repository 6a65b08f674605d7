"""A motion sampled over time, as shares of its limits: the data of the plots."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.geometry import JointPlacements
from trajopt.problem.requirements import AxisAlignment, Requirement
from trajopt.robot.limits import JointLimits
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory
from trajopt.viewer.clearance import ClearanceQuery, PairKind

SAMPLES = 600
"""Number of evenly spaced times, in addition to the trajectory's own points."""
CLEARANCE_SAMPLES = 201
"""Times at which clearances are measured."""
REACH = 0.3
"""Clearances beyond it are drawn at it [m]."""


@dataclass(frozen=True, eq=False)
class Tilt:
    """Angle between an axis of a frame and its direction over time.

    Attributes:
        frame: The frame.
        bound: Largest angle allowed [rad].
        angles: Shape (S,) [rad].
    """

    frame: str
    bound: float
    angles: Floats


@dataclass(frozen=True, eq=False)
class MotionSamples:
    """A motion at S times.

    Attributes:
        joint_names: Names of the n joints.
        times: Shape (S,) [s].
        position_shares: -1 at the lower limit, 1 at the upper; half turns without limits, (S, n).
        velocity_shares: Velocities divided by their limits, shape (S, n).
        acceleration_shares: Accelerations divided by their limits, shape (S, n).
        unlimited: Names of the joints without position limits.
        clearance_times: Times at which clearances were measured, shape (C,) [s].
        clearances: Smallest clearance of each kind of pair, shape (C,) [m]; inf beyond `REACH`.
        required: The required clearances, each once, without zero [m].
        margins: The margins of the optimiser, each once [m].
        windows: Start [s], end [s] and name of the intervals with intended contact.
        tightest: Time [s], clearance [m] and names of the tightest pair; None beyond `REACH`.
        tilts: One for each axis alignment.
    """

    joint_names: tuple[str, ...]
    times: Floats
    position_shares: Floats
    velocity_shares: Floats
    acceleration_shares: Floats
    unlimited: tuple[str, ...]
    clearance_times: Floats
    clearances: Mapping[PairKind, Floats]
    required: tuple[float, ...]
    margins: tuple[float, ...]
    windows: tuple[tuple[float, float, str], ...]
    tightest: tuple[float, float, tuple[str, str]] | None
    tilts: tuple[Tilt, ...]


def sample_motion(
    reduced: ReducedModel,
    trajectory: Trajectory,
    limits: JointLimits,
    constraints: Sequence[Requirement],
) -> MotionSamples:
    """Sample a motion.

    Args:
        reduced: The robot and its surroundings.
        trajectory: The motion of the group's joints.
        limits: Limits of the group's joints.
        constraints: Path constraints.
    """
    duration = trajectory.duration
    times = np.union1d(np.linspace(0.0, duration, SAMPLES), trajectory.times)
    query = ClearanceQuery(reduced, duration)
    pairs = query.reduced.pairs
    coarse = np.linspace(0.0, duration, CLEARANCE_SAMPLES)
    along = trajectory(coarse)
    clearances = query.smallest(coarse, along, REACH)
    bounded = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    lower = np.where(bounded, limits.lower, -np.pi)
    upper = np.where(bounded, limits.upper, np.pi)
    alignments = [item for item in constraints if isinstance(item, AxisAlignment)]
    fine = query.query.kinematics(query.positions(times, trajectory(times)))
    return MotionSamples(
        joint_names=trajectory.joint_names,
        times=times,
        position_shares=(2.0 * trajectory(times) - lower - upper) / (upper - lower),
        velocity_shares=trajectory(times, 1) / limits.velocity,
        acceleration_shares=trajectory(times, 2) / limits.acceleration,
        unlimited=tuple(np.array(limits.joint_names)[~bounded].tolist()),
        clearance_times=coarse,
        clearances=clearances,
        required=tuple(np.unique(pairs.required[pairs.required > 0.0]).tolist()),
        margins=tuple(np.unique(pairs.margin).tolist()),
        windows=_windows(reduced, duration),
        tightest=_tightest(query, coarse, clearances, along),
        tilts=tuple(_tilt(query.reduced, fine, alignment) for alignment in alignments),
    )


def _windows(reduced: ReducedModel, duration: float) -> tuple[tuple[float, float, str], ...]:
    windows: list[tuple[float, float, str]] = []
    for allowance in reduced.scene.allowances:
        if allowance.first > 0.0:
            windows.append((0.0, min(allowance.first, duration), allowance.name))
        if allowance.last > 0.0:
            windows.append((max(duration - allowance.last, 0.0), duration, allowance.name))
    return tuple(windows)


def _tightest(
    query: ClearanceQuery, times: Floats, clearances: Mapping[PairKind, Floats], along: Floats
) -> tuple[float, float, tuple[str, str]] | None:
    """Return time, clearance and names of the tightest pair of all samples."""
    overall = np.min([*clearances.values(), np.full(len(times), np.inf)], axis=0)
    sample = int(overall.argmin())
    nearest = query.nearest(float(times[sample]), along[sample])
    if nearest is None or not np.isfinite(overall[sample]):
        return None
    return float(times[sample]), nearest.distance, nearest.owners


def _tilt(reduced: ReducedModel, kinematics: JointPlacements, alignment: AxisAlignment) -> Tilt:
    joint, where = reduced.attachment(alignment.frame)
    base, reference = reduced.attachment(alignment.reference)
    axis = kinematics.rotation[:, joint] @ (where.rotation @ alignment.axis)
    direction = kinematics.rotation[:, base] @ (reference.rotation @ alignment.direction)
    sine = np.linalg.norm(np.cross(axis, direction), axis=1)
    cosine = np.einsum("si,si->s", axis, direction)
    return Tilt(alignment.frame, alignment.tolerance, np.arctan2(sine, cosine))
