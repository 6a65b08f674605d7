"""A motion sampled over time: nearest pairs, clearances and shares of limits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from trajopt.geometry import JointPlacements, evaluator
from trajopt.problem.requirements import AxisAlignment, Requirement
from trajopt.robot.joints import JointLimits
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import ChangingPairs
from trajopt.values.arrays import Bools, Floats
from trajopt.values.trajectory import Trajectory

REACHES = (0.03, 0.15, 0.6, np.inf)
"""Increasing search distances for the nearest pair [m]."""


class ClearanceKind(Enum):
    """Kinds of pairs of bodies."""

    SURROUNDINGS = "links to surroundings"
    SELF = "links to links"
    CARRIED = "carried objects"


@dataclass(frozen=True, eq=False)
class Nearest:
    """The pair with the smallest clearance beyond the required one, at one time.

    The error of a dynamic obstacle's track is subtracted from the distance.

    Attributes:
        distance: Signed: positive apart, negative in penetration [m].
        margin: Margin of the optimiser, at least the required clearance [m].
        points: Nearest points of the two, on their tracks, in the world, shape (2, 3) [m].
    """

    owners: tuple[str, str]
    distance: float
    required: float
    margin: float
    points: Floats
    error: float = 0.0


class ClearanceQuery:
    """Measures clearances along a motion; owns scratch memory, so one per thread."""

    def __init__(self, reduced: ReducedModel, duration: float) -> None:
        self.timed = reduced.timed
        self.reduced = reduced if self.timed is None else self.timed.reduced
        self._duration = duration
        self._changing = None if self.timed is None else ChangingPairs.of(self.timed)
        self.query = evaluator(self.reduced)

    def positions(self, times: Floats, positions: Floats) -> Floats:
        return positions if self.timed is None else self.timed.positions(positions, times)

    def nearest(self, t: float, positions: Floats) -> Nearest | None:
        return next(iter(self.nearest_pairs(t, positions, 1)), None)

    def nearest_pairs(self, t: float, positions: Floats, count: int) -> tuple[Nearest, ...]:
        """Return the pairs with the least clearance beyond the required one at a time [s], in order."""
        pairs, moment = self.reduced.pairs, np.array([t])
        checked, error = ~self.meant(moment)[0], self.error(moment)[0]
        at, nearest = self.positions(moment, positions[None]), dict[frozenset[str], Nearest]()
        for reach in REACHES:
            nearest.clear()
            found = self.query.close_pairs(at, np.where(checked, reach + pairs.required + error, -np.inf))
            distance = found.distance - error[found.pair]
            for place in np.argsort(distance - pairs.required[found.pair], kind="stable").tolist():
                pair = int(found.pair[place])
                each = Nearest(
                    self.reduced.owners(pair),
                    float(distance[place]),
                    float(pairs.required[pair]),
                    float(pairs.margin[pair]),
                    np.stack((found.point_first[place], found.point_second[place])),
                    float(error[pair]),
                )
                nearest.setdefault(frozenset(each.owners), each)
                if len(nearest) == count:
                    return tuple(nearest.values())
        return tuple(nearest.values())

    def smallest(self, times: Floats, positions: Floats, reach: float) -> Mapping[ClearanceKind, Floats]:
        """Return the smallest clearance of each kind of pair at times, (S,) [m]; inf beyond `reach`."""
        kinds = self.kinds()
        errors = self.error(times)
        found = self.query.close_pairs(self.positions(times, positions), reach + errors.max(axis=0))
        distance = found.distance - errors[found.sample, found.pair]
        counted = ~self.meant(times)[found.sample, found.pair] & (distance < reach)
        result: dict[ClearanceKind, Floats] = {}
        for kind in ClearanceKind:
            mine = np.array([other is kind for other in kinds], dtype=bool)
            if mine.any():
                chosen = counted & mine[found.pair]
                smallest = np.full(len(times), np.inf)
                np.minimum.at(smallest, found.sample[chosen], distance[chosen])
                result[kind] = smallest
        return result

    def meant(self, times: Floats) -> Bools:
        pairs = self.reduced.pairs
        result = np.zeros((len(times), len(pairs.first)), dtype=bool)
        for pair, allowance in pairs.allowances:
            result[:, pair] |= (times < allowance.first) | (times > self._duration - allowance.last)
        if self._changing is not None:
            result |= times[:, None] < self._changing.appears
            result |= times[:, None] > self._changing.expires
        return result

    def error(self, times: Floats) -> Floats:
        if self._changing is None:
            return np.zeros((len(times), len(self.reduced.pairs.first)))
        return self._changing.error_at(times[:, None], slice(None))

    def kinds(self) -> tuple[ClearanceKind, ...]:
        bodies, objects, robot = self.reduced.bodies, self.reduced.scene.objects, self._robot_joints
        result: list[ClearanceKind] = []
        for a, b in zip(self.reduced.pairs.first, self.reduced.pairs.second, strict=True):
            things = [body for body in (bodies[int(a)], bodies[int(b)]) if body.owner in objects]
            if any(0 < thing.joint < robot for thing in things):
                result.append(ClearanceKind.CARRIED)
            else:
                result.append(ClearanceKind.SURROUNDINGS if things else ClearanceKind.SELF)
        return tuple(result)

    @property
    def _robot_joints(self) -> int:
        return self.reduced.model.njoints - (0 if self.timed is None else len(self.timed.driven.names))


SAMPLES = 600
"""Number of evenly spaced times, beyond the trajectory's own points."""
CLEARANCE_SAMPLES = 201
"""Times at which clearances are measured."""
REACH = 0.3
"""Clearances beyond it are drawn at it [m]."""


@dataclass(frozen=True, eq=False)
class Tilt:
    """Angle between an axis of a frame and its direction over time, shape (S,), and its bound [rad]."""

    frame: str
    bound: float
    angles: Floats


@dataclass(frozen=True, eq=False)
class MotionSamples:
    """A motion at S times.

    Attributes:
        position_shares: -1 at the lower limit, 1 at the upper; half turns without limits, (S, n).
        velocity_shares: Velocities divided by their limits, shape (S, n), as `acceleration_shares`.
        unlimited: Names of the joints without position limits.
        clearances: Smallest clearance of each kind of pair, shape (C,) [m]; inf beyond `REACH`.
        required: The required clearances, each once, without zero [m].
        windows: Start [s], end [s] and name of the intervals with intended contact.
        tightest: Time [s], clearance [m] and names of the tightest pair; None beyond `REACH`.
    """

    joint_names: tuple[str, ...]
    times: Floats
    position_shares: Floats
    velocity_shares: Floats
    acceleration_shares: Floats
    unlimited: tuple[str, ...]
    clearance_times: Floats
    clearances: Mapping[ClearanceKind, Floats]
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
    """Sample a motion."""
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
    query: ClearanceQuery, times: Floats, clearances: Mapping[ClearanceKind, Floats], along: Floats
) -> tuple[float, float, tuple[str, str]] | None:
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
