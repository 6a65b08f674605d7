"""The soonest stop of what is being driven, on its path or off it."""

from collections.abc import Callable
from dataclasses import dataclass

from trajopt.arrays import Value
from trajopt.methods.stopping import stopping_motion
from trajopt.model.trajectory import Trajectory
from trajopt.planning import on_the_way
from trajopt.problem import Problem


@dataclass(frozen=True, eq=False)
class StopTaken(Value):
    """A stop that was commanded.

    Attributes:
        duration: From its begin to rest [s].
        along: Whether the robot stays on the path that it was on.
        proven: Whether it is proven that it keeps clear of everything.
    """

    duration: float
    along: bool
    proven: bool


def soonest_stop(
    here: Problem, ahead: Trajectory, along: Trajectory | None, proven: Callable[[Trajectory], bool]
) -> tuple[Trajectory, StopTaken]:
    """Return the soonest way to rest that is proven, or the soonest of all if none is.

    Args:
        here: What is required, with the robot where it will be when the stop begins.
        ahead: What is committed from then on; it ends at rest.
        along: The earliest stop on the path of the motion; None where it is too late for that.
        proven: Says whether a motion from then on is proven.
    """
    off = stopping_motion(on_the_way(here, ahead, 0.0))
    stops = [(ahead, True), (off, False), *([] if along is None else [(along, True)])]
    stops.sort(key=lambda stop: stop[0].duration)
    found = next((stop for stop in stops if proven(stop[0])), None)
    motion, on_path = found or stops[0]
    return motion, StopTaken(motion.duration, on_path, found is not None)
