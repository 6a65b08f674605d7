"""on_the_way(problem, running, time): a problem from where a running motion will be."""

from dataclasses import replace

import numpy as np

from trajopt.problem.problem import Problem
from trajopt.robot.limits import EXCESS
from trajopt.values.arrays import Floats, number, one_of
from trajopt.values.errors import ShapeError
from trajopt.values.trajectory import Trajectory


def on_the_way(problem: Problem, running: Trajectory, time: float) -> Problem:
    """Return a problem with its start on a motion that is being driven.

    The start has the motion's position, velocity and acceleration at that time, so that what is planned goes
    on from it without a jump; joints outside the group are where the problem's own start has them. From the
    end of the motion on it is at rest. A deadline comes sooner by that time. The scene stays the problem's
    own: where things in it move, give that of the time at which the motion from there on starts (`scene.at`).

    Args:
        problem: What the motion from there on must achieve.
        running: Of the group's joints.
        time: On the running motion, at least 0 [s]: now, and as long as it takes until the plan is driven.

    Raises:
        ShapeError: If the time is before the motion begins, or the motion moves other joints.
        JointNotFound: If the motion lacks a joint of the group.
        ProblemError: If the motion is faster there than the problem allows, or an argument is of the wrong
            kind.
    """
    reduced, limits = one_of("problem", problem, Problem).reduced, problem.limits
    moved = one_of("running", running, Trajectory).ordered(reduced.joint_names)
    moment = number("time", time)
    if moment < 0.0:
        raise ShapeError("time", f"is on the running motion, which begins at 0 s; is {moment:g}")
    rates = [
        _within(moved(moment, order), most)
        for order, most in ((1, limits.velocity), (2, limits.acceleration))
    ]
    if moment >= moved.duration:
        rates = [np.zeros(len(limits.velocity))] * 2
    names, robot = reduced.joint_names, problem.scene.robot
    positions = np.array(problem.start_positions)
    positions[robot.index(names)] = moved(moment)
    velocity, acceleration = (dict(zip(names, rate.tolist(), strict=True)) for rate in rates)
    return replace(
        problem,
        finish_by=None if problem.finish_by is None else problem.finish_by - moment,
        start=robot.followed(positions),
        start_velocity=velocity,
        start_acceleration=acceleration,
    )


def _within(rate: Floats, most: Floats) -> Floats:
    """Take back what a motion may exceed a limit by: rounding, and what the judge accepts."""
    accepted = np.abs(rate) <= most * (1.0 + EXCESS)
    return np.where(accepted, np.clip(rate, -most, most), rate)
