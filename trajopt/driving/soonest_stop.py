"""The soonest proven stop: along the path, with all joints braking, or turning away first."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from trajopt.driving.motion_guard import MotionGuard
from trajopt.driving.servo_program import ApproachQuery, Braking
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.optimise.methods.timing import stop_from, with_jerk
from trajopt.robot.joints import JointLimits
from trajopt.timing.time_scaling import stop_after
from trajopt.values.arrays import Floats, Value
from trajopt.values.trajectory import Trajectory

GENTLE = (0.5, 0.25, 0.1)
"""Shares of the limits for braking off the path if no other stop is proven: the torque of braking falls
with them.
"""
MEASURED_AT = (0.5, 1.0)
"""Shares of the unproven stop at which the nearest obstacles are measured."""
PUSHES = (0.06, 0.1)
"""Durations of the push away from an obstacle before braking [s]."""
URGENT = 0.3
"""Pairs within this speed of the most urgent one are pushed apart together [m/s]."""
SAMPLE_TIME = 0.01
"""Time step for the measured distances [s]."""
REST_TIME = 1e-3
"""Duration of a rest whose proof shows that the robot is clear at its position [s]."""


@dataclass(frozen=True, eq=False)
class StopTaken(Value):
    """A commanded stop.

    Attributes:
        duration: From its beginning to rest [s]; if all motors brake, the longest time they need.
        along: Whether the robot stays on its path.
        proven: Whether it is proven to be clear of everything.
        held: Whether the path constraints are proven, too.
    """

    duration: float
    along: bool
    proven: bool
    held: bool = True


def soonest_stop(
    guard: MotionGuard,
    world: WorldSnapshot,
    begin: float,
    limits: JointLimits,
    ahead: Trajectory,
    along: Trajectory | None,
) -> tuple[Trajectory, StopTaken]:
    """Return the soonest proven stop; if none is proven, the soonest clear one, or the soonest of all.

    If neither a stop along the path nor one of all joints is clear, stops that turn away from the obstacle
    first are tried. If a prediction ends before the robot is at rest, it stays on its path.

    Args:
        limits: Of the group's joints.
        ahead: The committed motion from that time; it ends at rest.
        along: The earliest stop on the path of the motion, or None.
    """
    on_path = [ahead] if along is None else [ahead, along]
    if world.stale(begin + ahead.duration):
        soonest = min(on_path, key=lambda stop: stop.duration)
        return soonest, StopTaken(soonest.duration, along=True, proven=False, held=False)
    stops = sorted((*on_path, _braking(ahead, limits)), key=lambda stop: stop.duration)
    found, held = (stops[0], True) if guard.proven(stops[0], world, begin) else (None, False)
    if found is None:
        # With a heavy load, braking as hard as the limits allow may exceed the torque limits.
        candidates = sorted((*stops, *_gentle_stops(ahead, limits)), key=lambda stop: stop.duration)
        found, held = _first_proven(guard, world, begin, candidates, refused=stops[0])
    if found is None:
        turned = evading_stops(guard, world, begin, limits, ahead, stops[0])
        found = next((each for each in turned if guard.proven(each, world, begin, requirements=False)), None)
        held = found is not None and guard.proven(found, world, begin)
    motion = found or stops[0]
    stays = any(motion is stop for stop in on_path)
    return motion, StopTaken(motion.duration, stays, found is not None, held)


def why_unproven(guard: MotionGuard, world: WorldSnapshot, begin: float, stop: Trajectory) -> str:
    why = guard.failed_check(stop, world, begin)
    if world.stale(begin + stop.duration):
        return why
    if clear_at(guard, world, begin, stop):
        return f"no clear stop was found: {why}"
    return f"the robot is too near to an obstacle when a stop can begin: {why}"


def evading_stops(
    guard: MotionGuard,
    world: WorldSnapshot,
    begin: float,
    limits: JointLimits,
    ahead: Trajectory,
    stop: Trajectory,
) -> Iterator[Trajectory]:
    """Yield stops that turn away from obstacles first; none if the robot is too near when they begin.

    Args:
        stop: A stop that comes too near to an obstacle.
    """
    if not clear_at(guard, world, begin, ahead):
        return
    state, limits = _state(ahead), with_jerk(limits)
    braking = Braking(limits, SAMPLE_TIME)
    around = ApproachQuery(guard.reduced(world.scene), braking, guard.options.distance_error)
    for share in MEASURED_AT:
        there = np.stack((stop(share * stop.duration), state[1], np.zeros(len(state[1]))))
        near = around.limits(there, world.clock(begin + share * stop.duration))
        if not len(near.jacobian):
            continue
        gains = near.jacobian * limits.acceleration
        gains = gains / np.maximum(np.abs(gains).max(axis=1, keepdims=True), np.finfo(np.float64).tiny)
        urgent = near.lower >= near.lower.max() - URGENT
        for away in (gains[int(near.lower.argmax())], gains[urgent].sum(axis=0), gains.sum(axis=0)):
            largest = float(np.abs(away).max())
            for shares in (np.sign(away), away / largest) if largest > 0.0 else ():
                for push in PUSHES:
                    motion = _pushed(state, shares * limits.acceleration, push, limits)
                    if motion is not None:
                        yield motion


def clear_at(guard: MotionGuard, world: WorldSnapshot, begin: float, ahead: Trajectory) -> bool:
    here = ahead(0.0)
    still = np.zeros((2, len(here)))
    resting = Trajectory(ahead.joint_names, np.array((0.0, REST_TIME)), np.stack((here, here)), still, still)
    return guard.proven(resting, world, begin, requirements=False)


def _state(ahead: Trajectory) -> Floats:
    return np.stack([ahead(0.0, order) for order in range(3)])


def _braking(ahead: Trajectory, limits: JointLimits) -> Trajectory:
    return stop_from(_state(ahead), with_jerk(limits))


def _gentle_stops(ahead: Trajectory, limits: JointLimits) -> list[Trajectory]:
    present = np.abs(ahead(0.0, 2))  # letting go of an acceleration needs as much
    scaled = (
        replace(limits, acceleration=np.maximum(part * limits.acceleration, present), jerk=part * limits.jerk)
        for part in GENTLE
    )
    return [_braking(ahead, each) for each in scaled]


def _first_proven(
    guard: MotionGuard, world: WorldSnapshot, begin: float, stops: list[Trajectory], refused: Trajectory
) -> tuple[Trajectory | None, bool]:
    """Return the first proven stop, and whether its path constraints are; one stop is known not to be."""
    return next(
        (
            (stop, required)
            for required in ((True, False) if guard.problem.requirements else (True,))
            for stop in stops
            if not (required and stop is refused) and guard.proven(stop, world, begin, requirements=required)
        ),
        (None, False),
    )


def _pushed(state: Floats, wanted: Floats, push: float, limits: JointLimits) -> Trajectory | None:
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
