"""Evading stops: a short push away from what comes too near, then a stop."""

from collections.abc import Iterator

import numpy as np

from trajopt.driving.guard import Guard, Seen
from trajopt.driving.servo_program import Braking, Surrounding
from trajopt.optimise.methods.stopping import with_jerk
from trajopt.problem.problem import Problem
from trajopt.robot.limits import JointLimits
from trajopt.scene.reduced import reduce_model
from trajopt.timing.joint_stops import stop_after
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory

LOOKS = (0.5, 1.0)
"""Where the nearest obstacles are measured, as parts of the stop that comes too near."""
PUSHES = (0.06, 0.1)
"""How long joints are pushed away before they brake [s]. Of the stops that a search over 800 others found
among hostile worlds, where no other was proven, one of these is in every case."""
TICK = 0.01
"""Time step for which distances are measured [s]."""
MOMENT = 1e-3
"""A robot that stands for this long tells whether it is clear where it is [s]."""


def evading_stops(
    guard: Guard, world: Seen, begin: float, here: Problem, ahead: Trajectory, stop: Trajectory
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
    around = Surrounding(reduced, Braking(limits, TICK), guard.options.distance_error)
    for look in LOOKS:
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


def clear_at(guard: Guard, world: Seen, begin: float, ahead: Trajectory) -> bool:
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
