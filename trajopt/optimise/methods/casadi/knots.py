"""The whole problem over knots as one nonlinear program, for ipopt, fatrop and sqpmethod."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np

from trajopt.optimise.methods.casadi.nlpsol import Nlpsol
from trajopt.optimise.methods.casadi.program import by_stages, objection, plainly, requirement_objection
from trajopt.optimise.methods.method import Decoded, NlpProgram, Progress, followed_curve, moving_start
from trajopt.optimise.nlp import Linearisation
from trajopt.optimise.solvers.solver import Iteration, SolveResult, SolverStatus
from trajopt.optimise.terms.joint_positions import rolling
from trajopt.optimise.transcription import KnotsNlp, transcribe
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FollowsCurve, Requirement
from trajopt.problem.residual import Constraint
from trajopt.values.arrays import Floats, Ints, Loss
from trajopt.values.errors import shown

ROUNDS = 6
"""Most solutions: each begins at the last, on finer samples or with a larger penalty."""
GROWTH = 10.0
"""Factor on the penalty if constraints do not hold."""
PENALTY = 5.0
"""First weight of constraint violations."""

IPOPT: Mapping[str, object] = {
    "ipopt.max_iter": 100,
    "ipopt.mu_init": 1e-4,
    "ipopt.tol": 1e-3,
    "ipopt.constr_viol_tol": 1e-4,
    "ipopt.dual_inf_tol": 1e-1,
    "ipopt.acceptable_tol": 1e-2,
    "ipopt.acceptable_obj_change_tol": 1e-3,
    "ipopt.acceptable_iter": 5,
}
"""A small first barrier, since the seed is mostly good, and the accuracy that paths need."""
FATROP: Mapping[str, object] = {
    "structure_detection": "auto",
    "fatrop.max_iter": 150,
    "fatrop.mu_init": 1e-4,
    "fatrop.tol": 1e-3,
}
"""As for ipopt; the structure is found from the pattern of the stages."""
SQPMETHOD: Mapping[str, object] = {
    "qpsol": "piqp",
    "qpsol_options": {"error_on_fail": False},
    "max_iter": 40,
    "max_iter_ls": 12,
    "tol_du": 1e-2,
    "tol_pr": 1e-4,
}
"""Of its QP solvers only PIQP is quick and correct here: docs/decisions/casadi.md."""


def ipopt() -> Nlpsol:
    return Nlpsol("ipopt", IPOPT, PENALTY)


def fatrop() -> Nlpsol:
    """Return fatrop as planning uses it: hard bounds, since slacks have no place in its structure."""
    return Nlpsol("fatrop", FATROP)


def sqpmethod() -> Nlpsol:
    return Nlpsol("sqpmethod", SQPMETHOD, PENALTY, curvature=False)


@dataclass(frozen=True)
class CasadiKnots:
    """Kinematic terms as expressions with exact derivatives; contacts are measured, with Gauss-Newton's."""

    solver: Nlpsol = field(default_factory=ipopt)

    @property
    def name(self) -> str:
        return self.solver.plugin

    @property
    def _staged(self) -> bool:
        return self.solver.plugin == "fatrop"

    def objection(self, problem: Problem) -> str:
        costs, reduced = problem.costs or (), problem.reduced
        partial = [part.required for part in problem.partial]
        held = [item for item in (*problem.residual_constraints, *partial) if isinstance(item, Constraint)]
        held += rolling(reduced, problem.knots)
        required = [item for item in (*problem.requirements, *partial) if isinstance(item, Requirement)]
        required += [*problem.goals, *chain(*problem.waypoint_requirements)]
        words = [moving_start(problem), followed_curve(problem)]
        words += [objection(item.residual, reduced) for item in (*held, *costs)]
        words += [
            requirement_objection(item, reduced) for item in required if not isinstance(item, FollowsCurve)
        ]
        found = [text for text in words if text]
        if self._staged:
            found += [
                f"cost {shown(cost.residual.name)} has a kink, which does not fit its structure"
                for cost in costs
                if cost.loss is not Loss.SQUARED
            ]
        return "; ".join(found)

    def program(
        self, problem: Problem, seed: Floats, waypoint_knots: Sequence[int] = ()
    ) -> "CasadiKnotsProgram":
        return CasadiKnotsProgram(transcribe(problem, seed, waypoint_knots), self.solver, self._staged)


@dataclass(frozen=True, eq=False)
class CasadiKnotsProgram(NlpProgram[KnotsNlp]):
    """A problem over knots and the plugin that solves it."""

    solver: Nlpsol
    staged: bool

    def solve(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        nlp, solver = self.nlp, self.solver
        knots = np.clip(seed, nlp.lower, nlp.upper)
        sampling = nlp.sampling(knots, fine=False)
        log: list[Iteration] = []
        status, at = SolverStatus.MAX_ITERATIONS, nlp.linearise(knots, sampling)
        for _ in range(ROUNDS):
            status, at = self._round(solver, at, sampling, log, progress)
            if at.feasible:
                sampling = np.maximum(sampling, nlp.sampling(at.x, fine=True))
                at = nlp.linearise(at.x, sampling)
                if at.feasible:
                    status = SolverStatus.CONVERGED
                    break
            elif solver.penalty > 0.0:
                solver = replace(solver, penalty=solver.penalty * GROWTH)
            else:
                break
        if not at.feasible and status is SolverStatus.CONVERGED:
            status = SolverStatus.INFEASIBLE_STATIONARY
        return SolveResult(status, at.x, at, tuple(log))

    def decode(self, solved: SolveResult) -> tuple[Decoded]:
        return (Decoded(self.nlp.decode(solved.x), waypoint_knots=self.nlp.waypoint_knots),)

    def _round(
        self,
        solver: Nlpsol,
        at: Linearisation,
        sampling: Ints,
        log: list[Iteration],
        progress: Progress | None,
    ) -> tuple[SolverStatus, Linearisation]:
        writing = (by_stages if self.staged else plainly)(self.nlp, sampling)
        program = writing.program()
        try:
            found = solver.solve(program, writing.pack(program, at.x), progress=progress)
        finally:
            writing.raise_failure()
        log += found.log
        knots = writing.unpack(found.x)
        return found.status, self.nlp.linearise(knots, sampling)
