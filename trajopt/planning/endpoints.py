"""Whether a motion can begin and end as required, and at which configurations."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.optimise.kinematics.inverse import MANY_STARTS, STARTS, GoalCandidates, goal_candidates, is_one
from trajopt.optimise.kinematics.validity import missed_at
from trajopt.optimise.terms import constrain
from trajopt.optimise.terms.joint_positions import fixed_positions, joint_box, without_followers
from trajopt.optimise.transcription import fixed_goal, goal_centre
from trajopt.planning.infeasibility import (
    box_breaks,
    box_collides,
    box_overloads,
    exclusion,
    never_apart,
    out_of_reach,
    reasons,
    too_fast,
    too_late,
)
from trajopt.planning.infeasibility.exclusion import conflicting
from trajopt.planning.infeasibility.reasons import resting_hint
from trajopt.planning.result import Result
from trajopt.planning.seeds import choose_waypoints
from trajopt.planning.status import Certainty, Status
from trajopt.planning.workspace import PlanningWorkspace
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import JointPositions, Requirement
from trajopt.problem.residual import WHOLE
from trajopt.robot.joints import EXCESS
from trajopt.values.arrays import Floats
from trajopt.verify import Examination, Moment


@dataclass(frozen=True, eq=False)
class EndpointChecks:
    """Checks the ends of a problem's motion, and its waypoints."""

    workspace: PlanningWorkspace

    def start(self) -> Result | None:
        """Refuse a start that no motion can leave."""
        seen = self.workspace.judge.examine(self._start, moment=Moment.START)
        refusal = self._refuse(seen, Status.START_OUT_OF_LIMITS, Status.START_IN_COLLISION)
        fast = "" if refusal is not None else too_fast(self.workspace.problem)
        if fast:
            return self.workspace.result(Status.START_TOO_FAST, fast, certainty=Certainty.PROVEN)
        if refusal is None and not self.workspace.problem.starts_moving:
            refusal = self._unheld(self._start, Status.START_CANNOT_BE_HELD, "at the start")
        late = "" if refusal is not None else too_late(self.workspace.problem)
        if late:
            return self.workspace.result(Status.TOO_LATE, late, certainty=Certainty.PROVEN)
        broken = self._broken(self._start, 0)
        if refusal is None and broken:
            refusal = self.workspace.result(Status.START_BREAKS_CONSTRAINT, broken)
        if refusal is None:
            return None
        if refusal.status is Status.START_IN_COLLISION:
            resting = resting_hint(self.workspace.problem)
            refusal = self._never_apart(seen) or replace(refusal, message=refusal.message + resting)
        proven = seen.clear or seen.proven
        if refusal.status is Status.START_CANNOT_BE_HELD:
            proven = box_overloads(self.workspace.problem, self._start, self._start)
        return replace(refusal, certainty=Certainty.PROVEN if proven else Certainty.EVIDENCE)

    def goals(self, rng: np.random.Generator) -> Sequence[Floats] | Result:
        """Return goal configurations, or why there are none.

        For goals of all joints the middle comes first, others within the tolerances only if these leave room
        or the middle is refused; all others come nearest first.
        """
        work, problem = self.workspace, self.workspace.problem
        impossible = self._joint_goals_impossible()
        if impossible is not None:
            return impossible
        middle = goal_centre(problem)
        refusal = None if middle is None else self._middle_refused(middle)
        if middle is not None and refusal is None and fixed_goal(problem) is not None:
            return (middle,)
        if refusal is not None and (refusal.certainty is Certainty.PROVEN or not self._has_tolerance):
            return refusal
        first = () if middle is None or refusal is not None else (middle,)
        counts = WorkCounts()
        try:
            found = self._candidates(rng, counts)
            if found.free or first:
                return (*first, *found.free)
            if refusal is not None:
                return replace(refusal, message=reasons.nowhere_within(refusal.message))
            if found.overloaded:
                least = work.judge.overloads(found.overloaded[0], limits=problem.limits)
                words = reasons.none_can_be_held(len(found.overloaded), least)
                return work.result(Status.GOAL_CANNOT_BE_HELD, words)
            if found.blocking is not None:
                words = reasons.no_goal_configuration(work.problem.reduced, found, self._wanted)
                return work.result(Status.GOAL_IN_COLLISION, words)
            return self._out_of_reach(rng, counts, found)
        finally:
            work.tracker.count_work(counts)

    def more_goals(self, rng: np.random.Generator) -> Sequence[Floats]:
        """Return goal configurations of a longer search, nearest first."""
        if self._is_one:
            return ()
        counts = WorkCounts()
        try:
            return self._search(MANY_STARTS, rng, counts).free
        finally:
            self.workspace.tracker.count_work(counts)

    def _candidates(self, rng: np.random.Generator, counts: WorkCounts) -> GoalCandidates:
        found = self._search(STARTS, rng, counts)
        nothing = not found.free and not found.overloaded and found.blocking is None
        if not nothing or self._is_one or self._proofs:
            return found
        return self._search(MANY_STARTS, rng, counts)

    def _search(self, starts: int, rng: np.random.Generator, counts: WorkCounts) -> GoalCandidates:
        work = self.workspace
        return goal_candidates(
            work.problem.evaluator(work.problem.reduced, counts),
            self._wanted,
            rng=rng,
            starts=starts,
            effort=work.problem.limits.effort,
            check=lambda: work.tracker.check(counts),
        )

    def _out_of_reach(self, rng: np.random.Generator, counts: WorkCounts, found: GoalCandidates) -> Result:
        work = self.workspace
        if self._proofs:
            status, words = self._proofs[0]
            return work.result(status, words, certainty=Certainty.PROVEN)
        clash = conflicting(work.problem.evaluator(work.problem.reduced, counts), self._wanted, rng=rng)
        status = Status.CONFLICTING_CONSTRAINTS if len(clash) > 1 else Status.NO_INVERSE_KINEMATICS
        words = reasons.unreachable(work.problem.reduced, clash, found.nearest, self._wanted)
        return work.result(status, words)

    @cached_property
    def _proofs(self) -> tuple[tuple[Status, str], ...]:
        reduced = self.workspace.problem.reduced
        far = (out_of_reach(item, reduced) for item in self._wanted)
        clash = (
            f"{first} and {second} exclude each other: {words}"
            for first, second in combinations(self._wanted, 2)
            if (words := exclusion(first, second, reduced))
        )
        return (
            *((Status.NO_INVERSE_KINEMATICS, words) for words in far if words),
            *((Status.CONFLICTING_CONSTRAINTS, words) for words in clash),
        )

    def _joint_goals_impossible(self) -> Result | None:
        result, problem = self.workspace.result, self.workspace.problem
        beyond = reasons.joint_goal_beyond_limits(problem)
        if beyond:
            words = "; ".join(block.words for block in beyond)
            asked = fixed_positions(problem.goals, problem.reduced)
            if asked is not None:
                seen = self.workspace.judge.examine(asked, moment=Moment.END)
                words = reasons.out_of_limits(seen) or words
            return result(Status.GOAL_OUT_OF_LIMITS, words, certainty=Certainty.PROVEN)
        stated = without_followers(problem.goals, problem.reduced)
        joints = [item for item in stated if isinstance(item, JointPositions)]
        for first, second in combinations(joints, 2):
            words = exclusion(first, second, problem.reduced)
            if words:
                words += "; any_of takes either of several goals"
                words = f"{first} and {second} exclude each other: {words}"
                return result(Status.CONFLICTING_CONSTRAINTS, words, certainty=Certainty.PROVEN)
        return None

    def _middle_refused(self, middle: Floats) -> Result | None:
        problem = self.workspace.problem
        lower, upper = joint_box(problem.goals, problem.reduced)
        seen = self.workspace.judge.examine(middle, moment=Moment.END)
        broken = self._broken(middle, self._last_stop)
        refusal = self._refuse(seen, Status.GOAL_OUT_OF_LIMITS, Status.GOAL_IN_COLLISION)
        if refusal is None:
            refusal = self._unheld(middle, Status.GOAL_CANNOT_BE_HELD, "at the goal")
        if refusal is None and broken:
            refusal = self.workspace.result(Status.GOAL_BREAKS_CONSTRAINT, broken)
        if refusal is None:
            return None
        if refusal.status is Status.GOAL_CANNOT_BE_HELD:
            everywhere = box_overloads(problem, lower, upper)
        elif not self._has_tolerance:
            everywhere = seen.clear or seen.proven
        elif seen.collisions:
            everywhere = box_collides(problem.reduced, lower, upper)
        else:
            everywhere = any(box_breaks(item, problem.reduced, lower, upper) for item in self._always)
        return replace(refusal, certainty=Certainty.PROVEN if everywhere else Certainty.EVIDENCE)

    def waypoints(self, rng: np.random.Generator) -> Sequence[Floats] | Result:
        """Return a configuration for each waypoint, or why one has none."""
        work, problem, counts = self.workspace, self.workspace.problem, WorkCounts()
        if not problem.waypoint_names:
            return ()
        try:
            chosen = choose_waypoints(
                problem.evaluator(problem.reduced, counts),
                dict(zip(problem.waypoint_names, problem.waypoint_requirements, strict=True)),
                [problem.requirements_at(stop) for stop in range(1, self._last_stop)],
                rng=rng,
                effort=problem.limits.effort,
                check=lambda: work.tracker.check(counts),
            )
        finally:
            work.tracker.count_work(counts)
        return work.result(Status.NO_WAYPOINT, chosen.problem) if chosen.problem else chosen.found

    @property
    def _start(self) -> Floats:
        return self.workspace.problem.reduced.start_positions

    @property
    def _has_tolerance(self) -> bool:
        lower, upper = joint_box(self.workspace.problem.goals, self.workspace.problem.reduced)
        return bool((lower < upper).any())

    @property
    def _is_one(self) -> bool:
        return is_one(joint_box(self._wanted, self.workspace.problem.reduced))

    @property
    def _last_stop(self) -> int:
        return 1 + len(self.workspace.problem.waypoint_names)

    @property
    def _always(self) -> tuple[Requirement, ...]:
        return self.workspace.problem.requirements_at(self._last_stop)

    @property
    def _wanted(self) -> tuple[Requirement, ...]:
        return (*self.workspace.problem.goals, *self._always)

    def _refuse(self, seen: Examination, limits: Status, collision: Status) -> Result | None:
        if seen.out_of_limits:
            return self.workspace.result(limits, reasons.out_of_limits(seen))
        if seen.collisions:
            return self.workspace.result(collision, reasons.collisions(seen))
        return None

    def _never_apart(self, seen: Examination) -> Result | None:
        asked = {(item.first, item.second): item.required for item in seen.collisions if item.required > 0.0}
        if not asked:
            return None
        counts = WorkCounts()
        found = never_apart(self.workspace.problem.reduced, asked, counts)
        self.workspace.tracker.count_work(counts)
        words = "; ".join(item.words("are required of") for item in found)
        return self.workspace.result(Status.CLEARANCE_IMPOSSIBLE, words) if found else None

    def _unheld(self, positions: Floats, status: Status, where: str) -> Result | None:
        weak = self.workspace.judge.overloads(positions, limits=self.workspace.problem.limits)
        return self.workspace.result(status, reasons.overloaded(weak, where)) if weak else None

    def _broken(self, positions: Floats, stop: int) -> str:
        problem = self.workspace.problem
        held = problem.requirements_at(stop)
        if not held:
            return ""
        motion = Motion.single(positions, problem.evaluator(problem.reduced))
        for required in held:
            for item in constrain(required, problem.reduced, WHOLE, inset=0.0):
                excess = replace(item, tolerance=max(item.tolerance, EXCESS)).excess(motion)
                if excess > 0.0:
                    missed = missed_at(problem.reduced, (required,), positions)
                    return f"{required}: missed by {missed}"
        return ""
