"""Ends of a motion: whether it can begin and end where it is asked to, and at which configurations."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt import reasons
from trajopt.arrays import Floats
from trajopt.planning.attempts import Attempts
from trajopt.query import Counts, query_of
from trajopt.result import Result
from trajopt.seeds import choose_waypoints, conflicting, goal_candidates
from trajopt.status import Status
from trajopt.terms import constrain
from trajopt.terms.motion import Motion
from trajopt.terms.residual import WHOLE
from trajopt.transcription import fixed_goal
from trajopt.verify import Examination, Moment


@dataclass(frozen=True, eq=False)
class Ends:
    """Looks at the ends of a problem's motion, and at its waypoints.

    Attributes:
        attempts: At the problem; makes the results that say why there can be no motion.
    """

    attempts: Attempts

    def start(self) -> Result | None:
        """Refuse a start that no motion can leave."""
        seen = self.attempts.judge.examine(self._start, moment=Moment.START)
        refusal = self._refuse(seen, Status.START_OUT_OF_LIMITS, Status.START_IN_COLLISION)
        broken = self._broken(self._start, 0)
        if refusal is None and broken:
            return self.attempts.result(Status.START_BREAKS_CONSTRAINT, broken)
        return refusal

    def goals(self, rng: np.random.Generator) -> Sequence[Floats] | Result:
        """Return goal configurations, nearest first, or why there is none."""
        attempts, problem = self.attempts, self.attempts.problem
        goal = fixed_goal(problem)
        if goal is not None:
            seen = attempts.judge.examine(goal, moment=Moment.END)
            refusal = self._refuse(seen, Status.GOAL_OUT_OF_LIMITS, Status.GOAL_IN_COLLISION)
            broken = self._broken(goal, self._last_stop)
            if refusal is None and broken:
                refusal = attempts.result(Status.GOAL_BREAKS_CONSTRAINT, broken)
            return (goal,) if refusal is None else refusal
        beyond = reasons.joint_goal_beyond_limits(problem)
        if beyond:
            return attempts.result(Status.GOAL_OUT_OF_LIMITS, "; ".join(block.words for block in beyond))
        counts = Counts()
        wanted = (*problem.goals, *problem.requirements_at(self._last_stop))
        try:
            found = goal_candidates(
                problem.reduced,
                wanted,
                rng=rng,
                counts=counts,
                check=lambda: attempts.meter.check(counts),
            )
        finally:
            attempts.meter.count_work(counts)
        if found.free:
            return found.free
        if found.blocking is not None:
            return attempts.result(Status.GOAL_IN_COLLISION, reasons.no_goal_configuration(found))
        clash = conflicting(problem.reduced, wanted, rng=rng, counts=counts)
        status = Status.CONFLICTING_CONSTRAINTS if len(clash) > 1 else Status.NO_INVERSE_KINEMATICS
        return attempts.result(status, reasons.unreachable(clash, found.nearest_miss))

    def waypoints(self, rng: np.random.Generator) -> Sequence[Floats] | Result:
        """Return a configuration for each waypoint, or why one has none."""
        attempts, problem, counts = self.attempts, self.attempts.problem, Counts()
        try:
            chosen = choose_waypoints(
                problem.reduced,
                problem.waypoint_requirements,
                [problem.requirements_at(stop) for stop in range(1, self._last_stop)],
                rng=rng,
                counts=counts,
                check=lambda: attempts.meter.check(counts),
            )
        finally:
            attempts.meter.count_work(counts)
        return attempts.result(Status.NO_WAYPOINT, chosen.problem) if chosen.problem else chosen.found

    @property
    def _start(self) -> Floats:
        return self.attempts.problem.reduced.start_positions

    @property
    def _last_stop(self) -> int:
        return 1 + len(self.attempts.problem.waypoint_names)

    def _refuse(self, seen: Examination, limits: Status, collision: Status) -> Result | None:
        if seen.out_of_limits:
            return self.attempts.result(limits, reasons.out_of_limits(seen))
        if seen.collisions:
            return self.attempts.result(collision, reasons.collisions(seen))
        return None

    def _broken(self, positions: Floats, stop: int) -> str:
        """Say which path constraint does not hold at a configuration, or nothing."""
        problem = self.attempts.problem
        motion = Motion.standing(positions, query_of(problem.reduced))
        for required in problem.requirements_at(stop):
            for item in constrain(required, problem.reduced, WHOLE, inset=0.0):
                excess = item.excess(motion)
                if excess > 0.0:
                    return f"{required} is exceeded by {excess:.3g}"
        return ""
