"""Committed motion: the motions to which a robot is bound."""

from dataclasses import dataclass
from functools import cached_property
from itertools import zip_longest
from math import inf

import numpy as np

from trajopt.timing.time_scaling import JOLT, after_standing, begun_later
from trajopt.values.arrays import Floats, floats, number
from trajopt.values.errors import JointNotFound
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import MEETING, Trajectory, state_of

REST = 1e-6
"""A joint this slow is at rest, for the judge too [rad/s | m/s]."""
SETTLED = 1e-2
"""Largest measured speed of a joint at rest; sensors have noise [rad/s | m/s]."""
INSTANT = 1e-9
"""Times closer than this are equal [s]."""
REMEMBERED = 0.25
"""Time for which an ended motion is kept [s]: measured states arrive late."""
ORDERS = ("position", "velocity", "acceleration")


@dataclass(frozen=True, eq=False)
class _Piece:
    """A motion of some joints, and when it begins; the other joints are at rest."""

    begin: float
    trajectory: Trajectory
    joint_names: tuple[str, ...]
    standing: Floats

    @property
    def end(self) -> float:
        return self.begin + self.trajectory.duration

    @cached_property
    def columns(self) -> list[int]:
        return [self.joint_names.index(name) for name in self.trajectory.joint_names]

    def state(self, time: float) -> Floats:
        since = time - self.begin
        rows = state_of(self.trajectory, since)
        if self.trajectory.joint_names != self.joint_names:
            rows, moving = np.zeros((3, len(self.joint_names))), rows
            rows[0] = self.standing
            rows[:, self.columns] = moving
        if since >= self.trajectory.duration:
            rows[1:] = 0.0
        return rows

    @cached_property
    def whole(self) -> Trajectory:
        motion, count = self.trajectory, len(self.joint_names)
        if motion.joint_names == self.joint_names:
            return motion
        positions = np.tile(self.standing, (len(motion.times), 1))
        positions[:, self.columns] = motion.positions
        rates = [np.zeros((len(motion.times), count)) for _ in _rates(motion)]
        for whole, part in zip(rates, _rates(motion), strict=True):
            whole[:, self.columns] = part
        return Trajectory(self.joint_names, motion.times, positions, *rates)

    def of(self, joint_names: tuple[str, ...]) -> Trajectory:
        own = self.trajectory
        return own if own.joint_names == joint_names else of_joints(self.whole, joint_names)


