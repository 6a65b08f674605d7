"""Time-optimal path parametrisation under velocity, acceleration, jerk, torque and tool-speed limits."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from trajopt.native import timing
from trajopt.native.timing import Kind, Outcome
from trajopt.native.timing import Retimed as Found
from trajopt.robot.joints import JointLimits, LimitKind
from trajopt.values.arrays import Floats, Ints, Printed, Value
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import LONGEST, Path, Trajectory

LEAST_TOLERANCE = 1e-7
"""Smallest tolerance of rounded corners [m | rad]."""


@checked
@dataclass(frozen=True)
class RetimeOptions:
    """Options of `retime`.

    Attributes:
        path_tolerance: Largest deviation of the smooth path from the polyline, by the deviation bound [m];
            without one, by the largest joint difference [rad | m].
        points: Target number of trajectory points. Every knot of the smooth path is also a point.
        passes: Most computations of the profile, on finer grids or with tightened limits.
        remainder: Share of the duration that the final uniform stretch may add without another pass.
        shortest: Shortest duration of a trajectory, including one at rest [s].
    """

    path_tolerance: float = 5e-3
    points: int = 140
    passes: int = 8
    remainder: float = 1e-3
    shortest: float = 1e-2

    def __post_init__(self) -> None:
        ranges = (
            ("path_tolerance", self.path_tolerance, LEAST_TOLERANCE),
            ("points", self.points, 10),
            ("passes", self.passes, 1),
            ("remainder", self.remainder, 0.0),
            ("shortest", self.shortest, 1e-9),
        )
        for name, value, least in ranges:
            if not value >= least:
                raise ShapeError(name, f"must be at least {least:g}, is {value}")


@dataclass(frozen=True, eq=False)
class Retimed(Printed):
    """A trajectory along a smooth path within all limits.

    Attributes:
        trajectory: Starts and ends at rest, quintic between its points.
        deviation: Deviation of the smooth path from the polyline by the deviation bound [m]; without one, the
            largest joint difference [rad | m].
        added_duration: Duration added to hold the limits between points, relative to the first profile, which
            holds them at points only [s]; slightly negative if a finer grid saved more.
        binding: Kind of limit (velocity, acceleration, torque, jerk, tool speed) -> share of the duration
            in which it determines the speed; no single limit determines the rest.
    """

    trajectory: Trajectory
    deviation: float
    added_duration: float
    passes: int
    binding: Mapping[str, float]

    def __repr__(self) -> str:
        shares = ", ".join(f"{name} {share:.0%}" for name, share in self.binding.items())
        return f"Retimed({self.trajectory.duration:.3f} s, limited by {shares or 'none'})"


@dataclass(frozen=True)
class RetimeFailure:
    """The path has no timing within the limits.

    Attributes:
        joint: Joint whose limit cannot be held, if it is a single joint.
        place: Position on the path, as a share of its length from 0 (start) to 1 (goal).
    """

    reason: str
    joint: str | None
    place: float


SpeedOfTools: TypeAlias = Callable[[Floats, Floats], Floats]
"""Joint positions and velocities, (S, n) each -> m tool speeds, (S, m) [m/s | rad/s]."""
InverseDynamics: TypeAlias = Callable[[Floats, Floats, Floats], Floats]
"""Joint positions, velocities and accelerations, (S, n) each -> joint torques, (S, n) [Nm | N]."""
DeviationBound: TypeAlias = Callable[[Floats, Floats], Floats]
"""Positions (S, n) on the smooth path and on the polyline -> bound on the travel of any body point, (S,)
[m].
"""


@checked
@dataclass(frozen=True, eq=False)
class ToolLimits(Value):
    """Limited tool speeds.

    Attributes:
        speeds: Computes the speeds; they must scale with the joint velocities.
        limit: Largest speeds, positive, shape (m,) [m/s | rad/s].
    """

    speeds: SpeedOfTools
    limit: Floats
    names: tuple[str, ...]


DEFAULT_OPTIONS = RetimeOptions()
KINDS = ("velocity", "tool speed", "acceleration", "torque", "jerk")
"""Kinds of limits, in the order of the core's `Kind`."""


