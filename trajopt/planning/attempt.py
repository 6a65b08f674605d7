"""plan_once(problem, seed): one attempt, one step after the other."""

from collections.abc import Sequence
from dataclasses import replace

from trajopt.arrays import Floats, floats, one_of, several
from trajopt.infeasibility import reasons
from trajopt.methods import Method, Program, SupportsEarlyStop, method_of
from trajopt.planning.budget import Budget, BudgetTracker
from trajopt.planning.result import Result
from trajopt.planning.status import Status
from trajopt.planning.workspace import Workspace
from trajopt.problem import Problem
from trajopt.retime import RetimeFailure


def plan_once(
    problem: Problem,
    seed: Floats,
    *,
    method: Method | str | None = None,
    waypoint_knots: Sequence[int] = (),
    program: Program | None = None,
    workspace: Workspace | None = None,
    brief: bool = False,
) -> Result:
    """Plan from one seed: transcribe, solve, retime, verify.

    Args:
        problem: What the motion must achieve, with one goal.
        seed: Knots to start from, shape (N, n) [rad | m].
        method: Transcription and solver, or the name of one; sequential QP over knots when None.
        waypoint_knots: The knot that each waypoint is held at, increasing, neither first nor last.
        program: The problem as the method transcribed it for an earlier seed; transcribed when None.
        workspace: What attempts at this problem share; a new one without bounds when None.
        brief: Whether a few steps are enough, where the method can stop early.

    Returns:
        The motion with its certificate, or why this seed led to none.

    Raises:
        SolverNotFound: If there is no method of that name.
        ProblemError: If a requirement does not fit this robot, or an argument is of the wrong kind.
        ShapeError: If the seed is not of the problem's knots and the group's joints.
        Stopped: If the workspace's budget runs out first.
    """
    work = workspace or Workspace(problem, BudgetTracker(Budget()))
    if program is None:
        one_of("problem", problem, Problem)
        several("waypoint_knots", waypoint_knots, int)
        one_of("brief", brief, bool)
        seed = floats("seed", seed, (problem.knots, len(problem.reduced.joint_names)))
        program = method_of(method).program(problem, seed, waypoint_knots)

    with work.tracker.optimising(program.counts) as step:
        if brief and isinstance(program, SupportsEarlyStop):
            solved = program.solve_briefly(seed, progress=step)
        else:
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
    return result
