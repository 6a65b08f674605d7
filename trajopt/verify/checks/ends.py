"""Ends of a motion: start, end, deadline, and moving goals.

A motion that meets a moving goal has followed it for the dwell time: the placement is proven for all of this
time, the relative velocity at its ends.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import singledispatch
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from trajopt.problem.requirement import Requirement
from trajopt.robot.joints import joint_unit
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError
from trajopt.values.printed import in_unit
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.checks.quantities import When, check_requirement
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.specification import Criterion, Specification

if TYPE_CHECKING:
    from trajopt.scene.track import Timing


@dataclass(frozen=True, eq=False)
class _End:
    name: str
    sizes: Floats
    bound: float
    time: float
    order: int


@dataclass(frozen=True, eq=False)
class EndCriterion(Criterion):
    """Start state, and velocities at both ends if the trajectory has velocities.

    Attributes:
        specification: Zero or missing start accelerations are not judged; jumps are, with the jerk limits.
    """

    motion: JudgedMotion
    specification: Specification

    def holds(self) -> bool:
        return all(end.sizes.max() <= end.bound for end in self._ends())

    def measure(self) -> Iterator[Check]:
        for end in self._ends():
            yield _check(self.motion, end)

    def _ends(self) -> Iterator[_End]:
        motion, options = self.motion, self.motion.options
        yield _End("start", self._off_start(), options.start_error, 0.0, 0)
        velocities, before = motion.trajectory.velocities, self.specification.start_velocities
        if velocities is not None:
            rests = before is None or not before.any()
            begin = velocities[0] if before is None else velocities[0] - before
            name = "start at rest" if rests else "start velocity"
            yield _End(name, np.abs(begin), options.rest_speed, 0.0, 1)
            if motion.rests_after:
                yield _End("end at rest", np.abs(velocities[-1]), options.rest_speed, motion.duration, 1)
        accelerations = self.specification.start_accelerations
        if accelerations is not None and accelerations.any() and motion.differentiable:
            # Twice the coefficient of the square of time, in the first piece.
            off = np.abs(2.0 * motion.position.coefficients[-3, 0] - accelerations)
            yield _End("start acceleration", off, options.start_acceleration_error, 0.0, 2)

    def _off_start(self) -> Floats:
        start, motion = self.specification.start_positions, self.motion
        return np.abs(
            motion.trajectory.positions[0] - (motion.reduced.start_positions if start is None else start)
        )


def _check(motion: JudgedMotion, end: _End) -> Check:
    joint = int(end.sizes.argmax())
    subject = motion.reduced.joint_names[joint]
    value = float(end.sizes[joint])
    unit = joint_unit(motion.reduced.scene.robot.model, subject, order=end.order)
    words = "moves at" if end.name.endswith("rest") else "is off by"
    return Check(
        kind=CheckKind.ENDS,
        name=end.name,
        subject=subject,
        value=value,
        bound=end.bound,
        unit=unit,
        time=end.time,
        slack=end.bound - value,
        evidence=Evidence.PROVEN,
        holds=value <= end.bound,
        detail=f"{subject} {words} {in_unit(value, unit)}",
    )


@dataclass(frozen=True, eq=False)
class DeadlineCriterion(Criterion):
    """Deadline of a motion, if it has one.

    Attributes:
        follows: Time for which it follows a moving goal at its end [s]; it arrives earlier by this time.
    """

    motion: JudgedMotion
    finish_by: float | None
    follows: float = 0.0

    def measure(self) -> Iterator[Check]:
        """Return the time of arrival at the goal."""
        if self.finish_by is None:
            return
        there = self.motion.duration - self.follows
        slack = self.finish_by - there
        late = f"{-slack:.3f} s late" if slack < 0.0 else f"{slack:.3f} s early"
        yield Check(
            kind=CheckKind.DEADLINE,
            name="finish by",
            subject="",
            value=there,
            bound=self.finish_by,
            unit="s",
            time=there,
            slack=slack,
            evidence=Evidence.PROVEN,
            holds=slack >= 0.0,
            detail=f"is at the goal at {there:.3f} s, {late}",
        )


@dataclass(frozen=True, eq=False)
class PredictionCriterion(Criterion):
    """Coverage of the motion by predictions of finite duration."""

    motion: JudgedMotion
    timings: Mapping[str, Timing]

    def measure(self) -> Iterator[Check]:
        """Return the end of each finite prediction and the time for which it is needed."""
        motion, needed = self.motion, self.motion.duration
        for name, timing in self.timings.items():
            if timing.motion is None or timing.motion.until == inf:
                continue
            until = timing.motion.until - motion.clock
            slack = until - min(needed, timing.expires - motion.clock)
            yield Check(
                kind=CheckKind.PREDICTION,
                name="prediction",
                subject=name,
                value=needed,
                bound=until,
                unit="s",
                time=None,
                slack=slack,
                evidence=Evidence.PROVEN if slack >= 0.0 else Evidence.UNPROVEN,
                holds=slack >= 0.0,
                detail=f"the prediction of {name} ends at {until:g} s, but is needed until {needed:.3f} s",
            )


_MOMENT = 1e-9
"""Offset into an interval at which track velocities are evaluated, as they may jump at knots [s]."""


@dataclass(frozen=True, eq=False)
class MeetingCriterion(Criterion):
    """Moving goals: the motion meets and follows them."""

    motion: JudgedMotion
    followed: Sequence[Requirement]
    dwell: float

    def measure(self) -> Iterator[Check]:
        """Return placement and speed relative to each goal."""
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


def _at_rest(motion: JudgedMotion, goal: Requirement, time: float) -> Iterator[Check]:
    moment = min(max(time - _MOMENT, 0.0) if time >= motion.duration else time + _MOMENT, motion.duration)
    options = motion.options
    moves, turns = relative_speeds(goal, motion, moment)
    for size, bound, unit, words in (
        (moves, options.meeting_speed, "m/s", "moves at"),
        (turns, options.meeting_rate, "rad/s", "turns at"),
    ):
        yield Check(
            kind=CheckKind.ENDS,
            name="goal: at rest relative to it",
            subject=goal.frames[0],
            value=size,
            bound=bound,
            unit=unit,
            time=time,
            slack=bound - size,
            evidence=Evidence.PROVEN,
            holds=size <= bound,
            detail=f"{goal.frames[0]} {words} {in_unit(size, unit)} relative to {goal.frames[1]}",
        )


@singledispatch
def relative_speeds(goal: Requirement, motion: JudgedMotion, time: float) -> tuple[float, float]:
    """Return linear and angular speed of a frame relative to a moving goal at a time [m/s, rad/s]."""
    del motion, time
    raise ProblemError(f"{goal}: goals of kind {type(goal).__name__} cannot be relative to a moving object")


def _too_short(motion: JudgedMotion, goal: Requirement, dwell: float) -> Check:
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
        detail=f"the motion takes {motion.duration:.3f} s, but must follow its goal for {dwell:g} s",
    )
