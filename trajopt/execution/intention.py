"""Intention: the motion that a robot is to make, if nothing comes between."""

from dataclasses import dataclass

from trajopt.arrays import Value
from trajopt.model.trajectory import Trajectory
from trajopt.problem import Problem
from trajopt.retime.stops import StopsAlong


@dataclass(frozen=True, eq=False)
class Intention(Value):
    """The motion that a robot is to make, if nothing comes between.

    Attributes:
        problem: What it solves.
        trajectory: The motion, of the group's joints.
        begin: When it begins, on the executor's clock [s].
        stops: Its stops along the path.
    """

    problem: Problem
    trajectory: Trajectory
    begin: float
    stops: StopsAlong

    @property
    def end(self) -> float:
        """When it ends [s]."""
        return self.begin + self.trajectory.duration
