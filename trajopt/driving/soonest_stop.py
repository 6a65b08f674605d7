"""The soonest stop of what is being driven, on its path or off it."""

from dataclasses import dataclass, replace

import numpy as np

from trajopt.driving.evasion import clear_at, evading_stops
from trajopt.driving.guard import Guard, Seen
from trajopt.optimise.methods.stopping import stop_from, stopping_motion, with_jerk
from trajopt.planning import on_the_way
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Value
from trajopt.values.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class StopTaken(Value):
    """A stop that was commanded.

    Attributes:
        duration: From its begin to rest [s]; where all motors brake at once, what they need at most.
        along: Whether the robot stays on the path that it was on.
        proven: Whether it is proven that it keeps clear of everything.
        held: Whether it is proven that all else holds that is required on the way, too.
    """

    duration: float
    along: bool
    proven: bool
    held: bool = True


GENTLE = (0.5, 0.25, 0.1)
"""Parts of the limits that braking off the path is tried with where no other stop is proven: what it takes
besides the torque that holds the load falls with them."""


def _gentle(here: Problem, ahead: Trajectory) -> list[Trajectory]:
    """Return stops that brake less hard than the limits allow, the sooner first."""
    begin, limits = np.stack([ahead(0.0, order) for order in range(3)]), here.limits
    running = np.abs(begin[2])  # what it is let go of takes as much as it has
    scaled = (
        replace(limits, acceleration=np.maximum(part * limits.acceleration, running), jerk=part * limits.jerk)
        for part in GENTLE
    )
    return [stop_from(begin, with_jerk(each)) for each in scaled]


def _proven(
    guard: Guard, world: Seen, begin: float, stops: list[Trajectory]
) -> tuple[Trajectory | None, bool]:
    """Return the first of some stops that is proven, or else that keeps clear; and whether all holds."""
    return next(
        (
            (stop, required)
            for required in (True, False)
            for stop in stops
            if guard.proven(stop, world, begin, requirements=required)
        ),
        (None, False),
    )


def soonest_stop(
    guard: Guard, world: Seen, begin: float, here: Problem, ahead: Trajectory, along: Trajectory | None
) -> tuple[Trajectory, StopTaken]:
    """Return the soonest way to rest that is proven; if none is, the soonest that keeps clear, or of all.

    If no stop along the path or of all joints keeps clear, one that turns away from the obstacle first may.
    Where something moves of which nothing is known any more before the robot is at rest, nothing can be
    proven: then the robot stays on its path, of which all else has been.

    Args:
        guard: Proves.
        world: What is known of the world.
        begin: When the stop begins, on the executor's clock [s].
        here: What is required, with the robot where it will be then.
        ahead: What is committed from then on; it ends at rest.
        along: The earliest stop on the path of the motion; None where it is too late for that.
    """
    on_path = [ahead] if along is None else [ahead, along]
    if world.stale(begin + ahead.duration):
        soonest = min(on_path, key=lambda stop: stop.duration)
        return soonest, StopTaken(soonest.duration, along=True, proven=False, held=False)
    stops = sorted((*on_path, stopping_motion(on_the_way(here, ahead, 0.0))), key=lambda stop: stop.duration)
    found, held = (stops[0], True) if guard.proven(stops[0], world, begin) else (None, False)
    if found is None:
        # With a heavy load, braking as hard as the limits allow may take a torque that there is not.
        every = sorted((*stops, *_gentle(here, ahead)), key=lambda stop: stop.duration)
        found, held = _proven(guard, world, begin, every)
    if found is None:
        turned = evading_stops(guard, world, begin, here, ahead, stops[0])
        found = next((each for each in turned if guard.proven(each, world, begin, requirements=False)), None)
        held = found is not None and guard.proven(found, world, begin)
    motion = found or stops[0]
    along_path = any(motion is stop for stop in on_path)
    return motion, StopTaken(motion.duration, along_path, found is not None, held)


def why_unproven(guard: Guard, world: Seen, begin: float, stop: Trajectory) -> str:
    """Say why no stop is proven: which pair comes how near, and whether any stop could do better.

    Args:
        guard: Proves.
        world: What is known of the world.
        begin: When the stop begins, on the executor's clock [s].
        stop: The stop that was taken.
    """
    why = guard.why_not(stop, world, begin)
    if world.stale(begin + stop.duration):
        return why
    if clear_at(guard, world, begin, stop):
        return f"no stop was found that keeps clear: {why}"
    return f"the robot is too near already where a stop can begin: {why}"
