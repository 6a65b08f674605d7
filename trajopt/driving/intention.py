"""Intention: the motion that a robot is to make, if nothing comes between."""

from dataclasses import dataclass, replace
from functools import cached_property

from trajopt.driving.guard import Guard
from trajopt.driving.pace import Clock, run_by
from trajopt.problem.problem import Problem
from trajopt.timing.stops import StopsAlong
from trajopt.values.arrays import Value
from trajopt.values.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Goal(Value):
    """A goal that a robot is to go to.

    Attributes:
        problem: What the motion there must achieve.
        guard: Proves what is driven on the way.
        blend_radius: How near to it it is enough to pass, where another follows [m].
    """

    problem: Problem
    guard: Guard
    blend_radius: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Intention(Value):
    """The motion that a robot is to make, if nothing comes between.

    Attributes:
        goal: Where it goes.
        planned: The motion as it was planned, of the group's joints.
        trajectory: The motion as it is to be driven: that, as its clock runs.
        clock: Runs at another rate where the robot goes slower than was planned.
        begin: When it begins, on the executor's clock [s].
        held_back: Whether it waits for something that moves: without that it would be over sooner.
    """

    goal: Goal
    planned: Trajectory
    trajectory: Trajectory
    clock: Clock
    begin: float
    held_back: bool = False

    @staticmethod
    def of(goal: Goal, planned: Trajectory, begin: float, *, held_back: bool = False) -> "Intention":
        """Return the intention to make a motion as it was planned; arguments are its attributes."""
        return Intention(
            goal=goal,
            planned=planned,
            trajectory=planned,
            clock=Clock.even(),
            begin=begin,
            held_back=held_back,
        )

    @property
    def end(self) -> float:
        """When it ends [s]."""
        return self.begin + self.trajectory.duration

    @cached_property
    def stops(self) -> StopsAlong:
        """Its stops along the path."""
        return StopsAlong(self.trajectory, self.goal.problem.limits)

    def left(self, time: float) -> Trajectory:
        """Return what is left of the motion at a time before its end, on the executor's clock [s]."""
        return self.trajectory.between(max(time - self.begin, 0.0), self.trajectory.duration)

    def at_pace(self, pace: float, time: float, *, stands: float | None = None) -> "Intention | None":
        """Return the same path driven at another pace from a time on; None where limits forbid the change.

        Args:
            pace: In (0, 1], of the motion as it was planned.
            time: On the executor's clock [s].
            stands: Where on the motion's own clock the robot stands then [s]; None where it moves.
        """
        moving = stands is None
        shown, rate, slope = self.clock.at(time - self.begin if stands is None else stands)
        rates = (rate, slope) if moving else (0.0, 0.0)
        found = run_by(self.planned, (shown, *rates), pace, self.goal.problem.limits)
        if found is None:
            return None
        trajectory, clock = found
        return replace(self, trajectory=trajectory, clock=clock, begin=time)
