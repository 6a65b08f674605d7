"""Intention: the motion that a robot is to make, if nothing comes between."""

from dataclasses import dataclass, replace
from functools import cached_property

from trajopt.driving.guard import Guard
from trajopt.driving.speed_scaling import FULL_SPEED, SpeedScaling, scale_speed
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
        trajectory: The motion as it is to be driven.
        scaling: The speed at which it is driven.
        begin: When it begins, on the executor's clock [s].
        held_back: Whether it waits for something that moves: without that it would be over sooner.
    """

    goal: Goal
    planned: Trajectory
    trajectory: Trajectory
    scaling: SpeedScaling
    begin: float
    held_back: bool = False

    @staticmethod
    def of(goal: Goal, planned: Trajectory, begin: float, *, held_back: bool = False) -> "Intention":
        """Return the intention to make a motion as it was planned; arguments are its attributes."""
        return Intention(
            goal=goal,
            planned=planned,
            trajectory=planned,
            scaling=FULL_SPEED,
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

    def at_speed(self, speed: float, time: float, *, rests_at: float | None = None) -> "Intention | None":
        """Return the rest of the path at another speed; None if limits forbid the change.

        Args:
            speed: Share of the planned speed, in (0, 1].
            time: When the rest begins, on the executor's clock [s].
            rests_at: Time of the motion at which the robot rests on its path then [s]; None if it moves.
        """
        moving = rests_at is None
        clock, rate, slope = self.scaling.at(time - self.begin if rests_at is None else rests_at)
        begin = (clock, rate, slope) if moving else (clock, 0.0, 0.0)
        found = scale_speed(self.planned, begin, speed, self.goal.problem.limits)
        if found is None:
            return None
        trajectory, scaling = found
        return replace(self, trajectory=trajectory, scaling=scaling, begin=time)
