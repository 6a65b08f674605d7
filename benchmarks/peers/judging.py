"""The same judgement for every planner: trajopt's judge, on the path and on the timed motion."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks.peers.export import Asked
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Certificate, Judge, Specification, VerifyOptions

ENDS_TOLERANCE = 2e-3
"""How far a motion may start and end from where it must, for every planner [rad]."""
LIMIT_TOLERANCE = 1e-3
"""How far a path may be beyond a position limit [rad]."""
GRAZE = 1e-3
"""Depth of contact that is nearly free [m]."""
WINDOW = 0.005
"""Time over which accelerations are averaged [s]."""
NEARLY = 0.02
"""Share by which limits may be exceeded to be nearly kept."""
SLOW = 0.1
"""Speed at which a path without time is passed to the judge [rad/s]."""
ORDERS = ("joint position", "velocity", "acceleration")


@dataclass(frozen=True)
class PathVerdict:
    """The judge's verdict on a path at each of its points.

    Attributes:
        free: Whether it is proven that nothing touches, and it joins start and goal inside the limits.
        nearly_free: The same, but what touches by less than `GRAZE` is accepted.
        clearance: Proven clearance, else the smallest measured one [m].
        length: Length in joint space [rad].
        reason: What is wrong.
    """

    free: bool
    nearly_free: bool
    clearance: float | None
    length: float
    reason: str


@dataclass(frozen=True)
class MotionVerdict:
    """The judge's verdict on a timed motion at all times.

    Attributes:
        free: As of the path, and it starts and ends at rest.
        nearly_free: The same, but what touches by less than `GRAZE` is accepted.
        within: Whether velocity, acceleration and position limits are proven, to one in a million.
        nearly_within: Whether they hold to two in a hundred, accelerations as a mean over a short time.
        clearance: Proven clearance, else the smallest measured one [m].
        duration: Duration [s].
        velocity: Largest speed of a joint, as a share of its limit.
        acceleration: Largest acceleration of a joint, as a share of its limit.
        mean_acceleration: The same of the mean over `WINDOW`, which does not see the overshoot of
            a polynomial through samples between which the acceleration jumps.
        reason: What is wrong.
    """

    free: bool
    nearly_free: bool
    within: bool
    nearly_within: bool
    clearance: float | None
    duration: float
    velocity: float
    acceleration: float
    mean_acceleration: float
    reason: str


def judge_result(asked: Asked, result: dict[str, Any]) -> dict[str, Any]:
    """Judge a planner's motion for a problem; return the numbers of one compact record."""
    options = VerifyOptions(start_error=ENDS_TOLERANCE, rest_speed=ENDS_TOLERANCE)
    judge = Judge(asked.problem.reduced, options)
    claimed = result["claimed"]
    path = _judge_path(judge, asked, np.array(result["path"])) if claimed and result["path"] else None
    motion = _judge_motion(judge, asked, result["motion"]) if claimed and result["motion"] else None
    name, number = asked.instance.name.split("/")
    return {
        "set": name,
        "index": int(number),
        "claimed": claimed,
        "message": "" if claimed else result["message"],
        "setup_cpu": result["setup_cpu"],
        "path_cpu": result["path_cpu"],
        "timing_cpu": result["timing_cpu"],
        "path": None if path is None else asdict(path),
        "motion": None if motion is None else asdict(motion),
    }


def _judge_path(judge: Judge, asked: Asked, points: np.ndarray) -> PathVerdict:
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate(([True], lengths > 0.0))]
    times = np.concatenate(([0.0], np.cumsum(lengths[lengths > 0.0]) / SLOW))
    names = asked.problem.reduced.joint_names
    certificate = judge.certify(Trajectory(names, times, points), Specification(goals=asked.problem.goals))
    wrong = _wrong_ends(asked, points)
    limits = asked.problem.limits
    if (points < limits.lower - LIMIT_TOLERANCE).any() or (points > limits.upper + LIMIT_TOLERANCE).any():
        wrong.append("beyond a position limit")
    touching = _touching(certificate)
    return PathVerdict(
        free=not wrong and not touching,
        nearly_free=not wrong and certificate.clearance > -GRAZE,
        clearance=_finite(certificate.clearance),
        length=float(lengths.sum()),
        reason="; ".join([*wrong, *touching]),
    )


def _judge_motion(judge: Judge, asked: Asked, motion: dict[str, Any]) -> MotionVerdict:
    limits = asked.problem.limits
    keys = ("times", "positions", "velocities", "accelerations")
    arrays = [None if motion[key] is None else np.array(motion[key]) for key in keys]
    trajectory = Trajectory(asked.problem.reduced.joint_names, *arrays)
    certificate = judge.certify(trajectory, Specification(goals=asked.problem.goals, limits=limits))
    wrong = _wrong_ends(asked, trajectory.positions)
    wrong += [f"{check.name}: {check.detail}" for check in certificate.failed if "at rest" in check.name]
    exceeded = [check for check in certificate.failed if check.name in ORDERS]
    velocity, acceleration = (_largest(certificate, name) for name in ORDERS[1:])
    mean = _mean_acceleration(trajectory, limits.acceleration)
    far_out = [
        check
        for check in exceeded
        if check.name == ORDERS[0] and check.slack is not None and -check.slack > LIMIT_TOLERANCE
    ]
    touching = _touching(certificate)
    return MotionVerdict(
        free=not wrong and not touching,
        nearly_free=not wrong and certificate.clearance > -GRAZE,
        within=not exceeded,
        nearly_within=not far_out and max(velocity, mean) <= 1.0 + NEARLY,
        clearance=_finite(certificate.clearance),
        duration=trajectory.duration,
        velocity=velocity,
        acceleration=acceleration,
        mean_acceleration=mean,
        reason="; ".join([*wrong, *touching, *(f"{check.name}: {check.detail}" for check in exceeded)]),
    )


def _largest(certificate: Certificate, name: str) -> float:
    """Return the largest share of a limit that is used; the judge names the tightest joint."""
    return max(
        abs(check.value / check.bound)
        for check in certificate.checks
        if check.name == name and check.value is not None and check.bound
    )


def _mean_acceleration(trajectory: Trajectory, limit: np.ndarray) -> float:
    times = np.arange(0.0, trajectory.duration, WINDOW)
    change = np.diff(trajectory(times, 1), axis=0) / WINDOW
    return float((np.abs(change) / limit).max())


def _wrong_ends(asked: Asked, points: np.ndarray) -> list[str]:
    ends = (
        ("start", points[0], asked.problem.reduced.start_positions),
        ("goal", points[-1], asked.goal),
    )
    return [f"misses the {name}" for name, at, end in ends if np.abs(at - end).max() > ENDS_TOLERANCE]


def _touching(certificate: Certificate) -> list[str]:
    return [f"clearance: {check.detail}" for check in certificate.failed if check.name == "clearance"]


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