@checked
def retime(
    path: Path,
    limits: JointLimits,
    *,
    through: Sequence[int] = (),
    inverse_dynamics: InverseDynamics | None = None,
    tools: ToolLimits | None = None,
    deviation: DeviationBound | None = None,
    options: RetimeOptions = DEFAULT_OPTIONS,
) -> Retimed | RetimeFailure:
    """Smooth a path and compute the fastest trajectory along it, from rest to rest.

    Velocity, acceleration and jerk limits hold at all times (by the extremes of the polynomials); torque and
    tool-speed limits hold at the points and at dense samples between them.

    Args:
        path: Polyline; repeated knots and a path of length zero are allowed.
        limits: Joint limits; `JointLimits.scaled` makes motions slower. Jerks are limited if a joint that
            moves has a jerk limit.
        through: Indices of inner knots that the smooth path passes through: their corners are moved outwards,
            within the tolerance.
        inverse_dynamics: Joint torques at positions, velocities and accelerations; without it effort limits
            are ignored. An infinite effort limit does not count.
        deviation: Bound on the travel of any body point between a position on the smooth path and one on the
            polyline [m]; default: the largest joint difference [rad | m].
        options: Tolerance of the smooth path, number of points and passes.

    Returns:
        The trajectory, or why none exists.

    Raises:
        ShapeError: If limits and path have different joints, `through` contains no inner knot, a velocity or
            acceleration limit is not finite, a function returns a wrong shape or a number that is not finite,
            or the distances of knots overflow.
    """
    _check(path, limits, through)
    failure = endless(path.knots, limits)
    if failure is not None:
        return failure
    if float(np.abs(path.knots - path.knots[0]).max()) <= STILL:
        return Retimed(_standing(path, options.shortest), 0.0, 0.0, 0, {})
    failure = immovable(path.knots, limits)
    if failure is not None:
        return failure

    def along(knots: Floats) -> timing.Retimed:
        return timed(
            replace(path, knots=knots),
            limits,
            inverse_dynamics=inverse_dynamics,
            tools=tools,
            deviation=deviation,
            options=options,
        )

    found = timed_through(path.knots, np.array(through, dtype=np.int64), limits, along)
    failure = untimed(found, limits)
    if failure is not None:
        return failure
    trajectory = Trajectory(
        path.joint_names, found.times, found.positions, found.velocities, found.accelerations
    )
    parts = sorted(zip(KINDS, found.binding, strict=True), key=lambda item: -item[1])
    binding = {kind: part for kind, part in parts if part > 0.0}
    return Retimed(trajectory, found.deviation, found.added, found.passes, binding)


def timed(
    path: Path,
    limits: JointLimits,
    *,
    inverse_dynamics: InverseDynamics | None,
    tools: ToolLimits | None,
    deviation: DeviationBound | None,
    options: RetimeOptions,
) -> timing.Retimed:
    """Time a path that moves, by the native core; arguments as in `retime`."""
    return timing.retime(
        path.knots,
        positions=(limits.lower, limits.upper),
        limits=(limits.velocity, limits.acceleration, limits.jerk, limits.effort),
        inverse_dynamics=inverse_dynamics,
        tools=np.empty(0) if tools is None else tools.limit,
        speeds=None if tools is None else tools.speeds,
        deviation=deviation,
        tolerance=options.path_tolerance,
        points=options.points,
        passes=options.passes,
        remainder=options.remainder,
        shortest=options.shortest,
        longest=ROOM * LONGEST,
    )


def _check(path: Path, limits: JointLimits, through: Sequence[int]) -> None:
    if limits.joint_names != path.joint_names:
        raise ShapeError("limits", f"are of {limits.joint_names}, the path is of {path.joint_names}")
    for name, limit in (("velocity", limits.velocity), ("acceleration", limits.acceleration)):
        if not np.isfinite(limit).all():
            raise ShapeError(f"limits.{name}", f"must be finite, else time would vanish: {limit.tolist()}")
    inner = len(path.knots) - 2
    outside = [knot for knot in through if not 1 <= knot <= inner]
    if outside:
        raise ShapeError("through", f"must be knots between 1 and {inner}, not {outside}")


def _standing(path: Path, duration: float) -> Trajectory:
    still = np.zeros((2, len(path.joint_names)))
    return Trajectory(path.joint_names, np.array((0.0, duration)), path.knots[[0, -1]], still, still.copy())


NEAR_ENOUGH = 1e-7
"""Joint distance within which a knot is passed, below the resolution of controllers [rad | m]."""
ROUNDS = 8
"""Most rounds of moving corners, each of which leaves about a third of the error."""
DEGREE = 3
"""Degree of the smooth path."""


def timed_through(
    knots: Floats, through: Ints, limits: JointLimits, time_path: Callable[[Floats], timing.Retimed]
) -> timing.Retimed:
    """Time a polyline so that the smooth path passes through some of its knots.

    Args:
        knots: Polyline, shape (N, n) [rad | m].
        through: Indices of the knots to pass, shape (w,).
        limits: Joint limits: velocities scale the path parameter, positions bound the corners.

    Returns:
        The timing whose path comes nearest to the knots to pass, or a failed one.
    """
    corners, nearest, least = knots, time_path(knots), np.inf
    found = nearest
    for _ in range(ROUNDS if len(through) else 0):
        if found.outcome is not timing.Outcome.TIMED:
            break
        missed = knots[through] - _passed(found, corners, through, limits)
        worst = float(np.abs(missed).max())
        if worst < least:
            nearest, least = found, worst
        if worst <= NEAR_ENOUGH:
            break
        corners = corners.copy()
        corners[through] = np.clip(corners[through] + missed, limits.lower, limits.upper)
        found = time_path(corners)
    return nearest


