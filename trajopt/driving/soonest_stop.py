"""The soonest proven stop: along the path, with all joints braking, or turning away first."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from trajopt.driving.motion_guard import MotionGuard
from trajopt.driving.servo_program import Braking, Surroundings
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.optimise.methods.timing import stop_from, stopping_motion, with_jerk
from trajopt.planning import on_the_way
from trajopt.problem.problem import Problem
from trajopt.robot.limits import JointLimits
from trajopt.scene.reduced import reduce_model
from trajopt.timing.joint_stops import stop_after
from trajopt.values.arrays import Floats, Value
from trajopt.values.trajectory import Trajectory

MEASURED_AT = (0.5, 1.0)
"""Where the nearest obstacles are measured, as parts of the stop that comes too near."""
PUSHES = (0.06, 0.1)
"""How long joints are pushed away before they brake [s]. Of the stops that a search over 800 others found
among hostile worlds, where no other was proven, one of these is in every case."""
SAMPLE_TIME = 0.01
"""Time step for which distances are measured [s]."""
MOMENT = 1e-3
"""A robot that stands for this long tells whether it is clear where it is [s]."""


def evading_stops(
    guard: MotionGuard, world: WorldSnapshot, begin: float, here: Problem, ahead: Trajectory, stop: Trajectory
) -> Iterator[Trajectory]:
    """Yield stops that turn away from obstacles; none if the robot is too near to one when they begin.

    Args:
        guard: Proves.
        world: What is known of the world.
        begin: When the stop begins, on the executor's clock [s].
        here: What is required, with the robot where it will be then.
        ahead: What is committed from then on.
        stop: A stop that comes too near to something.
    """
    if not clear_at(guard, world, begin, ahead):
        return
    state = np.stack([ahead(0.0, order) for order in range(3)])
    limits = with_jerk(here.limits)
    reduced = reduce_model(world.scene, guard.problem.group, guard.problem.start_positions)
    around = Surroundings(reduced, Braking(limits, SAMPLE_TIME), guard.options.distance_error)
    for look in MEASURED_AT:
        there = np.stack((stop(look * stop.duration), state[1], np.zeros(len(state[1]))))
        near = around.approach(there, world.clock(begin + look * stop.duration))
        if not len(near.jacobian):
            continue
        gains = near.jacobian * limits.acceleration
        gains = gains / np.maximum(np.abs(gains).max(axis=1, keepdims=True), np.finfo(np.float64).tiny)
        for away in (gains[int(near.lower.argmax())], gains.sum(axis=0)):
            largest = float(np.abs(away).max())
            for shares in (np.sign(away), away / largest) if largest > 0.0 else ():
                for push in PUSHES:
                    motion = _pushed(state, shares * limits.acceleration, push, limits)
                    if motion is not None:
                        yield motion


def _pushed(state: Floats, wanted: Floats, push: float, limits: JointLimits) -> Trajectory | None:
    """Return a motion that goes over to accelerations within a time, then stops; None if it gets too fast."""
    q, v, a = state
    jerk = np.clip((wanted - a) / push, -limits.jerk, limits.jerk)
    end = np.stack(
        (
            q + push * (v + push * (a / 2.0 + push * jerk / 6.0)),
            v + push * (a + push * jerk / 2.0),
            a + push * jerk,
        )
    )
    if (np.abs(end[1]) > limits.velocity).any():
        return None
    return stop_after(state, end, push, limits)


def clear_at(guard: MotionGuard, world: WorldSnapshot, begin: float, ahead: Trajectory) -> bool:
    """Say whether the robot is clear where a stop begins: if it is not, no stop is proven.

    Args:
        guard: Proves.
        world: What is known of the world.
        begin: When the stop begins, on the executor's clock [s].
        ahead: What is committed from then on.
    """
    here = ahead(0.0)
    still = np.zeros((2, len(here)))
    standing = Trajectory(ahead.joint_names, np.array((0.0, MOMENT)), np.stack((here, here)), still, still)
    return guard.proven(standing, world, begin, requirements=False)


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
    guard: MotionGuard, world: WorldSnapshot, begin: float, stops: list[Trajectory]
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
    guard: MotionGuard,
    world: WorldSnapshot,
    begin: float,
    here: Problem,
    ahead: Trajectory,
    along: Trajectory | None,
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


def why_unproven(guard: MotionGuard, world: WorldSnapshot, begin: float, stop: Trajectory) -> str:
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
