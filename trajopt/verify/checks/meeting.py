"""Meeting what moves: placement relative to it, and no velocity relative to it, at the end of a motion.

A motion that meets a goal that moves ends in motion. It has followed the goal for as long as it is asked to
stay with it: in all of that time the placement is proven, and at its first and last moment the velocity, but
along and about axes that the placement leaves free.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trajopt.problem.requirements import FramePlacement, Requirement
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_unit
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.checks.criterion import Criterion
from trajopt.verify.checks.quantities import check_requirement
from trajopt.verify.checks.requirement import When
from trajopt.verify.kernel.motion import Motion

_MOMENT = 1e-9
"""Velocities of tracks may jump at their times: they are taken so long inside what is asked about [s]."""


@dataclass(frozen=True, eq=False)
class MeetingCriterion(Criterion):
    """The goals that time moves: the motion meets them, and stays with them.

    Attributes:
        motion: Among what changes with time.
        followed: The goals that time moves.
        dwell: How long it has to have followed them when it ends [s].
    """

    motion: Motion
    followed: Sequence[Requirement]
    dwell: float

    def measure(self) -> Iterator[Check]:
        """State the placement and the speed relative to each goal."""
        motion = self.motion
        begin = motion.duration - self.dwell
        if self.followed and begin < 0.0:
            yield _too_short(motion, self.followed[0], self.dwell)
            return
        for goal in self.followed:
            if self.dwell <= 0.0:
                yield from check_requirement(goal, motion, When.END)
                yield from _at_rest(motion, goal, motion.duration)
                continue
            for check in check_requirement(goal, motion.between(begin, motion.duration), When.ALWAYS):
                time = None if check.time is None else check.time + begin
                yield replace(check, name=check.name.replace(When.ALWAYS.value, When.END.value, 1), time=time)
            yield from _at_rest(motion, goal, begin)
            yield from _at_rest(motion, goal, motion.duration)


def _at_rest(motion: Motion, goal: Requirement, time: float) -> Iterator[Check]:
    """State how fast a frame moves as seen from what it meets, at a time."""
    assert isinstance(goal, FramePlacement), "no other goals move"
    moment = min(max(time - _MOMENT, 0.0) if time >= motion.duration else time + _MOMENT, motion.duration)
    options = motion.options
    moves, turns = relative_speeds(motion, goal, moment)
    for size, bound, unit, words in (
        (moves, options.meeting_speed, "m/s", "moves at"),
        (turns, options.meeting_rate, "rad/s", "turns at"),
    ):
        yield Check(
            kind=CheckKind.ENDS,
            name="goal: at rest as seen from it",
            subject=goal.frame,
            value=size,
            bound=bound,
            unit=unit,
            time=time,
            slack=bound - size,
            evidence=Evidence.PROVEN,
            holds=size <= bound,
            detail=f"{goal.frame} {words} {in_unit(size, unit)} as seen from {goal.reference}",
        )


def relative_speeds(motion: Motion, goal: FramePlacement, time: float) -> tuple[float, float]:
    """Return how fast a frame's point moves and the frame turns, as seen from its reference [m/s, rad/s].

    Only along and about those axes of the placement that it does not leave free.
    """
    poses, rates = motion.poses(np.array((time,))), _rates(motion, time)
    rotation, translation = poses.rotation[0], poses.translation[0]
    joint, place = motion.reduced.attachment(goal.frame)
    base, seen_from = motion.reduced.attachment(goal.reference)
    point = rotation[joint] @ (place * goal.offset) + translation[joint]
    moved, turning = _carried(motion, joint, point, rotation, translation, rates)
    # The reference carries along what is at rest in it: its point where the frame's point is.
    taken, turned = _carried(motion, base, point, rotation, translation, rates)
    axes = rotation[base] @ seen_from.rotation @ goal.placement.rotation
    moves, turns = (moved - taken) @ axes, (turning - turned) @ axes
    held, upright = np.isfinite(goal.position_tolerance), goal.rotation_tolerance < np.pi
    return float(np.linalg.norm(moves[held])), float(np.linalg.norm(turns[upright]))


def _carried(
    motion: Motion, joint: int, point: Floats, rotation: Floats, translation: Floats, rates: Floats
) -> tuple[Floats, Floats]:
    """Return the velocity of a point of the world that a joint carries, and the angular velocity, (3,)."""
    kinematics = motion.kinematics
    velocity, turning = np.zeros(3), np.zeros(3)
    for number in kinematics.chain(joint):
        axis = rotation[number] @ kinematics.axes[number] * rates[number - 1]
        if kinematics.revolute[number]:
            velocity = velocity + np.cross(axis, point - translation[number])
            turning = turning + axis
        else:
            velocity = velocity + axis
    return velocity, turning


def _rates(motion: Motion, time: float) -> Floats:
    """Return the velocities of all joints that move, those that time drives too, in the model's order."""
    rates = motion.moving(1)
    piece = min(int(np.searchsorted(rates.times, time, side="right")) - 1, len(rates.times) - 2)
    since = np.array((time - float(rates.times[piece]),))
    return rates.at(np.array((piece,), dtype=np.int64), since)[0]


def _too_short(motion: Motion, goal: Requirement, dwell: float) -> Check:
    return Check(
        kind=CheckKind.ENDS,
        name="goal: dwell",
        subject=goal.frames[0],
        value=motion.duration,
        bound=dwell,
        unit="s",
        time=None,
        slack=motion.duration - dwell,
        evidence=Evidence.PROVEN,
        holds=False,
        detail=f"the motion is over in {motion.duration:.3f} s, it was to follow its goal for {dwell:g} s",
    )
