"""Stub of the native core `timing`; the same in plain Python is in tests/oracles."""

from collections.abc import Callable, Sequence
from enum import Enum

from trajopt.values.arrays import Floats, Ints

class Outcome(Enum):
    """What came of timing a path, or why nothing did."""

    TIMED = 0
    GRAVITY_TOO_STRONG = 1
    TOO_LONG = 2
    NOTHING_FITS = 3
    EXCEEDED = 4

class Kind(Enum):
    """Kinds of limits."""

    VELOCITY = 0
    TOOL_SPEED = 1
    ACCELERATION = 2
    TORQUE = 3
    JERK = 4

class Retimed:
    """What came of retiming a path.

    Attributes:
        outcome: Whether it is timed.
        kind: If not, kind of the limit that cannot be held, where it is one.
        column: Place of that limit among those of its kind; of torques, among the joints with a limit.
        place: Where it cannot be, as a part of the path from 0 to 1.
        value: The torque [Nm | N], or the duration [s], that it takes.
        times: Of the points of the trajectory, shape (k,) [s].
        positions: Shape (k, n) [rad | m].
        velocities: Shape (k, n).
        accelerations: Shape (k, n).
        parameters: The path parameter of each point, shape (k,).
        added: What keeping the limits between the points has cost, against the first profile [s].
        passes: How many times the profile was computed.
        binding: For which part of the duration each kind of limit decides, in the order of `Kind`.
        knots: Of the smooth path, a cubic B-spline over its parameter, shape (p,).
        control: Its control points, relative to the start, shape (p + 2, n).
        deviation: How far it leaves the polyline, by the measure of the bound.
    """

    outcome: Outcome
    kind: Kind
    column: int
    place: float
    value: float
    times: Floats
    positions: Floats
    velocities: Floats
    accelerations: Floats
    parameters: Floats
    added: float
    passes: int
    binding: list[float]
    knots: Floats
    control: Floats
    deviation: float

def retime(
    knots: Floats,
    *,
    positions: tuple[Floats, Floats],
    limits: tuple[Floats, Floats, Floats, Floats],
    inverse_dynamics: Callable[[Floats, Floats, Floats], Floats] | None,
    tools: Floats,
    speeds: Callable[[Floats, Floats], Floats] | None,
    deviation: Callable[[Floats, Floats], Floats] | None,
    tolerance: float,
    points: int,
    passes: int,
    remainder: float,
    shortest: float,
    longest: float,
) -> Retimed:
    """Make a polyline smooth and find the fastest trajectory along it, from rest to rest.

    Args:
        knots: Of the polyline, which moves a joint, shape (N, n) [rad | m].
        positions: Lower and upper limits, shape (n,) each.
        limits: Of velocity, acceleration, jerk and effort, shape (n,) each; infinite where there is none.
        inverse_dynamics: Torques of the joints; without it effort limits are not used.
        tools: Limited speeds of tools, shape (l,).
        speeds: Speeds of those tools.
        deviation: How far bodies move between two positions; without it, the largest joint difference.
        tolerance: How far the smooth path may leave the polyline.
        points: Points of the trajectory to aim at.
        passes: Most times that the profile is computed.
        remainder: Part of the duration that the final uniform stretch may add without another pass.
        shortest: Least duration [s].
        longest: Most that the path may take [s].

    Raises:
        ShapeError: If a function returns an array of another shape, or a number that is not finite, or the
            distances of knots overflow.
        ValueError: If the shapes of the limits do not match.
    """

def fastest(distance: Floats, a: Floats, b: Floats, c: Floats, limit: Floats, bound: Floats) -> Floats:
    """Find the pointwise largest control values of a profile from rest to rest.

    Args:
        distance: Between the stations beside each of k grid points, shape (k,).
        a: Factors of the path acceleration in the limited quantities, shape (k, m).
        b: Factors of the squared path speed, shape (k, m).
        c: What remains of them at rest, shape (k, m).
        limit: Their limits, shape (k, m).
        bound: Bound at the stations, shape (k + 1,).

    Returns:
        Control values of x = (ds/dt)² at the stations, shape (k + 1,); 0 at both ends.

    Raises:
        ValueError: If the shapes do not match.
    """

