"""Diagnosis: what stands in the way of a plan, and how well that is known; without planning again."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from trajopt.arrays import Floats
from trajopt.explanation.explanation import Explanation
from trajopt.explanation.nearest import NearestFree, conflict_at_goal, least_missed, nearest_free
from trajopt.infeasibility.chain import Chain
from trajopt.infeasibility.exclusion import conflicting
from trajopt.infeasibility.reasons import (
    Block,
    BlockKind,
    blocks_of,
    blocks_on_the_way,
    joint_goal_beyond_limits,
)
from trajopt.model.description.pinocchio_model import effort_unit, joint_unit
from trajopt.model.limits import LimitKind
from trajopt.model.payload import loaded_model
from trajopt.model.printed import in_joint_position
from trajopt.model.reduced import ReducedModel
from trajopt.planning.result import Result
from trajopt.planning.status import Certainty, Status
from trajopt.problem import Problem
from trajopt.query import Counts
from trajopt.query.dynamics import DynamicsQuery
from trajopt.terms.joint_positions import fixed_positions, joint_box
from trajopt.transcription import goal_centre
from trajopt.verify import Certificate, Moment, examine

AT_THE_MIDDLE = (Status.GOAL_IN_COLLISION, Status.GOAL_OUT_OF_LIMITS, Status.GOAL_BREAKS_CONSTRAINT)
"""What the middle of a goal of all joints is refused for."""
PRESSED = 1e-3
"""A joint this near to its limit presses against it [rad | m]."""


def diagnose(result: Result) -> Explanation:
    """Return what stands in the way of a plan of one goal; remedies and prices are left to others."""
    return _BY_STATUS.get(result.status, _of_the_way)(result)


def _plain(result: Result, grounds: str, certainty: Certainty | None = None) -> Explanation:
    """Say how planning ended; as certain as where that was shown, unless it is shown here."""
    return Explanation(
        problem=result.problem,
        status=result.status,
        reason=result.reason,
        certainty=result.certainty if certainty is None else certainty,
        grounds=grounds,
        path=result.path,
        attempts=result.attempts,
    )


def _solved(result: Result) -> Explanation:
    return _plain(result, "the judge recomputed everything from the motion alone")


def _cannot(result: Result) -> Explanation:
    return _plain(result, "the method was asked before anything began")


def _start(result: Result) -> Explanation:
    return _end(result, result.problem.reduced.start_positions, Moment.START)


def _goal(result: Result) -> Explanation:
    problem = result.problem
    goal = fixed_positions(problem.goals, problem.reduced)
    beyond = joint_goal_beyond_limits(problem)
    if goal is not None and (beyond or result.status in AT_THE_MIDDLE):
        return _end(result, goal, Moment.END)
    if beyond:
        grounds = "no position within the limits is within the goal's tolerance"
        return _with(_plain(result, grounds), blocks=beyond)
    return _searched_goal(result)


def _end(result: Result, positions: Floats, moment: Moment) -> Explanation:
    """Explain a start or goal of joints that is not free: the judge has measured it."""
    problem = result.problem
    blocks = blocks_of(examine(problem.reduced, positions, moment=moment))
    if not blocks:
        kind, words = BlockKind.REQUIREMENT, result.message
        blocks = (Block(kind=kind, subjects=(words,), amount=0.0, place=None, words=words),)
    proven = result.certainty is Certainty.PROVEN
    grounds = "it was measured at that very configuration"
    lower, upper = joint_box(problem.goals, problem.reduced)
    alone = moment is Moment.START or not (lower < upper).any()
    if not proven and alone:
        grounds += ", but by less than the distance may err"
    elif not proven:
        grounds = f"{result.message}; other configurations may be free"
    elif moment is Moment.END:
        grounds += ", and nothing within the goal's tolerance can differ enough"
    return _with(
        _plain(result, grounds),
        blocks=blocks,
        configuration=positions,
        nearest=nearest_free(problem, positions, moment),
    )


def _searched_goal(result: Result) -> Explanation:
    """Explain a goal that no free configuration was found for."""
    problem, reduced = result.problem, result.problem.reduced
    always = problem.requirements_at(problem.last_stop)
    wanted = (*problem.goals, *always)
    touching = least_missed(problem, problem.goals, hard=always, clear=False)
    free = least_missed(problem, problem.goals, hard=always)
    blocks: tuple[Block, ...] = ()
    if touching is not None:
        blocks = (
            *_pressed(reduced, touching, result.status),
            *blocks_of(examine(reduced, touching.positions, moment=Moment.END)),
        )
    if result.status is Status.GOAL_IN_COLLISION:
        conflict = conflict_at_goal(problem, blocks)
    else:
        clash = conflicting(reduced, wanted, rng=np.random.default_rng(0), counts=Counts())
        conflict = tuple(str(item) for item in clash)
    proven = result.certainty is Certainty.PROVEN
    grounds = result.message if proven else f"{result.message}; other configurations may exist"
    return _with(
        _plain(result, grounds),
        blocks=blocks,
        conflict=conflict if len(conflict) > 1 else (),
        configuration=None if touching is None else touching.positions,
        nearest=free,
    )


def _pressed(reduced: ReducedModel, nearest: NearestFree, status: Status) -> tuple[Block, ...]:
    """Return the joint limits that the configuration nearest to an unreachable goal presses against."""
    if status is Status.GOAL_IN_COLLISION:
        return ()
    limits, blocks = reduced.limits, list[Block]()
    for place, name in enumerate(reduced.joint_names):
        at = float(nearest.positions[place])
        for side, limit in (
            (LimitKind.LOWER, limits.lower[place]),
            (LimitKind.UPPER, limits.upper[place]),
        ):
            if abs(at - limit) <= PRESSED:
                bound = in_joint_position(float(limit), joint_unit(reduced.scene.robot.model, name))
                words = f"{name} is at its {side.value} limit of {bound}{limits.because(name, side)} "
                words += "where the goal is missed least"
                kind = BlockKind.JOINT_LIMIT
                blocks.append(Block(kind=kind, subjects=(name,), amount=0.0, place=None, words=words))
    return tuple(blocks)


def _walled_in(result: Result) -> Explanation:
    grounds = f"{result.message}: boxes that cover all such configurations were closed one by one"
    return _with(_plain(result, grounds), blocks=_way_blocks(result), configuration=_worst(result))


def _of_the_way(result: Result) -> Explanation:
    """Explain why no path was found: what blocked each first guess."""
    tried: dict[str, int] = {}
    for each in result.attempts:
        what = each.status.name if each.block is None else " and ".join(each.block.subjects)
        tried[what] = tried.get(what, 0) + 1
    ranked = sorted(tried, key=lambda what: -tried[what])
    stopped = ", ".join(f"{tried[what]} by {what}" for what in ranked[:4])
    grounds = f"of {len(result.attempts)} seeds none led to a plan: {stopped} were blocked"
    if not result.attempts:
        grounds = result.message
    return _with(_plain(result, grounds), blocks=_way_blocks(result), configuration=_worst(result))


def _way_blocks(result: Result) -> tuple[Block, ...]:
    if result.solve is None:
        return ()
    return blocks_on_the_way(result.problem, result.solve)


def _worst(result: Result) -> Floats | None:
    """Return the configuration of the path at which the worst thing stands in the way."""
    blocks = _way_blocks(result)
    if result.path is None or not blocks or blocks[0].place is None:
        return None
    knots = result.path.knots
    at = blocks[0].place * (len(knots) - 1)
    first = min(int(at), len(knots) - 2)
    return knots[first] + (at - first) * (knots[first + 1] - knots[first])


def _timing(result: Result) -> Explanation:
    """Explain a path that no timing cures: a proof where the start or a goal of joints cannot be held."""
    problem = result.problem
    start, goal = problem.reduced.start_positions, goal_centre(problem)
    lower, upper = joint_box(problem.goals, problem.reduced)
    room = np.maximum(upper - lower, 0.0)  # more than half of it: the middle may lie at its edge
    for positions, name, moved in ((start, "start", 0.0 * start), (goal, "goal", room)):
        blocks = () if positions is None else overloaded(problem, positions)
        if blocks and blocks[0].amount > largest_change(problem, moved):
            grounds = f"the {name} itself cannot be held at rest: {blocks[0].words}"
            plain = _plain(result, grounds, Certainty.PROVEN)
            return _with(plain, blocks=blocks, configuration=positions)
    if result.path is None:
        return _of_the_way(result)
    worst = max(
        (item for knot in result.path.knots for item in [(overloaded(problem, knot), knot)] if item[0]),
        key=lambda item: item[0][0].amount,
        default=((), None),
    )
    grounds = f"{result.message} on every path found, of {len(result.attempts)} seeds"
    return _with(_plain(result, grounds), blocks=worst[0], configuration=worst[1])


def _refused(result: Result) -> Explanation:
    """Explain a motion that the judge refused."""
    certificate = result.certificate
    assert isinstance(certificate, Certificate)
    blocks = tuple(
        Block(
            kind=BlockKind.REQUIREMENT,
            subjects=(check.subject or check.name,),
            amount=abs(check.slack or 0.0),
            place=None
            if check.time is None or result.trajectory is None
            else check.time / result.trajectory.duration,
            words=f"{check.name}: {check.detail}",
        )
        for check in certificate.failed
    )
    at = None
    if blocks and blocks[0].place is not None and result.trajectory is not None:
        at = result.trajectory(blocks[0].place * result.trajectory.duration)
    grounds = f"the judge refused the motion that came nearest, of {len(result.attempts)} seeds"
    return _with(_plain(result, grounds), blocks=blocks, configuration=at)


def _with(
    plain: Explanation,
    *,
    blocks: tuple[Block, ...],
    conflict: tuple[str, ...] = (),
    configuration: Floats | None = None,
    nearest: NearestFree | None = None,
) -> Explanation:
    return replace(plain, blocks=blocks, conflict=conflict, configuration=configuration, nearest_free=nearest)


def overloaded(problem: Problem, positions: Floats) -> tuple[Block, ...]:
    """Return the joints whose effort limit is less than what holding still takes, the worst first.

    Args:
        problem: The problem; gives the load and the limits.
        positions: Of the group's joints, shape (n,) [rad | m].
    """
    reduced, limits = problem.reduced, problem.limits
    loaded = replace(reduced, model=loaded_model(reduced))
    still = np.zeros((1, len(positions)))
    need = np.abs(DynamicsQuery(loaded).torque(positions[None], still, still)[0])
    excess = need - limits.effort

    def unit(joint: int) -> str:
        return effort_unit(reduced.scene.robot.model, reduced.joint_names[joint])

    return tuple(
        Block(
            kind=BlockKind.EFFORT,
            subjects=(reduced.joint_names[joint],),
            amount=float(excess[joint]),
            place=None,
            words=(
                f"{reduced.joint_names[joint]} needs {need[joint]:.4g} {unit(joint)} to hold still, its "
                f"effort limit is {limits.effort[joint]:.4g} {unit(joint)}"
            ),
        )
        for joint in map(int, np.argsort(-excess))
        if excess[joint] > 0.0
    )


def largest_change(problem: Problem, half: Floats) -> float:
    """Bound how much what it takes to hold still differs near a configuration, for any joint [Nm | N].

    A joint that turns by an angle changes the torque of another by no more than the angle times all weight
    times its largest lever.

    Args:
        problem: The problem; gives the load.
        half: How far each of the group's joints may be from where it was looked at, shape (n,) [rad | m].
    """
    reduced, chain = problem.reduced, Chain(problem.reduced)
    model = loaded_model(reduced)
    weight = float(np.linalg.norm(model.gravity.linear))
    levers = (
        model.inertias[joint].mass
        * max(1.0, chain.longest(chain.joints(joint)[0], joint, model.inertias[joint].lever))
        for joint in range(1, model.njoints)
    )
    moved = np.abs(reduced.mimic_matrix)
    return float(weight * sum(levers) * moved.sum(axis=0).max() * (moved @ half).sum())


_BY_STATUS: Mapping[Status, Callable[[Result], Explanation]] = {
    Status.SOLVED: _solved,
    Status.START_IN_COLLISION: _start,
    Status.START_OUT_OF_LIMITS: _start,
    Status.START_BREAKS_CONSTRAINT: _start,
    Status.GOAL_IN_COLLISION: _goal,
    Status.GOAL_OUT_OF_LIMITS: _goal,
    Status.GOAL_BREAKS_CONSTRAINT: _goal,
    Status.NO_INVERSE_KINEMATICS: _goal,
    Status.CONFLICTING_CONSTRAINTS: _goal,
    Status.METHOD_CANNOT: _cannot,
    Status.PROVEN_INFEASIBLE: _walled_in,
    Status.NO_TIMING: _timing,
    Status.NOT_VERIFIED: _refused,
}
"""What explains each status; all others are explained by what blocked the way."""
