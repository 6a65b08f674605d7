"""Why there is no motion among dynamic obstacles: the obstructions and their times."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.optimise.kinematics.inverse import STARTS, goal_candidates
from trajopt.optimise.terms.joint_positions import fixed_positions
from trajopt.planning.budget import BudgetTracker
from trajopt.planning.infeasibility.inevitable import (
    INTERVAL,
    FixedLinkMet,
    FixedLinks,
    InTime,
    Occupied,
    Sweep,
    met_words,
)
from trajopt.planning.infeasibility.occupied import Span
from trajopt.planning.infeasibility.reasons import Obstruction, ObstructionKind, resting_hint
from trajopt.planning.judgement import Judged
from trajopt.planning.result import Result
from trajopt.planning.status import Certainty, Status
from trajopt.planning.workspace import PlanningWorkspace
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_length
from trajopt.values.trajectory import Trajectory
from trajopt.verify.certificate import Check, CheckKind

NAMED = 3
"""Things in the way that a sentence names."""


def may_be_inevitable(problem: Problem, static: Result, tracker: BudgetTracker) -> bool:
    return _BlockingObstacles(problem, static.require().trajectory, tracker).may_be_inevitable()


def proof_of_failure(problem: Problem, static: Result, tracker: BudgetTracker) -> Result | None:
    motion = static.require()
    found = _BlockingObstacles(problem, motion.trajectory, tracker).refusal(proven=True)
    if found is None:
        return None
    judged = Judged(problem, motion.trajectory, verified=False)
    return replace(found, path=motion.path, trajectory=motion.trajectory, judged=judged)


def explained(failure: Result, static: Result, tracker: BudgetTracker) -> Result:
    """Return a failure with its obstacles; as inevitable or occupied if all attempts are evidence of that.

    A failure whose reason is known is returned unchanged.
    """
    if failure.status is not Status.BLOCKED_IN_TIME:
        return failure
    obstacles = _BlockingObstacles(failure.problem, static.require().trajectory, tracker)
    found = obstacles.refusal(proven=False)
    resting = resting_hint(failure.problem)
    if found is not None:
        return replace(
            found.planned_as(failure),
            message=found.message + resting,
            remarks=failure.remarks,
            path=failure.path,
            trajectory=failure.trajectory,
            judged=failure.judged,
        )
    blocks = obstacles.on_the_way()
    said = [block.words for block in blocks[:NAMED]]
    said += [f"{len(blocks) - NAMED} more"] * (len(blocks) > NAMED)
    said += [words for words in (obstacles.ends_before(),) if words]
    said += [check.detail for check in _unknown(failure)]
    return replace(failure, blocks=blocks, message=("; ".join(said) or failure.message) + resting)


def _unknown(failure: Result) -> Sequence[Check]:
    certificate = failure.certificate
    failed = () if certificate is None else certificate.failed
    return [check for check in failed if check.kind is CheckKind.PREDICTION]


@dataclass(eq=False)
class _BlockingObstacles:
    problem: Problem
    static: Trajectory
    tracker: BudgetTracker
    _counts: WorkCounts = field(default_factory=WorkCounts)
    _counted: WorkCounts = field(default_factory=WorkCounts)

    def may_be_inevitable(self) -> bool:
        with self.tracker.stage("wait"):
            found = self._in_time.may_be_inevitable(self.static)
        self._count()
        return found

    def refusal(self, *, proven: bool) -> Result | None:
        with self.tracker.stage("proof"):
            sweep, occupied = self._in_time.inevitable(proven=proven), None
            met = self._fixed_links.met(None if proven else self.static.duration) if sweep is None else None
            if sweep is None and met is None:
                goals = self._goals(several=not proven)
                occupied = self._in_time.goal_occupied(goals, proven=proven)
        self._count()
        if sweep is not None:
            return self._result(Status.INEVITABLE, sweep, (_swept(sweep),))
        if met is not None:
            return self._result(Status.FIXED_LINK_MET, met, (_meets(met.span),))
        return (
            None if occupied is None else self._result(Status.GOAL_OCCUPIED, occupied, _occupying(occupied))
        )

    def on_the_way(self) -> tuple[Obstruction, ...]:
        motion = self.static
        times: Floats = np.append(np.arange(0.0, motion.duration, INTERVAL), motion.duration)
        with self.tracker.stage("proof"):
            met = self._in_time.occupancy.met(motion(times), times)
        self._count()
        return tuple(
            Obstruction(
                kind=ObstructionKind.CONTACT,
                subjects=(span.link, span.thing),
                amount=span.depth,
                place=span.worst / motion.duration,
                words=(
                    f"{span.thing} is in the way of the motion without what changes {span.when}: "
                    f"{_how(span)} at {span.worst:.2f} s"
                ),
                begin=span.begin,
                end=span.end,
            )
            for span in met
        )

    def _goals(self, *, several: bool) -> list[Floats]:
        problem = self.problem
        if self._in_time.goal_moves:
            return []
        fixed = fixed_positions(problem.goals, problem.reduced)
        if fixed is not None:
            return [fixed]
        goals = [self.static.positions[-1]]
        if several:
            found = goal_candidates(
                problem.evaluator(problem.reduced, self._counts),
                (*problem.goals, *problem.requirements_at(problem.last_stop)),
                rng=np.random.default_rng(0),
                starts=STARTS,
                effort=problem.limits.effort,
            )
            goals += found.free
        return goals

    def ends_before(self) -> str:
        with self.tracker.stage("proof"):
            spans = self._fixed_links.spans
        self._count()
        return f"a motion has to be over before {met_words(spans[0])}" if spans else ""

    def _result(
        self, status: Status, found: Sweep | Occupied | FixedLinkMet, blocks: tuple[Obstruction, ...]
    ) -> Result:
        certainty = Certainty.PROVEN if found.proven else Certainty.EVIDENCE
        workspace = PlanningWorkspace(self.problem, self.tracker)
        return workspace.result(status, found.words, certainty=certainty, blocks=blocks)

    def _count(self) -> None:
        self.tracker.count_work(self._counts.since(self._counted))
        self._counted = replace(self._counts)

    @cached_property
    def _fixed_links(self) -> FixedLinks:
        return FixedLinks(self._in_time)

    @cached_property
    def _in_time(self) -> InTime:
        timed = self.problem.reduced.timed
        assert timed is not None  # nothing is in the way in time where nothing changes
        return InTime(self.problem, timed, self._counts)


def _how(span: Span) -> str:
    return f"it is {in_length(span.depth)} nearer to {span.link} than it may be"


def _meets(span: Span) -> Obstruction:
    return Obstruction(
        kind=ObstructionKind.CONTACT,
        subjects=(span.link, span.thing),
        amount=span.depth,
        place=None,
        words=met_words(span),
        begin=span.begin,
        end=span.end,
    )


def _swept(sweep: Sweep) -> Obstruction:
    return Obstruction(
        kind=ObstructionKind.CONTACT,
        subjects=(sweep.link, sweep.thing),
        amount=sweep.depth,
        place=0.0,
        words=sweep.words,
        begin=sweep.begin,
        end=sweep.time,
    )


def _occupying(occupied: Occupied) -> tuple[Obstruction, ...]:
    return tuple(
        Obstruction(
            kind=ObstructionKind.CONTACT,
            subjects=(span.link, span.thing),
            amount=span.depth,
            place=1.0,
            words=(f"{span.thing} is at the goal {span.when}: {_how(span)}"),
            begin=span.begin,
            end=span.end,
        )
        for span in occupied.things
    )