def minimise(
    weight: Floats,
    bound: Floats,
    rows: Floats,
    above: Floats,
    below: Floats,
    jerk: Floats,
    speed: Floats,
    z: Floats,
    first_gap: float,
    gap: float,
) -> tuple[Floats, int]:
    """Find control values of nearly the least duration; the program is that of `jerk_program.hpp`.

    Args:
        weight: Of 1 / sqrt(z) in the duration, shape (k + 2,).
        bound: What z must stay below, shape (k + 2,).
        rows: Factors of the limited values in k blocks, shape (k, m + r, 3).
        above: Upper limits of the first m, shape (k, m).
        below: Limits of their negatives, shape (k, m).
        jerk: Limits of the others times sqrt(y), shape (k, r); the first half at the starts.
        speed: Factors of y at the starts and the ends, shape (k, 2, 3).
        z: Where to start, positive; scaled to be within the limits, shape (k + 2,).
        first_gap: Part of the duration that the first barrier leaves open.
        gap: Part of it that the last barrier does.

    Returns:
        The control values, shape (k + 2,), and how many Newton steps were taken.

    Raises:
        ValueError: If the shapes do not match.
    """

def motion_extremes(coefficients: Floats, widths: Floats) -> tuple[Floats, Floats, Floats]:
    """Find the extremes of the velocity and acceleration of quintic pieces.

    Args:
        coefficients: Of the time in each piece, highest power first, shape (6, k, n).
        widths: How long each piece takes, shape (k,) [s].

    Returns:
        Largest absolute velocities, least and largest accelerations, shape (k, n) each.

    Raises:
        ValueError: If the shapes do not match.
    """

def stop_from(begin: Floats, limits: Floats, tick: float, excess: float) -> tuple[Floats, Floats]:
    """Bring joints to rest as soon as their limits allow.

    Args:
        begin: Positions, velocities and accelerations, shape (3, n).
        limits: Least and largest positions, and largest velocities, accelerations and jerks, shape (5, n).
        tick: Pieces take multiples of this [s].
        excess: Relative excess of a limit that is accepted.

    Returns:
        Times, shape (k,), and positions, velocities and accelerations, shape (3, k, n).

    Raises:
        ValueError: If the shapes do not match, or what has to be finite is not.
    """

def track(
    begin: Floats,
    times: Floats,
    due: Ints,
    targets: Floats,
    counted: int,
    weights: Floats,
    limits: Floats,
) -> tuple[Floats, Floats, int]:
    """Return the motion of jerks that are constant between times, and which stays near targets.

    Args and Returns are those of `trajopt.timing.time_scaling.tracking`.

    Raises:
        ValueError: If the shapes do not match, times do not increase, or what has to be finite is not.
    """

class Stops:
    """Stops of a motion along its own path, each tabulated when it is first asked for."""

    def __init__(
        self,
        times: Floats,
        coefficients: Floats,
        acceleration: Floats,
        jerk: Floats,
        shares: Sequence[float],
        every: Sequence[int],
        ramp: float,
        kept: float,
        step: float,
        moment: float,
        excess: float,
    ) -> None:
        """Take the motion.

        Args:
            times: Of the motion's points, shape (k + 1,) [s].
            coefficients: Of the time in each piece, highest power first, shape (6, k, n).
            acceleration: Limits, shape (n,).
            jerk: Limits, shape (n,); infinite where there is none.
            shares: Of the limits to brake with, tried one after the other.
            every: Each so many steps are a point of the stop, tried one after the other.
            ramp: As of `brake` [s].
            kept: As of `brake`.
            step: As of `brake` [s].
            moment: Time between the moments at which braking may begin [s].
            excess: Relative excess of a limit that is accepted.

        Raises:
            ValueError: If the shapes do not match.
        """

    def earliest(self, time: float, after: float) -> tuple[Floats, Floats, Floats, Floats, float] | None:
        """Return the motion from a time on that is at rest first, None where that is its own end.

        Args:
            time: On the motion [s].
            after: Until then it goes on as it was [s].

        Returns:
            Times, shape (k,), positions, velocities and accelerations, each of shape (k, n), and until when
            it goes on as it was [s].
        """

def brake(
    times: Floats,
    coefficients: Floats,
    acceleration: Floats,
    jerk: Floats,
    ramp: float,
    begin: float,
    share: float,
    kept: float,
    step: float,
) -> tuple[Floats, float]:
    """Find the soonest stop of a motion along its own path.

    Args:
        times: Of the motion's points, shape (k + 1,) [s].
        coefficients: Of the time in each piece, highest power first, shape (6, k, n).
        acceleration: Limits, shape (n,).
        jerk: Limits, shape (n,); infinite where there is none.
        ramp: Least time in which braking takes an acceleration from nothing to its limit [s].
        begin: When braking begins [s].
        share: Share of the acceleration limits that is used, and of the jerks where the brake is let go.
        kept: Share of the jerk limits that is used otherwise.
        step: Time step [s].

    Returns:
        The motion's clock, its rate and the slope of that at the begin and after each step, shape (3, c), and
        how long a last step is, in which the slope falls to nothing; infinite if there is no such stop.

    Raises:
        ValueError: If the shapes do not match.
    """
