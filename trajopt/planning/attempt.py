"""plan_once(problem, seed): one attempt."""

from collections.abc import Sequence
from dataclasses import replace

from trajopt.optimise.methods import Method, Program, SupportsEffort, SupportsImprovement, choose
from trajopt.optimise.solvers import Effort, SolveResult
from trajopt.planning.budget import Budget, BudgetTracker, Stopped
from trajopt.planning.infeasibility import reasons
from trajopt.planning.moving.space_time_attempts import BestMotion
from trajopt.planning.result import Result
from trajopt.planning.status import Status
from trajopt.planning.workspace import PlanningWorkspace
from trajopt.problem.problem import Problem
from trajopt.timing import RetimeFailure
from trajopt.values.arrays import Floats, floats, several
from trajopt.values.errors.arguments import check_arguments
from trajopt.values.trajectory import Trajectory


def plan_once(
    problem: Problem,
    seed: Floats,
    *,
    method: Method | str | None = None,
    waypoint_knots: Sequence[int] = (),
    program: Program | None = None,
    workspace: PlanningWorkspace | None = None,
    effort: Effort = Effort.FULL,
) -> Result:
    """Plan from one seed: transcribe, solve, retime, verify.

    Args:
        problem: With one goal.
        seed: Knots to start from, shape (N, n) [rad | m].
        method: A method or its name; when None sequential QP over knots, or for a start in motion the method
            that supports it.
        waypoint_knots: The knot of each waypoint, increasing, neither first nor last.
        program: The problem as transcribed by the method for an earlier seed; transcribed when None.
        workspace: Shared by attempts at this problem; without bounds when None.
        effort: Work to do for this seed, if the method can do less.

    Returns:
        The motion with its certificate, or why this seed led to none.

    Raises:
        SolverNotFound: If the method's name is unknown.
        ProblemError: If a requirement does not fit this robot, or an argument is of the wrong kind.
        ShapeError: If the seed does not fit the problem's knots and the group's joints.
        Stopped: If the workspace's budget runs out first.
    """
    check_arguments(plan_once, locals())
    work = workspace or PlanningWorkspace(problem, BudgetTracker(Budget()))
    if program is None:
        several("waypoint_knots", waypoint_knots, int)
        seed = floats("seed", seed, (problem.knots, len(problem.reduced.joint_names)))
        program = choose(problem, method).method.program(problem, seed, waypoint_knots)

    if effort is not Effort.FULL and isinstance(program, SupportsEffort):
        program = program.with_effort(effort)
    with work.tracker.optimising(program.counts) as step:
        solved = program.solve(seed, progress=step)
    work.tracker.count(attempts=1, qp_solves=solved.qp_solves, qp_iterations=solved.qp_iterations)

    decoded = program.decode(solved)
    result = work.result(Status.STUCK, solve=solved, path=decoded[0].path)
    if not solved.feasible:
        return replace(result, message=reasons.stuck(problem, solved))

    for motion in work.timed(decoded):
        if isinstance(motion, RetimeFailure):
            return replace(result, status=Status.NO_TIMING, message=motion.reason)
        result = work.judged(motion, solved)
        if result.verified:
            break
    if isinstance(program, SupportsImprovement) and result.trajectory is not None:
        return _improved(result, solved, result.trajectory, program, work)
    return result


def _improved(
    result: Result,
    solved: SolveResult,
    motion: Trajectory,
    program: SupportsImprovement,
    work: PlanningWorkspace,
) -> Result:
    along_path = motion.duration if result.verified else None
    result = replace(result, along_path=along_path)
    try:
        with work.tracker.optimising(program.counts) as step:
            freed = program.improve(solved, motion, progress=step)
        work.tracker.count(qp_solves=freed.qp_solves, qp_iterations=freed.qp_iterations)
        whole = replace(freed, log=(*solved.log, *freed.log))
        if not freed.feasible:
            # A path that was timed from rest was only where the program began, if the start is in motion.
            if result.verified or result.timed is None:
                return result
            words = reasons.stuck(work.problem, whole)
            return work.result(Status.STUCK, words, solve=whole, path=result.path)
        for faster in work.timed(program.decode(freed)):
            if isinstance(faster, RetimeFailure):
                break
            better = replace(work.judged(faster, whole), along_path=along_path)
            best = BestMotion(result)
            best.learn(better)
            if best.result is better:
                return better
    except Stopped as ended:
        if not result.verified:
            raise
        return replace(result, stopped=ended.stop)
    return result
