"""Replanning from a running motion."""

from dataclasses import replace
from threading import Event

import numpy as np

from trajopt.optimise.kinematics.projection import Projection
from trajopt.optimise.methods.space_time import SpaceTime
from trajopt.optimise.solvers import SolveResult
from trajopt.optimise.transcription.free_duration import SHORTEST
from trajopt.planning.budget import Budget, BudgetTracker, Progress, Stopped
from trajopt.planning.moving.rendezvous import goals_that_move
from trajopt.planning.plan import NO_BOUNDS, bounded, plan
from trajopt.planning.result import Attempt, Result
from trajopt.planning.search import ENDED
from trajopt.planning.seeds import SeedKind, with_knots
from trajopt.planning.status import Status
from trajopt.planning.workspace import MotionCandidate, PlanningWorkspace
from trajopt.problem.problem import Problem
from trajopt.robot.joints import EXCESS
from trajopt.values.arrays import Floats, number, one_of
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import named
from trajopt.values.trajectory import Path, Trajectory
from trajopt.verify import Judge


def on_the_way(problem: Problem, running: Trajectory, time: float) -> Problem:
    """Return a problem with its start on a running motion: its position, velocity and acceleration at a time.

    Joints outside the group are at the problem's own start. After the end of the motion it is at rest. A
    deadline comes sooner by that time. If objects in the scene move, pass the scene at the start of the new
    motion (`scene.at`).

    Args:
        problem: The requirements of the motion from there on.
        running: Of the group's joints.
        time: On the running motion, at least 0 [s]: now, plus the time until the plan is executed.

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
        raise ShapeError("time", f"must not be before the running motion, which begins at 0 s; is {moment:g}")
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
    """Remove a motion's accepted excess over a limit: rounding, and the judge's tolerance."""
    accepted = np.abs(rate) <= most * (1.0 + EXCESS)
    return np.where(accepted, np.clip(rate, -most, most), rate)


SLOWER = (1.05, 1.25)
"""Factors on the remaining duration to try if it does not suffice: the cost of even pieces, and room to bend
around an object. If these fail, the motion is planned from scratch.
"""
MOMENTS = 200
"""Moments of a motion led elsewhere."""
BECAUSE = "what is left of the running motion is nearly what is asked"


@named
def replan(
    problem: Problem,
    running: Trajectory,
    time: float,
    *,
    seconds: float | None = None,
    budget: Budget = NO_BOUNDS,
    cancel: Event | None = None,
    progress: Progress | None = None,
) -> Result:
    """Plan from a point of a running motion, beginning with the rest of it.

    First shape and timing of the rest are optimised together. If that gives no verified motion, `plan` plans
    from there. Acceleration does not jump.

    Args:
        problem: The requirements from then on; see `on_the_way`.
        running: Of the group's joints.
        time: On the running motion, at least 0 [s]: now, plus the time until the plan is executed.
        seconds: Time limit [s, wall clock]; short for a budget of as many seconds.
        budget: Limits of work, time and cores. A budget that improves plans from scratch immediately.
        cancel, progress: As for `plan`.

    Raises:
        ShapeError: If the time is before the motion begins, or the motion moves other joints.
        JointNotFound: If the motion lacks a joint of the group.
        ProblemError: If the motion is faster there than the problem allows, or an argument is of the wrong
            kind.
    """
    tracker = BudgetTracker(bounded(budget, seconds), cancel, progress)
    here = on_the_way(problem, running, time)
    try:
        if not tracker.budget.improve and running.duration - time > SHORTEST:
            rest = running.ordered(here.reduced.joint_names).between(time, running.duration)
            found = _from_rest_of_it(here, rest, tracker)
            if found is not None:
                return found
        left = tracker.remaining()
    except Stopped as ended:
        return PlanningWorkspace(here, tracker).result(ENDED[ended.stop], stopped=ended.stop)
    anew = plan(here, budget=left, cancel=cancel, progress=progress)
    tracker.add(anew.counts, anew.cpu_seconds)
    return anew.counted(tracker)


def _from_rest_of_it(here: Problem, rest: Trajectory, tracker: BudgetTracker) -> Result | None:
    method = SpaceTime()
    if here.waypoints or goals_that_move(here) or method.objection(here):
        return None
    first = PlanningWorkspace(here, tracker)
    with tracker.stage("seed"):
        nearest = _nearest_goal(here, rest.positions[-1], first.judge)
    if nearest is None:
        return None
    name, alone, end = nearest
    work = first if alone is here else PlanningWorkspace(alone, tracker)
    motion, proven = _led_to(rest, end), list[Result]()
    program = method.program(alone, with_knots(motion.positions, alone.knots))

    def proves(found: Trajectory) -> bool:
        judged = work.proven(MotionCandidate(Path(found.joint_names, found.positions), found, None))
        proven.extend(() if judged is None else (judged,))
        return judged is not None

    tracker.count(attempts=1)
    for enough, longest, too_short in ((1.0, 1.0, 0.0), (*SLOWER, 1.0)):
        bounds = [share * rest.duration for share in (enough, longest, too_short)]
        try:
            with tracker.optimising(program.counts) as step:
                solved = program.solve_from(
                    motion,
                    enough=bounds[0],
                    longest=bounds[1],
                    too_short=bounds[2],
                    proves=proves,
                    progress=step,
                )
        except Stopped as ended:
            if not proven:
                raise
            # What was proven before the budget ran out, while a shorter one was looked for, is an answer.
            return replace(_won(_soonest(proven), None, name, tracker), stopped=ended.stop)
        tracker.count(qp_solves=solved.qp_solves, qp_iterations=solved.qp_iterations)
        if proven:
            return _won(_soonest(proven), solved, name, tracker)
    return None


def _soonest(proven: list[Result]) -> Result:
    return min(proven, key=lambda each: each.cost)


def _won(proven: Result, solved: SolveResult | None, goal_name: str, tracker: BudgetTracker) -> Result:
    status, steps = (None, 0) if solved is None else (solved.status, len(solved.log))
    won = Attempt(1, SeedKind.RUNNING, Status.SOLVED, status, "", steps, goal_name=goal_name)
    named = replace(proven, solve=solved, goal_name=goal_name, method=SpaceTime.name, because=BECAUSE)
    return replace(named, attempts=(won,), won=won).counted(tracker)


def _nearest_goal(here: Problem, end: Floats, judge: Judge) -> tuple[str, Problem, Floats] | None:
    found = list[tuple[float, str, Problem, Floats]]()
    for name, alone in (here.alternatives or {"": here}).items():
        if all(check.holds for check in judge.check(end, alone.goals)):
            return name, alone, end  # mostly: the running motion leads there
        projected = Projection(alone.reduced, alone.goals, alone.evaluator(alone.reduced))(end[None])
        if projected.violation[0] == 0.0:
            place = projected.positions[0]
            found.append((float(np.abs(place - end).max()), name, alone, place))
    return min(found, key=lambda each: each[0])[1:] if found else None


def _led_to(rest: Trajectory, end: Floats) -> Trajectory:
    if np.array_equal(rest.positions[-1], end):
        return rest
    share = np.linspace(0.0, 1.0, MOMENTS)
    times = rest.duration * share
    bent = (share**2 * (3.0 - 2.0 * share))[:, None] * (end - rest.positions[-1])
    return Trajectory(rest.joint_names, times, rest(times) + bent)
