"""Entry: one instance of a problem, planned, and its motion judged by a judge of its own."""

import time
from dataclasses import dataclass

from trajopt.benchmark.definition import Definition
from trajopt.planning.judgement import judge
from trajopt.planning.plan import plan
from trajopt.planning.result import Status
from trajopt.verify import Check

SOLVED = "solved"
"""How an entry calls the outcome of a problem that has a solution."""
_COLUMNS = {
    **{name: name for name in ("name", "subject", "bound", "unit", "time", "evidence", "holds")},
    "worst": "value",
}
"""Key of a constraint as data -> the attribute of a check."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What became of one instance.

    Attributes:
        problem: Name of the problem.
        draw: 0 for the fixed instance, else the number of the random one.
        expected: How planning should end.
        status: How it ended.
        message: The particulars.
        constraints: What a fresh judge says of the timed motion; empty where there is none.
        setup_seconds: Process time of making the instance [s].
        cpu_seconds: Process time of planning [s].
        duration: Duration of the motion [s]; None where there is none.
    """

    problem: str
    draw: int
    expected: Status
    status: Status
    message: str
    constraints: tuple[Check, ...]
    setup_seconds: float
    cpu_seconds: float
    duration: float | None

    @property
    def instance(self) -> str:
        """Name of the instance."""
        return "fixed" if self.draw == 0 else f"random {self.draw}"

    @property
    def as_expected(self) -> bool:
        """Whether planning ended as it should, and the judge agrees where it found a motion."""
        held = self.status is not Status.SOLVED or (
            bool(self.constraints) and all(item.holds for item in self.constraints)
        )
        return self.status is self.expected and held

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold; numbers that are not finite become None."""
        return {
            "problem": self.problem,
            "instance": self.instance,
            "expected": outcome(self.expected),
            "outcome": outcome(self.status),
            "as_expected": self.as_expected,
            "message": self.message,
            "constraints": [
                {key: plain[name] for key, name in _COLUMNS.items()}
                for plain in (check.as_dict() for check in self.constraints)
            ],
            "setup_seconds": self.setup_seconds,
            "cpu_seconds": self.cpu_seconds,
            "duration": self.duration,
        }


def outcome(status: Status) -> str:
    """Return "solved", or the name of the reason of refusal."""
    return SOLVED if status is Status.SOLVED else status.name


def run(definition: Definition, draw: int = 0) -> Entry:
    """Plan an instance with the default solver, and judge the motion anew.

    Args:
        definition: Makes the problem.
        draw: 0 for the fixed instance, else the number of a random one.

    Raises:
        ProblemError: If there are no random instances.
    """
    begin = time.process_time()
    problem = definition.problem(draw)
    made = time.process_time()
    result = plan(problem)
    planned = time.process_time()
    solved = result.trajectory if result.verified else None
    return Entry(
        problem=definition.name,
        draw=draw,
        expected=definition.expected,
        status=result.status,
        message=result.message,
        constraints=()
        if solved is None
        else tuple(check for check in judge(problem, solved).checks if check.required),
        setup_seconds=made - begin,
        cpu_seconds=planned - made,
        duration=None if solved is None else solved.duration,
    )
