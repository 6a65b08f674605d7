"""Following a moving frame: the joint motion that stays with it, and one from rest that joins it.

A motion y that ends at rest, at the frame's place of a time T, is made into one that meets the frame then.
The added part is the joint travel that follows the frame from the configuration at T: q*(t) - q*(T). That is
exact in the last part, so that the robot moves relative to the frame as y does, which was planned with a
frame at rest. Before, the added part grows from zero, by a quintic. So the sum begins as y does, and at T it
has the frame's velocity and acceleration, and none relative to the frame.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np

from trajopt.geometry import evaluator
from trajopt.optimise.kinematics.forward import moving_frame, stacked_jacobian
from trajopt.problem.requirements import FramePlacement
from trajopt.robot.limits import JointLimits
from trajopt.scene.reduced import TimedModel
from trajopt.values.arrays import Floats
from trajopt.values.placement import as_rotation_vector
from trajopt.values.trajectory import Trajectory

STEP = 0.02
"""Time between two following configurations [s]: the error of the spline between them is fractions of a
micrometre at 1 m/s, far below the tolerances of placements.
"""
ITERATIONS, EXACT = 12, 1e-10
"""Largest number of Newton steps, and their required precision [m | rad]: each squares the error, so few
suffice.
"""
DAMPING = 1e-9
"""Keeps the steps finite at singular configurations, where following then fails."""
SETTLING = 1e-3
"""A motion may end with an acceleration: it is taken back in this time, without progress [s]."""
WITHIN = 0.998
"""Share of the limits that samples may reach, because of the values between them."""
LOOKS = 12
"""Samples in each piece at which limits are checked."""


@dataclass(eq=False)
class FollowingFrame:
    """Makes joint motions that follow a moving goal; one for each thread.

    Attributes:
        timed: The model among dynamic obstacles.
        goals: The placements to follow, relative to a moving frame.
    """

    timed: TimedModel
    goals: tuple[FramePlacement, ...]

    def __post_init__(self) -> None:
        """Make the query."""
        self._query = evaluator(self.timed.reduced)

    def positions(self, at_meeting: Floats, meeting: float, times: Floats) -> Floats | None:
        """Return configurations that keep all placements as they are at the meeting, or None if some do not.

        Coordinates that a placement leaves free are kept as well, if possible.

        Args:
            at_meeting: The group's positions at the meeting, shape (n,) [rad | m].
            meeting: Time of the meeting [s].
            times: Times to follow at, shape (s,) [s].

        Returns:
            Shape (s, n).
        """
        wanted = [self._relative(goal, at_meeting[None], np.array((meeting,)))[:2] for goal in self.goals]
        for free in (False, True):
            found = self._kept(wanted, np.tile(at_meeting, (len(times), 1)), times, free=free)
            if found is not None:
                return found
        return None

    def _kept(
        self, wanted: list[tuple[Floats, Floats]], found: Floats, times: Floats, *, free: bool
    ) -> Floats | None:
        """Return configurations at times that keep placements, by Newton's method; None if it fails."""
        for _ in range(ITERATIONS):
            errors, slopes = self._linearised(wanted, found, times, free=free)
            if np.abs(errors).max() <= EXACT:
                return found
            transposed = np.swapaxes(slopes, 1, 2)
            gram = slopes @ transposed + DAMPING * np.eye(slopes.shape[1])
            found = found - (transposed @ np.linalg.solve(gram, errors[:, :, None]))[:, :, 0]
        return None

    def _relative(
        self, goal: FramePlacement, positions: Floats, times: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Return rotations, points and Jacobians of a frame as seen from its reference."""
        joints = positions.shape[1]
        every = self.timed.positions(positions, times)
        at = moving_frame(self._query, goal.frame, every, goal.reference, goal.offset)
        return at.rotation, at.point, stacked_jacobian(at)[:, :, :joints]

    def _linearised(
        self, wanted: list[tuple[Floats, Floats]], positions: Floats, times: Floats, *, free: bool
    ) -> tuple[Floats, Floats]:
        """Return the errors of placements, (s, r), and their derivatives by the joints, (s, r, n)."""
        errors: list[Floats] = []
        slopes: list[Floats] = []
        for goal, (rotation, point) in zip(self.goals, wanted, strict=True):
            rotations, points, jacobian = self._relative(goal, positions, times)
            # Along the axes of the goal's placement, in which its tolerances are stated.
            inward = goal.placement.rotation.T
            off = (points - point[0]) @ inward.T
            turns = np.array([as_rotation_vector(each @ rotation[0].T) for each in rotations]) @ inward.T
            tolerances = np.concatenate((goal.position_tolerance, goal.rotation_tolerance))
            kept = np.isfinite(tolerances) if free else np.ones(6, dtype=np.bool_)
            errors.append(np.concatenate((off, turns), axis=1)[:, kept])
            slopes.append(
                np.concatenate((inward @ jacobian[:, :3], inward @ jacobian[:, 3:]), axis=1)[:, kept]
            )
        return np.concatenate(errors, axis=1), np.concatenate(slopes, axis=1)


@dataclass(frozen=True, eq=False)
class FollowingMotion:
    """The joint motion that follows a goal, around the time at which it is met.

    Attributes:
        times: Shape (s,), increasing [s].
        rows: Positions, velocities and accelerations at these times, of a cubic spline, shape (3, s, n).
        meeting: Time of the meeting, one of the times [s].
    """

    times: Floats
    rows: Floats
    meeting: float

    @staticmethod
    def of(
        frame: FollowingFrame, at_meeting: Floats, meeting: float, begin: float, end: float
    ) -> "FollowingMotion | None":
        """Return the motion from one time to another; None if no configuration follows.

        Args:
            frame: The frame to follow.
            at_meeting: The group's positions at the meeting, shape (n,) [rad | m].
            meeting: Time of the meeting [s].
            begin: First time [s].
            end: Last time, the meeting or later [s].
        """
        before = np.linspace(begin, meeting, 1 + max(3, ceil((meeting - begin) / STEP)))
        after = np.linspace(meeting, end, 1 + ceil((end - meeting) / STEP))[1:]
        times = np.concatenate((before, after))
        found = frame.positions(at_meeting, meeting, times)
        if found is None:
            return None
        return FollowingMotion(times, _spline(times, found), meeting)

    def joined(self, still: Trajectory, slower: float) -> Trajectory:
        """Return a motion that meets the goal and stays with it; see the module.

        Its own time starts at 0 when it begins to move.

        Args:
            still: Ends at rest, at the configuration of the meeting.
            slower: Factor on its duration.
        """
        settling = SETTLING if still.accelerations is not None and still.accelerations[-1].any() else 0.0
        over = still.duration * slower
        duration = over + settling
        mine = self.times - self.meeting + duration
        knots = np.concatenate((still.times * slower, (duration,), mine))
        knots = np.unique(knots[knots >= 0.0])
        knots = knots[np.append(True, np.diff(knots) > _NEAR)]
        lent = np.flatnonzero(knots < mine[0])
        rows = [still(knots / slower, order) / slower**order for order in range(3)]
        for row in rows[1:]:
            row[knots > over] = 0.0
        begins = float(mine[0])
        place = self.rows[0, int(np.searchsorted(self.times, self.meeting - _NEAR))]
        added = [self._at(order, knots - duration + self.meeting) for order in range(3)]
        added[0] = added[0] - place
        first = np.stack([self.rows[0, 0] - place, self.rows[1, 0], self.rows[2, 0]])
        for order, values in enumerate(_grown(first, begins, knots[lent])):
            added[order][lent] = values
        return Trajectory(still.joint_names, knots, *(a + b for a, b in zip(rows, added, strict=True)))

    def _at(self, order: int, times: Floats) -> Floats:
        """Return positions or a derivative at times, which are clipped to its own; (s, n)."""
        place = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2)
        h = np.diff(self.times)[place][:, None]
        z = np.clip(times - self.times[place], 0.0, h[:, 0])[:, None]
        q, v, a = (self.rows[index][place] for index in range(3))
        jerk = (self.rows[2][place + 1] - a) / h
        series = ((q, v, a / 2.0, jerk / 6.0), (v, a, jerk / 2.0), (a, jerk))[order]
        value = series[-1]
        for coefficient in series[-2::-1]:
            value = value * z + coefficient
        return value


def _spline(times: Floats, values: Floats) -> Floats:
    """Return values, first and second derivatives of a cubic spline through points, (s, n) -> (3, s, n).

    Its third derivative is continuous at the second and the last but one (not-a-knot), so that the ends need
    no assumption. (SciPy's takes a second to import.)

    Args:
        times: Shape (s,), four or more.
        values: Shape (s, n).
    """
    h, count = np.diff(times), len(times)
    slope = np.diff(values, axis=0) / h[:, None]
    system, right = np.zeros((count, count)), np.zeros_like(values)
    inner = np.arange(1, count - 1)
    system[inner, inner - 1], system[inner, inner + 1] = h[:-1], h[1:]
    system[inner, inner] = 2.0 * (h[:-1] + h[1:])
    right[inner] = 6.0 * np.diff(slope, axis=0)
    system[0, :3] = -h[1], h[0] + h[1], -h[0]
    system[-1, -3:] = -h[-1], h[-2] + h[-1], -h[-2]
    bends: Floats = np.asarray(np.linalg.solve(system, right), dtype=np.float64)
    begins = slope - h[:, None] * (2.0 * bends[:-1] + bends[1:]) / 6.0
    end = slope[-1:] + h[-1] * (bends[-2:-1] + 2.0 * bends[-1:]) / 6.0
    return np.stack((values, np.concatenate((begins, end)), bends))


_NEAR = 1e-6
"""Times nearer than this count as equal [s]."""


def _grown(end: Floats, duration: float, times: Floats) -> list[Floats]:
    """Return positions, velocities and accelerations of quintics that grow from nothing, (s, n) each.

    Args:
        end: Position, velocity and acceleration at the end, shape (3, n).
        duration: When that is [s].
        times: Shape (s,) [s].
    """
    q, v, a = end[0], end[1] * duration, end[2] * duration**2
    third, fourth, fifth = 10 * q - 4 * v + a / 2, -15 * q + 7 * v - a, 6 * q - 3 * v + a / 2
    z = (times / duration)[:, None]
    return [
        z**3 * (third + z * (fourth + z * fifth)),
        z**2 * (3 * third + z * (4 * fourth + z * 5 * fifth)) / duration,
        z * (6 * third + z * (12 * fourth + z * 20 * fifth)) / duration**2,
    ]


def seems_possible(motion: Trajectory, limits: JointLimits) -> bool:
    """Return whether a motion holds the joints' limits at samples."""
    begins, lengths = motion.times[:-1], np.diff(motion.times)
    times = (begins[:, None] + lengths[:, None] * np.linspace(0.0, 1.0, LOOKS)[None, :]).ravel()
    positions = motion(times)
    if (positions < limits.lower).any() or (positions > limits.upper).any():
        return False
    bounds = (limits.velocity, limits.acceleration, limits.jerk)
    return all(
        bool((np.abs(motion(times, order)) <= WITHIN * bound).all())
        for order, bound in enumerate(bounds, start=1)
    )