class CommittedMotion:
    """The motions to which a robot is bound, and rest after the last.

    A splice replaces them in one step, so other threads may read meanwhile.

    Attributes:
        joint_names: The n joints of the robot.
    """

    @checked
    def __init__(self, joint_names: tuple[str, ...], positions: Floats) -> None:
        """Begin at rest at positions of shape (n,) [rad | m]."""
        self.joint_names = joint_names
        self._standing = floats("positions", positions, (len(joint_names),))
        self._pieces: tuple[_Piece, ...] = ()
        self._last: tuple[tuple[_Piece, ...], float, Floats] | None = None

    @property
    def kept(self) -> int:
        """Number of motions that it holds; ended ones are dropped."""
        return len(self._pieces)

    @property
    def pieces(self) -> tuple[tuple[float, Trajectory], ...]:
        """The motions of all joints and when each begins [s]; one ends when the next begins."""
        return tuple((piece.begin, piece.whole) for piece in self._pieces)

    @property
    def end(self) -> float:
        """End of the last motion, on the clock [s]; minus infinity if there is none."""
        pieces = self._pieces
        return pieces[-1].end if pieces else -inf

    def __call__(self, time: float) -> Floats:
        number("time", time, infinite=True)
        pieces, last = self._pieces, self._last
        if last is not None and last[0] is pieces and last[1] == time:
            return last[2].copy()  # read twice at the begin of a motion: before and in its splice
        now = next((piece for piece in reversed(pieces) if piece.begin <= time), None)
        if now is None:
            rows: Floats = np.zeros((3, len(self.joint_names)))
            rows[0] = self._before(pieces)
        else:
            rows = now.state(time)
        self._last = pieces, time, rows
        return rows.copy()

    def positions(self, times: Floats) -> Floats:
        at = floats("times", times, (None,))
        pieces = self._pieces
        rows: Floats = np.empty((len(at), len(self.joint_names)))
        rows[:] = self._before(pieces)
        for piece, after in zip_longest(pieces, pieces[1:]):
            within = (at >= piece.begin) & (at < (inf if after is None else after.begin))
            if within.any():
                rows[within] = piece.whole(np.minimum(at[within] - piece.begin, piece.trajectory.duration))
        return rows

    def _before(self, pieces: tuple[_Piece, ...]) -> Floats:
        return pieces[0].state(pieces[0].begin)[0] if pieces else self._standing

    @checked
    def refusal(self, trajectory: Trajectory, at: float, *, earliest: float) -> str:
        """Return why a motion cannot be spliced in; empty if it can."""
        if at < earliest:
            return f"it comes {1e3 * (earliest - at):.1f} ms late"
        unknown = [name for name in trajectory.joint_names if name not in self.joint_names]
        if unknown:
            return f"it moves {', '.join(unknown)}, which the executor does not drive"
        here = self(at)
        columns = [self.joint_names.index(name) for name in trajectory.joint_names]
        left = np.abs(here[1]) > REST
        left[columns] = False
        if left.any():
            return f"{self.joint_names[int(left.argmax())]}, which it does not move, is still moving"
        # A motion may begin and end with an acceleration at rest; each has a time of `JOLT`.
        orders = 2 if at >= self.end + 2.0 * JOLT else 3
        apart = np.abs(state_of(trajectory, 0.0) - here[:, columns])[:orders]
        if apart.max() > MEETING:
            order = int((apart.max(axis=1) > MEETING).argmax())
            worst = int(apart[order].argmax())
            name = trajectory.joint_names[worst]
            return f"the {ORDERS[order]} of {name} would jump by {apart[order, worst]:.3g}"
        last = np.abs(state_of(trajectory, trajectory.duration)[1])
        if last.max() > REST:
            return f"it does not end at rest: {trajectory.joint_names[int(last.argmax())]} still moves"
        return ""

    @checked
    def splice(self, trajectory: Trajectory, at: float, *, now: float) -> None:
        kept = [piece for piece in self._pieces if piece.begin < at]
        current = [number for number, piece in enumerate(kept) if piece.begin <= now - REMEMBERED]
        piece = _Piece(at, trajectory, self.joint_names, self(at)[0])
        self._pieces = (*kept[current[-1] if current else 0 :], piece)

    @checked
    def ahead(self, time: float, joint_names: tuple[str, ...]) -> Trajectory | None:
        """Return the rest from a time on as one motion, or None."""
        for name in joint_names:
            if name not in self.joint_names:
                raise JointNotFound("joint that is driven", name, self.joint_names)
        rest: Trajectory | None = None
        pieces = self._pieces
        for place, piece in enumerate(pieces):
            next_begin = pieces[place + 1].begin if place + 1 < len(pieces) else piece.end
            begin, end = max(piece.begin, time), min(piece.end, next_begin)
            if end - begin <= INSTANT:
                continue
            motion = piece.of(joint_names)
            part = motion.between(begin - piece.begin, min(end - piece.begin, motion.duration))
            if rest is None:
                rest = part if begin - time <= INSTANT else begun_later(part, begin - time)
            else:
                gap = begin - time - rest.duration
                rest = rest.followed_by(part) if gap <= INSTANT else after_standing(rest, gap, part)
        return rest


def _rates(motion: Trajectory) -> list[Floats]:
    return [rows for rows in (motion.velocities, motion.accelerations) if rows is not None]


def of_joints(motion: Trajectory, joint_names: tuple[str, ...]) -> Trajectory:
    columns = [motion.joint_names.index(name) for name in joint_names]
    rows = [rows[:, columns] for rows in (motion.positions, *_rates(motion))]
    return Trajectory(joint_names, motion.times, *rows)
