"""In space and time: the shape of a motion and its timing planned together, among what changes with time.

Seeds are motions that need not be possible: the one without what changes as it is, begun later, slower, and
those that were found already. Each is made into the shortest motion near to it.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import ceil, inf

import numpy as np

from trajopt.methods.space_time import PRECISION, SpaceTime, SpaceTimeProgram
from trajopt.model.trajectory import Trajectory
from trajopt.planning.budget import BudgetTracker, Stopped
from trajopt.planning.result import Result
from trajopt.planning.seeds import with_knots
from trajopt.planning.waiting import LONGEST
from trajopt.planning.workspace import TimedMotion, Workspace
from trajopt.problem import Problem

SLOWER = (1.5, 2.5)
"""Parts of its duration that the motion without what changes is slowed to: things pass before it."""
ENOUGH = 1.05
"""A motion this much longer than without what changes is short enough: pieces and precision cost as much."""
LEFT = 1e-3
"""A motion has left its start where a joint is so far from it [rad | m]."""
SOON = 0.1
"""A motion that leaves its start so soon does not wait [s]: a person sees no pause in a shorter one."""
PACES = 200
"""Moments of a seed."""
STEPS = 10
"""Steps of a seed's beginning in each duration of the motion."""
BECAUSE = "things move, appear or expire, and no timing of the path without them is better"
"""Why planning takes the method."""


def in_space_time(problem: Problem, still: Result, best: Result, tracker: BudgetTracker) -> Result:
    """Return the shortest motion that is found with shape and time planned together; else the one given.

    Args:
        problem: What is asked, with one goal.
        still: The verified motion without what changes.
        best: The shortest that was found already; it may be none that is verified.
        tracker: Counts what is used, and stops planning.

    Raises:
        Stopped: If the budget runs out and nothing is verified.
    """
    method, alone = SpaceTime(), still.require()
    if problem.waypoints or method.objection(problem):
        return best
    knots = with_knots(alone.path.knots, problem.knots)
    program, work = method.program(problem, knots), Workspace(problem, tracker)
    try:
        for seed in _seeds(alone.trajectory, best, program, tracker):
            longest = best.require().trajectory.duration if best.verified else inf
            if longest <= ENOUGH * alone.trajectory.duration:
                break
            found = _attempted(program, seed, PRECISION * longest, work)
            if found is not None:
                remarks = (*still.remarks, _described(found.require().trajectory, alone.trajectory))
                kept = {name: getattr(still, name) for name in ("attempts", "won", "goal_name")}
                best = replace(found, remarks=remarks, method=method.name, because=BECAUSE, **kept)
    except Stopped as ended:
        if not best.verified:
            raise
        best = replace(best, stopped=ended.stop)
    return best


def _attempted(program: SpaceTimeProgram, seed: Trajectory, longest: float, work: Workspace) -> Result | None:
    """Return the verified motion that a seed becomes; None where it becomes none."""
    with work.tracker.optimising(program.counts) as step:
        solved = program.solve_from(seed, longest=longest, progress=step)
    work.tracker.count(attempts=1, qp_solves=solved.qp_solves, qp_iterations=solved.qp_iterations)
    motion = solved.decoded.trajectory
    if motion is None:
        return None
    judged = work.judged(TimedMotion(solved.decoded.path, motion, None), solved)
    return judged if judged.verified else None


def _seeds(
    alone: Trajectory, best: Result, program: SpaceTimeProgram, tracker: BudgetTracker
) -> Iterator[Trajectory]:
    """Yield motions to begin with: hurried, the best so far, later, slower."""
    yield alone
    if best.verified:
        yield best.require().trajectory
    with tracker.stage("wait"):
        wait = _first_clear(alone, program)
    if wait > 0.0:
        yield _paced(alone, wait, 1.0)
    yield from (_paced(alone, 0.0, slower) for slower in SLOWER)


def _first_clear(motion: Trajectory, program: SpaceTimeProgram) -> float:
    """Return when a motion can begin if the robot may be anywhere until then; 0 if never, or at once [s]."""
    assert program.world is not None
    times = np.linspace(0.0, motion.duration, PACES)
    positions, step = motion(times), motion.duration / STEPS
    last = min(program.world.settled, program.world.timed.until - motion.duration, LONGEST)
    for wait in (step * np.arange(ceil(max(last, 0.0) / step) + 1)).tolist():
        if (program.world.spare(positions, times + wait) >= 0.0).all():
            return wait
    return 0.0


def _paced(motion: Trajectory, wait: float, slower: float) -> Trajectory:
    """Return a motion begun later and slowed; it need not be possible."""
    times = np.linspace(0.0, wait + slower * motion.duration, PACES)
    at = np.clip((times - wait) / slower, 0.0, motion.duration)
    return Trajectory(motion.joint_names, times, motion(at))


def _described(motion: Trajectory, alone: Trajectory) -> str:
    """Say what a motion does that it would not do without what changes."""
    begun = _begun(motion)
    waits = f"waits {begun:.2f} s, then takes" if begun > max(SOON, 2.0 * _begun(alone)) else "takes"
    more = motion.duration - alone.duration
    return (
        f"shape and time were planned together for what changes with time: {waits} another way or another "
        f"pace, {abs(more):.3f} s {'longer' if more > 0.0 else 'shorter'} than without it"
    )


def _begun(motion: Trajectory) -> float:
    """Return when a motion has left its start [s]."""
    times = np.linspace(0.0, motion.duration, PACES)
    away = (np.abs(motion(times) - motion(0.0)) > LEFT).any(axis=1)
    return float(times[np.argmax(away)])
