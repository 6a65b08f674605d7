"""Run: one problem planned by one method, and what the judge says of the motion."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import isfinite
from typing import cast

from trajopt.arrays import Floats
from trajopt.planning.status import UNASKABLE, Status


@dataclass(frozen=True)
class Moment:
    """One step of a solver, in the history of a run.

    Attributes:
        cpu_seconds: Process time since planning began [s].
        attempt: Which first guess, from 1.
        cost: Sum of the costs at the current point.
        violation: L1 norm of the violations there.
    """

    cpu_seconds: float
    attempt: int
    cost: float
    violation: float


@dataclass(frozen=True, kw_only=True)
class Run:
    """What became of one problem with one method.

    Attributes:
        problem: Name of the problem.
        solver: Name of the method.
        expected: How planning should end.
        status: How it ended.
        message: The particulars.
        attempts: First guesses tried.
        cpu_seconds: Process time of planning, judge included [s].
        iterations: Steps of the solver, over all first guesses.
        cost: Of the solver's last path; None if it got none.
        duration: Of the motion [s]; None if there is none, as the next two.
        path_length: Of the path in joint space [rad | m].
        clearance: Smallest clearance that the judge proved [m].
        violations: Name of each constraint that is broken -> by how much, in its own unit: on the timed
            motion as the judge says, or where there is none on the path as the solver says.
        history: Every step of the solver.
        tip: Positions of the group's last joint along the motion, shape (s, 3) [m]; empty if none.
    """

    problem: str
    solver: str
    expected: Status
    status: Status
    message: str
    attempts: int
    cpu_seconds: float
    iterations: int
    cost: float | None
    duration: float | None
    path_length: float | None
    clearance: float | None
    violations: Mapping[str, float]
    history: tuple[Moment, ...]
    tip: tuple[tuple[float, ...], ...]

    @property
    def verified(self) -> bool:
        """Whether the judge verified a motion."""
        return self.status is Status.SOLVED

    @property
    def askable(self) -> bool:
        """Whether anybody could answer: start and goal are free, or being refused is the right answer."""
        return self.status is self.expected or self.status not in UNASKABLE

    @property
    def good(self) -> bool:
        """Whether planning ended as it should."""
        return self.status is self.expected

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold; numbers that are not finite become None."""
        return {
            **{key: _finite(value) for key, value in asdict(self).items()},
            "expected": self.expected.name,
            "status": self.status.name,
            "verified": self.verified,
            "violations": {name: _finite(value) for name, value in self.violations.items()},
            "history": [
                {key: _finite(value) for key, value in asdict(moment).items()} for moment in self.history
            ],
            "tip": [list(point) for point in self.tip],
        }

    @staticmethod
    def from_dict(document: Mapping[str, object]) -> "Run":
        """Return what `as_dict` told."""
        known = {key: value for key, value in document.items() if key != "verified"}
        history = cast("list[dict[str, float | None]]", document["history"])
        broken = cast("dict[str, float | None]", document["violations"])
        return Run(
            **cast(
                "dict[str, object]",
                known
                | {
                    "expected": Status[cast("str", document["expected"])],
                    "status": Status[cast("str", document["status"])],
                    "violations": {name: _number(value) for name, value in broken.items()},
                    "history": tuple(
                        Moment(
                            _number(item["cpu_seconds"]),
                            int(_number(item["attempt"])),
                            _number(item["cost"]),
                            _number(item["violation"]),
                        )
                        for item in history
                    ),
                    "tip": tuple(tuple(point) for point in cast("list[list[float]]", document["tip"])),
                },
            )  # pyright: ignore[reportArgumentType]
        )


def points(positions: Floats) -> tuple[tuple[float, ...], ...]:
    """Return rows as plain numbers, to tenths of a millimetre."""
    return tuple(tuple(round(float(number), 4) for number in row) for row in positions)


def _finite(value: object) -> object:
    return None if isinstance(value, float) and not isfinite(value) else value


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)
