"""CasADi's solvers: a nonlinear program of expressions and callbacks, solved by a plugin."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from trajopt.optimise.solvers.solver import Iteration, Progress, SolverStatus
from trajopt.values.arrays import Bools, Floats
from trajopt.values.errors import BackendFailed, SolverNotFound

QUIET: Mapping[str, Mapping[str, object]] = {
    "ipopt": {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes"},
    "fatrop": {"print_time": False, "fatrop.print_level": 0},
    "sqpmethod": {
        "print_time": False,
        "print_header": False,
        "print_iteration": False,
        "print_status": False,
    },
}
"""The supported plugins, and the options that silence each."""

ENDED: Mapping[str, SolverStatus] = {
    "Solve_Succeeded": SolverStatus.CONVERGED,
    "Solved_To_Acceptable_Level": SolverStatus.CONVERGED,
    "Feasible_Point_Found": SolverStatus.CONVERGED,
    "Maximum_Iterations_Exceeded": SolverStatus.MAX_ITERATIONS,
    "Infeasible_Problem_Detected": SolverStatus.INFEASIBLE_STATIONARY,
    "Restoration_Failed": SolverStatus.INFEASIBLE_STATIONARY,
    "Search_Direction_Becomes_Too_Small": SolverStatus.TRUST_REGION_COLLAPSED,
    "Search_Direction_Becomes_Too_Small ": SolverStatus.TRUST_REGION_COLLAPSED,
    "Invalid_Number_Detected": SolverStatus.NON_FINITE,
}
"""Meanings of the plugins' return statuses; any other is a failure of their linear algebra or QP."""


@dataclass(frozen=True, eq=False)
class CasadiProgram:
    """Minimise an objective of x with x and functions of x between bounds.

    Attributes:
        x: The variables, shape (v, 1).
        functions: Shape (m, 1).
        lower: Of the variables, shape (v,); equal to upper for fixed ones.
        upper: Shape (v,).
        least: Of the functions, shape (m,); -inf for none.
        most: Shape (m,); inf for none.
        elastic: Functions whose bounds may be penalised instead, shape (m,); none of them when empty.
    """

    x: ca.MX
    objective: ca.MX
    functions: ca.MX
    lower: Floats
    upper: Floats
    least: Floats
    most: Floats
    elastic: Bools = field(default_factory=lambda: np.empty(0, dtype=np.bool_))


@dataclass(frozen=True, eq=False)
class CasadiSolution:
    """Result of a plugin. The log is empty if it reports no iterations."""

    status: SolverStatus
    said: str
    x: Floats
    log: tuple[Iteration, ...]


@dataclass(frozen=True)
class Nlpsol:
    """A plugin with its options.

    Attributes:
        plugin: "ipopt", "fatrop" or "sqpmethod".
        penalty: Weight of the excess of elastic functions over their bounds; 0 keeps all bounds hard.
        curvature: Whether the Hessian includes second derivatives of the functions. Fatrop always does.
    """

    plugin: str
    options: Mapping[str, object] = field(default_factory=dict[str, object])
    penalty: float = 0.0
    curvature: bool = True

    def __post_init__(self) -> None:
        if self.plugin not in QUIET:
            raise SolverNotFound("CasADi plugin", self.plugin, QUIET)

    def solve(
        self, program: CasadiProgram, x0: Floats, *, progress: Progress | None = None
    ) -> CasadiSolution:
        stretched = _Elastic(program, self.penalty)
        whole = stretched.program
        watcher = _Watcher(stretched, progress)
        given: dict[str, object] = {**QUIET[self.plugin], **self.options, "error_on_fail": False}
        if self.plugin == "fatrop":
            given["equality"] = (whole.least == whole.most).tolist()
        else:
            given["iteration_callback"] = watcher
            if not self.curvature:
                given["hess_lag"] = _of_objective(whole, self.plugin)
        nlp = {"x": whole.x, "f": whole.objective, "g": whole.functions}
        try:
            solver = ca.nlpsol("solver", self.plugin, nlp, given)
            found = solver(
                x0=stretched.start(x0), lbx=whole.lower, ubx=whole.upper, lbg=whole.least, ubg=whole.most
            )
        except RuntimeError as error:
            if watcher.raised is not None:
                raise watcher.raised from None
            raise BackendFailed(f"{self.plugin}: {error}") from error
        if watcher.raised is not None:
            raise watcher.raised
        stats = solver.stats()
        said = str(stats["return_status"])
        status = SolverStatus.CONVERGED if stats["success"] else ENDED.get(said, SolverStatus.QP_FAILED)
        return CasadiSolution(status, said, stretched.own(found["x"].full().ravel()), tuple(watcher.log))


