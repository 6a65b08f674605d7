"""Attempts: from a first guess to a judged motion. The sequence a reader would have typed."""

from dataclasses import dataclass, replace
from functools import cached_property

from trajopt.arrays import Floats
from trajopt.infeasibility import reasons
from trajopt.methods import Glancing, Outcome, Program
from trajopt.methods.timing import timed as time_path
from trajopt.model.trajectory import Path, Trajectory
from trajopt.planning.judgement import judge
from trajopt.planning.meter import Meter
from trajopt.planning.result import Result
from trajopt.planning.status import Certainty, Status
from trajopt.problem import Problem
from trajopt.query import Counts, Query
from trajopt.retime import Retimed, RetimeFailure
from trajopt.solvers import Iteration
from trajopt.verify import Certificate, Judge

PATH_TOLERANCES = (5e-3, 1e-3)
"""How far the timed motion may leave the checked path, and again if the judge refuses it [m]."""
WAYPOINT_TOLERANCE = 1e-4
"""The same, a third time, for problems with waypoints: they may be at corners of the path [m]."""


@dataclass(eq=False)
class Attempts:
    """Attempts at one problem.

    Attributes:
        problem: The problem, with one goal.
        meter: Takes the work and the time, and stops both.
    """

    problem: Problem
    meter: Meter

    @cached_property
    def judge(self) -> Judge:
        """The judge of this problem; it keeps its own kinematics and geometry."""
        return Judge(self.problem.reduced)

    def optimised(self, program: Program, seed: Floats, *, briefly: bool = False) -> Result:
        """Optimise a first guess; time and judge what comes out.

        Args:
            program: The problem as the method writes it.
            seed: The first guess.
            briefly: Whether a few steps are enough, where the method can stop early.

        Raises:
            Stopped: If the budget ends before.
        """
        found = self._solved(program, seed, briefly)
        solved = found.solve
        self.meter.count(attempts=1, qp_solves=solved.qp_solves, qp_iterations=solved.qp_iterations)
        if not solved.feasible:
            return self.result(Status.STUCK, reasons.stuck(self.problem, solved), found=found)
        return self._made(found)

    def _made(self, found: Outcome) -> Result:
        """Judge what a method made, timed first where it left that open; and what it falls back on."""
        if found.trajectory is None:
            return self._timed(found.path, found)
        result = self._judged(found.trajectory, found=found)
        return result if result.verified or found.otherwise is None else self._made(found.otherwise)

    def as_it_is(self, seed: Floats) -> Result | None:
        """Time and judge a first guess itself; None if something is too near at its knots.

        Raises:
            Stopped: If the budget ends before.
        """
        reduced, counts = self.problem.reduced, Counts()
        touching = Query(reduced, counts).close_pairs(seed, reduced.pairs.required)
        self.meter.count_work(counts)
        self.meter.check()
        return None if len(touching.pair) else self._timed(Path(reduced.joint_names, seed))

    def result(
        self,
        status: Status,
        message: str,
        *,
        path: Path | None = None,
        found: Outcome | None = None,
        trajectory: Trajectory | None = None,
        timed: Retimed | None = None,
        certificate: Certificate | None = None,
        certainty: Certainty = Certainty.EVIDENCE,
    ) -> Result:
        """Return a result with what has been counted so far."""
        return Result(
            problem=self.problem,
            status=status,
            message=message,
            path=path if found is None else found.path,
            solve=None if found is None else found.solve,
            trajectory=trajectory,
            timed=timed,
            certificate=certificate,
            counts=dict(self.meter.counts),
            cpu_seconds=dict(self.meter.seconds),
            certainty=certainty,
        )

    def _solved(self, program: Program, seed: Floats, briefly: bool) -> Outcome:
        before = replace(program.counts)

        def step(iteration: Iteration) -> None:
            self.meter.step(iteration, _since(before, program.counts))

        with self.meter.stage("optimise"):
            try:
                if briefly and isinstance(program, Glancing):
                    return program.glance(seed, progress=step)
                return program.solve(seed, progress=step)
            finally:
                self.meter.count_work(_since(before, program.counts))

    def _timed(self, path: Path, found: Outcome | None = None) -> Result:
        """Time a path and have it judged, each time nearer to the path, until the judge agrees."""
        problem = self.problem
        result: Result | None = None
        for tolerance in (*PATH_TOLERANCES, *((WAYPOINT_TOLERANCE,) if problem.waypoints else ())):
            with self.meter.stage("retime"):
                timed = time_path(problem, Query(problem.reduced), path, tolerance=tolerance)
            if isinstance(timed, RetimeFailure):
                return self.result(Status.NO_TIMING, timed.reason, path=path, found=found)
            result = self._judged(timed.trajectory, path=path, found=found, timed=timed)
            if result.verified:
                break
        assert result is not None
        return result

    def _judged(
        self,
        trajectory: Trajectory,
        *,
        path: Path | None = None,
        found: Outcome | None = None,
        timed: Retimed | None = None,
    ) -> Result:
        with self.meter.stage("verify"):
            certificate = judge(self.problem, trajectory, workspace=self.judge)
        self.meter.count(judge_distance_calls=certificate.counts.distances)
        return self.result(
            Status.SOLVED if certificate.verified else Status.NOT_VERIFIED,
            reasons.not_verified(certificate),
            path=path,
            found=found,
            trajectory=trajectory,
            timed=timed,
            certificate=certificate,
            certainty=Certainty.PROVEN if certificate.verified else Certainty.EVIDENCE,
        )


def _since(before: Counts, now: Counts) -> Counts:
    return Counts(
        now.forward_kinematics - before.forward_kinematics,
        now.bounds - before.bounds,
        now.distances - before.distances,
    )
