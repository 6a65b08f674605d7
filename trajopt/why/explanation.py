"""Outcome, cause, evidence and remedies; and the diagnosis, which does not plan again."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from trajopt.optimise.kinematics.validity import missed_at
from trajopt.optimise.terms.joint_positions import fixed_positions, joint_box
from trajopt.planning.infeasibility.exclusion import conflicting
from trajopt.planning.infeasibility.reasons import (
    Obstruction,
    ObstructionKind,
    blocks_of,
    blocks_of_overloads,
    blocks_on_the_way,
    joint_goal_beyond_limits,
)
from trajopt.planning.result import Attempt, Result
from trajopt.planning.status import Certainty, OutcomeSummary, Status
from trajopt.problem.problem import Problem
from trajopt.robot.joints import LimitKind, joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_joint_position, in_number, in_unit
from trajopt.values.trajectory import Path
from trajopt.verify import Certificate, Judge, Moment
from trajopt.why.change import Remedy, joint_moves
from trajopt.why.nearest import NearestFree, conflict_at_goal, least_missed, nearest_free
from trajopt.why.prices import Price

NAMED = 4
"""Number of obstacles named; the others are counted."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Explanation(OutcomeSummary):
    """Outcome and cause of planning: `print` it, or read its fields.

    Attributes:
        blocks: The obstacles, worst first.
        conflict: A minimal set of requirements that exclude each other: without any one of them the others
            can be met. Empty if no such set was found.
        configuration: The configuration that shows the cause, shape (n,) [rad | m]: the start or goal that is
            not free, the one nearest to the goal, or the worst contact on the path.
        remedies: Changes that make it solvable; None if not searched.
        prices: Costs of active constraints; in seconds only if planned again.
    """

    problem: Problem
    blocks: tuple[Obstruction, ...] = ()
    conflict: tuple[str, ...] = ()
    configuration: Floats | None = None
    nearest_free: NearestFree | None = None
    path: Path | None = None
    attempts: tuple[Attempt, ...] = ()
    remedies: tuple[Remedy, ...] | None = None
    prices: tuple[Price, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data."""
        return {
            **super().as_dict(),
            "blocks": [block.as_dict() for block in self.blocks],
            "conflict": list(self.conflict),
            "joint_names": list(self.problem.reduced.joint_names),
            "configuration": None if self.configuration is None else self.configuration.tolist(),
            "nearest_free": None if self.nearest_free is None else self.nearest_free.as_dict(),
            "tries": [each.as_dict() for each in self.attempts],
            "remedies": None if self.remedies is None else [each.as_dict() for each in self.remedies],
            "prices": [price.as_dict() for price in self.prices],
        }

    def __str__(self) -> str:
        lines = [super().__str__()]
        if self.conflict:
            meets = "meets" if self.certainty is Certainty.PROVEN else "was found that meets"
            lines.append(f"No configuration {meets} all of these; any one fewer can be met:")
            lines += [f"  {item}" for item in self.conflict]
        if self.blocks:
            lines.append("In the way:")
            lines += [f"  {block.words}" for block in self.blocks[:NAMED]]
            if len(self.blocks) > NAMED:
                lines.append(f"  and {len(self.blocks) - NAMED} more")
        if self.status is Status.START_IN_COLLISION and any(map(self._of_links, self.blocks)):
            lines.append(
                "If the links overlap everywhere, disable the pair: `trajopt srdf` finds such pairs."
            )
        if self.nearest_free is not None:
            lines.append(self._nearest(self.nearest_free))
        if self.remedies is not None and not self.remedies:
            lines.append("No single change of those that were tried makes it solvable.")
        if self.remedies:
            lines.append("Each of these makes it solvable, and half of it does not:")
            lines += [f"  {remedy}" for remedy in self.remedies]
        if self.prices:
            lines.append("What the active constraints cost, which would be saved if one gave way by a unit:")
            lines += [f"  {price}" for price in self.prices]
        return "\n".join(lines)

    def _of_links(self, block: Obstruction) -> bool:
        links = self.problem.scene.robot.links
        return block.kind is ObstructionKind.CONTACT and all(owner in links for owner in block.subjects)

    def _nearest(self, free: NearestFree) -> str:
        problem, joints = self.problem, self.problem.reduced.joint_names
        units = [joint_unit(problem.scene.robot.model, joint) for joint in joints]
        weak = self.status in (Status.START_CANNOT_BE_HELD, Status.GOAL_CANNOT_BE_HELD)
        able = "can be held" if weak else "is free"
        if free.given > 0.0:
            where = ", ".join(in_unit(float(q), unit) for q, unit in zip(free.positions, units, strict=True))
            required = (*problem.goals, *problem.requirements_at(problem.last_stop))
            miss = missed_at(problem.reduced, required, free.positions)
            return f"The nearest that {able} misses the goal by {miss}: ({where})"
        return f"The nearest that {able}: {joint_moves(problem, free.moved)}"


AT_THE_MIDDLE = (
    Status.GOAL_IN_COLLISION,
    Status.GOAL_OUT_OF_LIMITS,
    Status.GOAL_CANNOT_BE_HELD,
    Status.GOAL_BREAKS_CONSTRAINT,
)
"""Reasons to refuse the middle of a goal of all joints."""
PRESSED = 1e-3
"""A joint this near to its limit counts as at its limit [rad | m]."""


def diagnose(result: Result) -> Explanation:
    return _BY_STATUS.get(result.status, _of_the_way)(result)


def _explained(
    result: Result,
    grounds: str,
    *,
    blocks: tuple[Obstruction, ...] = (),
    conflict: tuple[str, ...] = (),
    configuration: Floats | None = None,
    nearest: NearestFree | None = None,
) -> Explanation:
    return Explanation(
        problem=result.problem,
        status=result.status,
        reason=result.reason,
        certainty=result.certainty,
        grounds=grounds,
        blocks=blocks,
        conflict=conflict,
        configuration=configuration,
        nearest_free=nearest,
        path=result.path,
        attempts=result.attempts,
    )


def _of_seeds(result: Result) -> str:
    return f", of {in_number(result.attempts, 'seed')}" if result.attempts else ""


_JUDGED = "the judge recomputed everything from the motion alone"
_BEFOREHAND = "the method said so before anything began"
_IN_TIME = (
    "the motion planned without what changes was looked at every 20 ms, and other ways were tried in vain"
)
_GROUNDS = {
    Status.SOLVED: (_JUDGED, _JUDGED),
    Status.METHOD_CANNOT: (_BEFOREHAND, _BEFOREHAND),
    Status.START_TOO_FAST: (
        "the start and how hard the joints' own limits let them brake decide this",
        "configurations that may be reached by then were drawn at random",
    ),
    Status.INEVITABLE: (
        "each joint's own limits bound where it can be by then, and boxes that cover all of that were "
        "closed with depths that the judge measured",
        "configurations that may be reached by then were drawn at random; others may be clear",
    ),
    Status.FIXED_LINK_MET: (
        "the two are as near to each other whatever the joints do, the judge measured how near, and by "
        "their own limits the joints are not all at the goal before",
        "the motion planned without what changes takes longer; another may be over before",
    ),
    Status.GOAL_OCCUPIED: (
        "all of the goal was closed, at all times at which the arm could be there, by boxes that cover it",
        "the goal configurations that were found were looked at every 20 ms; others may be free",
    ),
    Status.BLOCKED_IN_TIME: (_IN_TIME, _IN_TIME),
}
"""Grounds of statuses with obstructions that the planner found, or none: proven, and as evidence."""


def _found_by_planner(result: Result) -> Explanation:
    """Explain by the obstructions that the planner found, if any."""
    at = None
    if result.status in (Status.INEVITABLE, Status.FIXED_LINK_MET):
        at = result.problem.reduced.start_positions
    elif result.status is Status.GOAL_OCCUPIED and result.trajectory is not None:
        at = result.trajectory.positions[-1]
    grounds = _GROUNDS[result.status][result.certainty is not Certainty.PROVEN]
    return _explained(result, grounds, blocks=result.blocks, configuration=at)


def _too_late(result: Result) -> Explanation:
    if result.certainty is Certainty.PROVEN:
        return _explained(result, "the limits of the joints alone bound how soon any motion can be over")
    return _explained(result, f"no sooner motion was found{_of_seeds(result)}")


def _start(result: Result) -> Explanation:
    return _end(result, result.problem.reduced.start_positions, Moment.START)


def _never_apart(result: Result) -> Explanation:
    start = result.problem.reduced.start_positions
    blocks = blocks_of(Judge(result.problem.reduced).examine(start, moment=Moment.START))
    grounds = f"{result.message}: boxes that cover all positions of the joints between were closed one by one"
    return _explained(result, grounds, blocks=blocks, configuration=start)


def _goal(result: Result) -> Explanation:
    problem = result.problem
    goal = fixed_positions(problem.goals, problem.reduced)
    beyond = joint_goal_beyond_limits(problem)
    if goal is not None and (beyond or result.status in AT_THE_MIDDLE):
        return _end(result, goal, Moment.END)
    if beyond:
        grounds = "no position within the limits is within the goal's tolerance"
        return _explained(result, grounds, blocks=beyond)
    return _searched_goal(result)


def _end(result: Result, positions: Floats, moment: Moment) -> Explanation:
    problem = result.problem
    judge = Judge(problem.reduced)
    blocks = blocks_of(judge.examine(positions, moment=moment))
    if not blocks:
        blocks = blocks_of_overloads(judge.overloads(positions, limits=problem.limits))
    if not blocks:
        kind, words = ObstructionKind.REQUIREMENT, result.message
        blocks = (Obstruction(kind=kind, subjects=(words,), amount=0.0, place=None, words=words),)
    proven = result.certainty is Certainty.PROVEN
    grounds = "it was measured at exactly that configuration"
    lower, upper = joint_box(problem.goals, problem.reduced)
    alone = moment is Moment.START or not (lower < upper).any()
    if not proven and alone:
        grounds += ", but by less than the distance may err"
    elif not proven:
        grounds = f"{result.message}; other configurations may be free"
    elif moment is Moment.END:
        grounds += ", and nothing within the goal's tolerance can differ enough"
    return _explained(
        result,
        grounds,
        blocks=blocks,
        configuration=positions,
        nearest=nearest_free(problem, positions, moment),
    )


def _searched_goal(result: Result) -> Explanation:
    problem, reduced = result.problem, result.problem.reduced
    always = problem.requirements_at(problem.last_stop)
    wanted = (*problem.goals, *always)
    touching = least_missed(problem, problem.goals, hard=always, clear=False)
    free = least_missed(problem, problem.goals, hard=always)
    blocks: tuple[Obstruction, ...] = ()
    judge = Judge(reduced)
    if touching is not None:
        blocks = (
            *_pressed(reduced, touching, result.status),
            *blocks_of(judge.examine(touching.positions, moment=Moment.END)),
            *blocks_of_overloads(judge.overloads(touching.positions, limits=problem.limits), "at the goal"),
        )
    if result.status in (Status.GOAL_IN_COLLISION, Status.GOAL_CANNOT_BE_HELD):
        conflict = conflict_at_goal(problem, blocks)
    else:
        clash = conflicting(problem.evaluator(reduced), wanted, rng=np.random.default_rng(0))
        conflict = tuple(str(item) for item in clash)
    proven = result.certainty is Certainty.PROVEN
    grounds = result.message if proven else f"{result.message}; other configurations may exist"
    return _explained(
        result,
        grounds,
        blocks=blocks,
        conflict=conflict if len(conflict) > 1 else (),
        configuration=None if touching is None else touching.positions,
        nearest=free,
    )


def _pressed(reduced: ReducedModel, nearest: NearestFree, status: Status) -> tuple[Obstruction, ...]:
    if status in (Status.GOAL_IN_COLLISION, Status.GOAL_CANNOT_BE_HELD):
        return ()
    limits, blocks = reduced.limits, list[Obstruction]()
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
                kind = ObstructionKind.JOINT_LIMIT
                blocks.append(Obstruction(kind=kind, subjects=(name,), amount=0.0, place=None, words=words))
    return tuple(blocks)


def _walled_in(result: Result) -> Explanation:
    grounds = f"{result.message}: boxes that cover all such configurations were closed one by one"
    return _explained(result, grounds, blocks=_way_blocks(result), configuration=_worst(result))


def _of_the_way(result: Result) -> Explanation:
    """Explain why no path was found, by the block of each seed."""
    tried: dict[str, int] = {}
    for each in result.attempts:
        what = each.status.name if each.block is None else " and ".join(each.block.subjects)
        tried[what] = tried.get(what, 0) + 1
    ranked = sorted(tried, key=lambda what: -tried[what])
    stopped = ", ".join(f"{tried[what]} by {what}" for what in ranked[:4])
    grounds = f"of {in_number(result.attempts, 'seed')} none led to a plan: {stopped} were blocked"
    if not result.attempts:
        grounds = result.message
    return _explained(result, grounds, blocks=_way_blocks(result), configuration=_worst(result))


def _way_blocks(result: Result) -> tuple[Obstruction, ...]:
    if result.solve is None:
        return ()
    return blocks_on_the_way(result.problem, result.solve)


def _worst(result: Result) -> Floats | None:
    blocks = _way_blocks(result)
    if result.path is None or not blocks or blocks[0].place is None:
        return None
    knots = result.path.knots
    at = blocks[0].place * (len(knots) - 1)
    first = min(int(at), len(knots) - 2)
    return knots[first] + (at - first) * (knots[first + 1] - knots[first])


def _timing(result: Result) -> Explanation:
    problem = result.problem
    if result.path is None:
        return _of_the_way(result)
    judge = Judge(problem.reduced)
    weak = [(judge.overloads(knot, limits=problem.limits), knot) for knot in result.path.knots]
    worst = max(weak, key=lambda item: max((each.excess for each in item[0]), default=-np.inf))
    grounds = f"{result.message} on every path found{_of_seeds(result)}"
    return _explained(
        result,
        grounds,
        blocks=blocks_of_overloads(worst[0]),
        configuration=worst[1] if worst[0] else None,
    )


def _refused(result: Result) -> Explanation:
    certificate = result.certificate
    assert isinstance(certificate, Certificate)
    blocks = tuple(
        Obstruction(
            kind=ObstructionKind.REQUIREMENT,
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
    grounds = f"the judge refused the motion that came nearest{_of_seeds(result)}"
    return _explained(result, grounds, blocks=blocks, configuration=at)


_BY_STATUS: Mapping[Status, Callable[[Result], Explanation]] = {
    **dict.fromkeys(_GROUNDS, _found_by_planner),
    Status.START_IN_COLLISION: _start,
    Status.CLEARANCE_IMPOSSIBLE: _never_apart,
    Status.START_OUT_OF_LIMITS: _start,
    Status.START_BREAKS_CONSTRAINT: _start,
    Status.START_CANNOT_BE_HELD: _start,
    Status.GOAL_IN_COLLISION: _goal,
    Status.GOAL_OUT_OF_LIMITS: _goal,
    Status.GOAL_BREAKS_CONSTRAINT: _goal,
    Status.GOAL_CANNOT_BE_HELD: _goal,
    Status.NO_INVERSE_KINEMATICS: _goal,
    Status.CONFLICTING_CONSTRAINTS: _goal,
    Status.TOO_LATE: _too_late,
    Status.PROVEN_INFEASIBLE: _walled_in,
    Status.NO_TIMING: _timing,
    Status.NOT_VERIFIED: _refused,
}
"""The function that explains each status; the others are explained by the blocks of the path."""
