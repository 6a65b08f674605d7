"""Outcome of one problem with one method, and summaries of the outcomes of each method."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from math import isfinite
from typing import cast

import numpy as np

from trajopt.planning.seeds import SeedKind
from trajopt.planning.status import Certainty, Status
from trajopt.values.arrays import Floats
from trajopt.values.errors.arguments import checked
from trajopt.verify import Check, CheckKind, Evidence

INSTALLED = "installed"
"""Set of the problems that belong to no set of files."""


@dataclass(frozen=True)
class IterationRecord:
    """One step of a solver, in the history of an outcome.

    Attributes:
        cpu_seconds: CPU time since planning began [s].
        violation: L1 norm of the violations there.
    """

    cpu_seconds: float
    attempt: int
    cost: float
    violation: float


@dataclass(frozen=True, kw_only=True)
class RunOutcome:
    """Outcome of one problem with one method.

    Attributes:
        draw: 0, or the number of a random instance.
        setup_seconds: CPU time of making the problem, including its files [s].
        cpu_seconds: CPU time of planning, including the judge [s].
        stages: CPU time by stage [s].
        iterations: Steps of the solver, over all seeds; 0 if not recorded.
        cost: Of the solver's last path; None without one.
        duration: Of the motion [s]; None without one, like the next two.
        path_length: Of the path in joint space [rad | m].
        clearance: Smallest clearance that the judge proved [m].
        violations: Name of each violated constraint -> amount, in its own unit: of the timed motion by the
            judge, or else of the path by the solver.
        constraints: Measurements of a fresh judge on the timed motion; empty without one, or if not
            requested.
        stopped_by_clock: Whether time ran out; results may then vary.
        history: Every step of the solver; empty if not recorded.
        tip: Positions of the group's last joint along the motion, shape (s, 3) [m]; may be empty.
    """

    problem: str
    draw: int = 0
    solver: str
    expected: Status
    status: Status
    certainty: Certainty = Certainty.EVIDENCE
    message: str
    attempts: int = 0
    attempts_by_kind: Mapping[str, int] = field(default_factory=dict[str, int])
    won_by: SeedKind | None = None
    setup_seconds: float = 0.0
    cpu_seconds: float
    stages: Mapping[str, float] = field(default_factory=dict[str, float])
    counts: Mapping[str, int] = field(default_factory=dict[str, int])
    iterations: int = 0
    cost: float | None = None
    duration: float | None = None
    path_length: float | None = None
    clearance: float | None = None
    violations: Mapping[str, float] = field(default_factory=dict[str, float])
    constraints: tuple[Check, ...] = ()
    stopped_by_clock: bool = False
    history: tuple[IterationRecord, ...] = ()
    tip: tuple[tuple[float, ...], ...] = ()

    @property
    def set_name(self) -> str:
        """The set that the problem belongs to."""
        return self.problem.split("/", maxsplit=1)[0] if "/" in self.problem else INSTALLED

    @property
    def instance(self) -> str:
        """Name of the instance of an installed problem."""
        return "fixed" if self.draw == 0 else f"random {self.draw}"

    @property
    def verified(self) -> bool:
        """Whether the judge verified a motion, and also a fresh judge if requested."""
        return self.status is Status.SOLVED and all(item.holds for item in self.constraints)

    @property
    def good(self) -> bool:
        """Whether planning ended as it should."""
        return self.status is self.expected and (self.verified or self.expected is not Status.SOLVED)

    @property
    def askable(self) -> bool:
        """Whether the problem is valid: refusal is expected, or it is not proven to be unsolvable."""
        known = self.certainty is Certainty.PROVEN and self.status is not Status.METHOD_CANNOT
        return self.good or self.status is Status.SOLVED or not known

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data; non-finite numbers become None."""
        plain = cast("dict[str, object]", _finite(asdict(self)))
        return plain | {
            "expected": self.expected.name,
            "status": self.status.name,
            "certainty": self.certainty.name,
            "won_by": None if self.won_by is None else self.won_by.name,
            "constraints": [check.as_dict() for check in self.constraints],
            "verified": self.verified,
        }

    @staticmethod
    @checked
    def from_dict(document: Mapping[str, object]) -> "RunOutcome":
        """Restore the data of `as_dict`; missing data counts as not measured."""
        known = {item.name: document[item.name] for item in fields(RunOutcome) if item.name in document}
        broken = cast("dict[str, float | None]", document["violations"])
        history = cast("list[dict[str, float | None]]", document.get("history", ()))
        held = cast("list[dict[str, object]]", document.get("constraints", ()))
        won = cast("str | None", document.get("won_by"))
        known |= {
            "expected": Status[cast("str", document["expected"])],
            "status": Status[cast("str", document["status"])],
            "certainty": Certainty[cast("str", document.get("certainty", Certainty.EVIDENCE.name))],
            "won_by": None if won is None else SeedKind[won],
            "violations": {name: _number(value) for name, value in broken.items()},
            "constraints": tuple(_check(item) for item in held),
            "history": tuple(
                IterationRecord(
                    _number(item["cpu_seconds"]), int(_number(item["attempt"])), _number(item["cost"]),
                    _number(item["violation"]),
                )
                for item in history
            ),
            "tip": tuple(tuple(point) for point in cast("list[list[float]]", document.get("tip", ()))),
        }  # fmt: skip
        return RunOutcome(**known)  # pyright: ignore[reportArgumentType]