def _passed(found: timing.Retimed, corners: Floats, through: Ints, limits: JointLimits) -> Floats:
    from scipy.interpolate import BSpline

    speed = np.where(np.isfinite(limits.velocity) & (limits.velocity > 0.0), limits.velocity, 1.0)
    steps = np.linalg.norm(np.diff(corners, axis=0) / speed, axis=1)
    parameters = np.concatenate(([0.0], np.cumsum(steps)))[through]
    ends = np.repeat(found.knots[[0, -1]], DEGREE).reshape(2, DEGREE)
    spline = BSpline(np.concatenate((ends[0], found.knots, ends[1])), found.control, DEGREE)
    relative: Floats = spline(np.clip(parameters, 0.0, found.knots[-1]))
    return corners[0] + relative


STILL = 1e-12
"""Largest joint travel of a path that counts as standing still [rad | m]."""
ROOM = 1e-3
"""Share of the longest duration that one joint's limit may need: bends and other joints slow the path
further.
"""


def immovable(knots: Floats, limits: JointLimits) -> RetimeFailure | None:
    """Find a joint that the path moves although one of its limits is zero."""
    moved = knots != knots[0]
    named = (("velocity", limits.velocity), ("acceleration", limits.acceleration), ("jerk", limits.jerk))
    for name, limit in named:
        stuck = np.nonzero(moved.any(axis=0) & (limit <= 0.0))[0]
        if len(stuck):
            joint = limits.joint_names[int(stuck[0])]
            lengths = np.linalg.norm(np.diff(knots, axis=0), axis=1)
            before = lengths[: int(moved[:, stuck[0]].argmax()) - 1]
            return RetimeFailure(
                f"the {name} limit of {joint} is {limit[stuck[0]]:g}, but the path moves it",
                joint,
                float(before.sum() / lengths.sum()),
            )
    return None


def endless(knots: Floats, limits: JointLimits) -> RetimeFailure | None:
    """Find a joint whose limits make the path longer than the longest trajectory."""
    span = np.ptp(knots, axis=0)
    named = (("velocity", limits.velocity), ("acceleration", limits.acceleration), ("jerk", limits.jerk))
    for order, (name, limit) in enumerate(named, start=1):
        allowed = np.where((span > STILL) & (limit > 0.0), limit, np.inf)
        seconds = span ** (1.0 / order) / allowed ** (1.0 / order)
        slowest = int(seconds.argmax())
        if seconds[slowest] > LONGEST * ROOM:
            joint = limits.joint_names[slowest]
            return RetimeFailure(
                f"the {name} limit of {joint} is {limit[slowest]:g}: the path would take more than "
                f"{seconds[slowest]:.2g} s, and {LONGEST * ROOM:.2g} s are the most",
                joint,
                0.0,
            )
    return None


def untimed(found: Found, limits: JointLimits) -> RetimeFailure | None:
    """Explain why the core found no timing; None if it found one."""
    match found.outcome:
        case Outcome.GRAVITY_TOO_STRONG:
            return _too_weak(found, limits)
        case Outcome.TOO_LONG:
            return RetimeFailure(
                f"within all limits together it would take {found.value:.2g} s; "
                f"{LONGEST * ROOM:.2g} s are the most",
                None,
                found.place,
            )
        case Outcome.NOTHING_FITS:
            return RetimeFailure("no speed along the path is within all limits", None, found.place)
        case Outcome.EXCEEDED:
            return _exceeded(found, limits)
        case Outcome.TIMED:
            return None


def _torque_joint(column: int, limits: JointLimits) -> int:
    return int(np.nonzero(np.isfinite(limits.effort))[0][column])


def _too_weak(found: Found, limits: JointLimits) -> RetimeFailure:
    """Name the joint that cannot hold its weight: the arm could swing past there, but not stop."""
    place = _torque_joint(found.column, limits)
    joint = limits.joint_names[place]
    return RetimeFailure(
        f"{joint} needs {found.value:.4g} only to hold still there, "
        f"its effort limit is {limits.effort[place]:.4g}",
        joint,
        found.place,
    )


def _exceeded(found: Found, limits: JointLimits) -> RetimeFailure:
    if found.kind is Kind.TOOL_SPEED:
        reason = "the speed limit of a tool is exceeded there at any speed"
        return RetimeFailure(reason, None, found.place)
    place = _torque_joint(found.column, limits) if found.kind is Kind.TORQUE else found.column
    joint = limits.joint_names[place]
    kinds = (
        (Kind.VELOCITY, LimitKind.VELOCITY),
        (Kind.ACCELERATION, LimitKind.ACCELERATION),
        (Kind.JERK, LimitKind.JERK),
    )
    limit = next((limit for kind, limit in kinds if kind is found.kind), None)
    mimic = "" if limit is None else limits.because(joint, limit)
    name = "effort" if limit is None else limit.value
    return RetimeFailure(
        f"the {name} limit of {joint}{mimic} is exceeded there at any speed", joint, found.place
    )