def _of_objective(program: CasadiProgram, plugin: str) -> ca.Function:
    multipliers = ca.MX.sym("lam_g", len(program.least))
    given = [program.x, ca.MX.sym("p", 0), ca.MX.sym("lam_f"), multipliers]
    hessian = given[2] * ca.hessian(program.objective, program.x)[0]
    names = ["x", "p", "lam_f", "lam_g"]
    if plugin == "ipopt":
        return ca.Function("nlp_hess_l", given, [ca.triu(hessian)], names, ["triu_hess_gamma_x_x"])
    return ca.Function("nlp_hess_l", given, [hessian], names, ["hess_gamma_x_x"])


class _Elastic:
    def __init__(self, given: CasadiProgram, penalty: float) -> None:
        self.given, self.penalty = given, penalty
        elastic = (
            given.elastic if len(given.elastic) and penalty > 0.0 else np.zeros(len(given.least), np.bool_)
        )
        below = np.flatnonzero(elastic & np.isfinite(given.least))
        above = np.flatnonzero(elastic & np.isfinite(given.most))
        self._rows = np.concatenate((below, above))
        self._signs = np.repeat((1.0, -1.0), (len(below), len(above)))
        count = len(self._rows)
        self.program = given
        if count:
            slack = ca.MX.sym("excess", count)
            pattern = ca.Sparsity.triplet(
                len(given.least), count, self._rows.tolist(), np.arange(count).tolist()
            )
            none = np.zeros(count)
            self.program = CasadiProgram(
                ca.vertcat(given.x, slack),
                given.objective + penalty * ca.sum1(slack),
                given.functions + ca.MX(ca.DM(pattern, self._signs)) @ slack,
                np.concatenate((given.lower, none)),
                np.concatenate((given.upper, np.full(count, np.inf))),
                given.least,
                given.most,
            )

    def start(self, x0: Floats) -> Floats:
        if not len(self._rows):
            return x0
        (values,) = ca.Function("values", [self.given.x], [self.given.functions]).call([x0])
        found = values.full().ravel()[self._rows]
        below = self._signs > 0.0
        bound = np.where(below, self.given.least[self._rows], self.given.most[self._rows])
        return np.concatenate((x0, np.maximum(0.0, self._signs * (bound - found))))

    def own(self, x: Floats) -> Floats:
        return x[: len(self.given.lower)]

    def worth(self, x: Floats, objective: float, functions: Floats) -> tuple[float, float]:
        slack = x[len(self.given.lower) :]
        real = functions.copy()
        np.subtract.at(real, self._rows, self._signs * slack)
        outside = np.maximum(self.given.least - real, real - self.given.most)
        return objective - self.penalty * float(slack.sum()), float(np.maximum(outside, 0.0).sum())


class _Watcher(ca.Callback):
    def __init__(self, of: _Elastic, progress: Progress | None) -> None:
        super().__init__()
        program = of.program
        self._sizes = {"x": len(program.lower), "lam_x": len(program.lower), "f": 1}
        self._sizes |= {"g": len(program.least), "lam_g": len(program.least)}
        self._of, self._progress = of, progress
        self.log: list[Iteration] = []
        self.raised: BaseException | None = None
        self.construct("watcher", {})

    def get_n_in(self) -> int:
        return ca.nlpsol_n_out()

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, index: int) -> ca.Sparsity:
        size = self._sizes.get(ca.nlpsol_out(index), 0)
        return ca.Sparsity.dense(size, 1) if size else ca.Sparsity(0, 0)

    def eval(self, arguments: list[ca.DM]) -> list[float]:
        """Log an iteration; 0 lets the solver go on."""
        values = {ca.nlpsol_out(index): part for index, part in enumerate(arguments)}
        cost, violation = self._of.worth(
            values["x"].full().ravel(), float(values["f"]), values["g"].full().ravel()
        )
        entry = Iteration(cost, violation, True)
        self.log.append(entry)
        if self._progress is not None:
            try:
                self._progress(entry)
            except BaseException as error:  # CasADi would print it with all of the program's numbers
                self.raised = error
                return [1.0]
        return [0.0]