def _finite(value: object) -> object:
    if isinstance(value, Mapping):
        items = cast("Mapping[str, object]", value).items()
        return {key: _finite(item) for key, item in items}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in cast("list[object]", value)]
    return None if isinstance(value, float) and not isfinite(value) else value


def _check(told: Mapping[str, object]) -> Check:
    kinds = {"evidence": Evidence(told["evidence"]), "kind": CheckKind(told["kind"])}
    return Check(**{**told, **kinds})  # pyright: ignore[reportArgumentType]


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


@dataclass(frozen=True)
class MethodSummary:
    """One method over all valid problems.

    Attributes:
        good: Problems with the expected outcome: a verified motion, or the right refusal.
        groups: Both numbers (good, total) by group of problems.
        cpu_total: CPU time over all problems [s].
        cpu_median: Over the problems with a verified motion [s]; None without any, like the following.
        cost: Median ratio of its cost to the least of all methods on the same problem.
        clearance: Smallest proven clearance [m].
    """

    solver: str
    total: int
    good: int
    groups: dict[str, tuple[int, int]]
    cpu_total: float
    cpu_median: float | None
    iterations: float | None
    cost: float | None
    duration: float | None
    path_length: float | None
    clearance: float | None


def summaries(runs: Sequence[RunOutcome]) -> tuple[MethodSummary, ...]:
    """Return the summary of each method, in the order of appearance, without invalid problems."""
    asked = [run for run in runs if run.askable]
    return tuple(
        _summary(solver, [run for run in asked if run.solver == solver], asked)
        for solver in dict.fromkeys(run.solver for run in runs)
    )


def _summary(solver: str, mine: Sequence[RunOutcome], everybody: Sequence[RunOutcome]) -> MethodSummary:
    solved = [run for run in mine if run.verified]
    groups = dict.fromkeys(run.set_name for run in mine)
    return MethodSummary(
        solver=solver,
        total=len(mine),
        good=sum(run.good for run in mine),
        groups={
            name: (
                sum(run.good for run in mine if run.set_name == name),
                sum(run.set_name == name for run in mine),
            )
            for name in groups
        },
        cpu_total=sum(run.cpu_seconds for run in mine),
        cpu_median=_median([run.cpu_seconds for run in solved]),
        iterations=_median([float(run.iterations) for run in solved]),
        cost=_ratio(solved, everybody, lambda run: run.cost),
        duration=_ratio(solved, everybody, lambda run: run.duration),
        path_length=_ratio(solved, everybody, lambda run: run.path_length),
        clearance=min((run.clearance for run in solved if run.clearance is not None), default=None),
    )


def _ratio(
    solved: Sequence[RunOutcome],
    everybody: Sequence[RunOutcome],
    measure: Callable[[RunOutcome], float | None],
) -> float | None:
    least: dict[str, float] = {}
    for run in everybody:
        value = measure(run)
        if run.verified and value is not None:
            least[run.problem] = min(value, least.get(run.problem, value))
    ratios = [
        value / least[run.problem]
        for run in solved
        if (value := measure(run)) is not None and least[run.problem] > 0.0
    ]
    return _median(ratios)


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None


def performance_profile(runs: Sequence[RunOutcome]) -> Mapping[str, Floats]:
    """Return each method's ratios of CPU time to the best one's, ascending; inf for unsolved problems.

    Only problems with a solution count. Source: Dolan and More, Benchmarking optimization software with
    performance profiles, 2002.
    """
    asked = [run for run in runs if run.askable and run.expected is Status.SOLVED]
    problems = list(dict.fromkeys(run.problem for run in asked))
    best: dict[str, float] = {}
    for run in asked:
        if run.verified:
            best[run.problem] = min(run.cpu_seconds, best.get(run.problem, np.inf))
    profile: dict[str, Floats] = {}
    for solver in dict.fromkeys(run.solver for run in asked):
        times = {run.problem: run.cpu_seconds for run in asked if run.solver == solver and run.verified}
        ratios = [times[name] / best[name] if name in times else np.inf for name in problems]
        profile[solver] = np.sort(np.array(ratios))
    return profile
