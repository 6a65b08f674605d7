"""Bundle: the content of a bundle file, a problem and its outcome."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path as FilePath

from trajopt.planning.judgement import judge
from trajopt.planning.plan_arguments import PlanArguments
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Value
from trajopt.values.errors import ModelError, shown
from trajopt.values.trajectory import Path, Trajectory
from trajopt.verify import Certificate

FORMAT = "trajopt bundle"
VERSION = 1
"""Format version. trajopt reads all older versions and refuses newer ones."""
SUFFIX = ".trajopt"
"""File name extension of bundles."""
DESCRIPTION, PROBLEM, ARGUMENTS, ANSWER, MOTION, EXPLANATION, URDF = (
    *("bundle.json", "problem.json", "arguments.json", "answer.json", "motion.json"),
    *("explanation.json", "robot.urdf"),
)
"""The documents of a bundle; arrays are in `arrays/`, meshes in `meshes/`."""


class Holds(Enum):
    """Kind of content of a bundle; each value is its description."""

    PLAN = "a plan"
    FAILURE = "a problem that planning did not solve"
    PROBLEM = "a problem"


@dataclass(frozen=True, eq=False, kw_only=True)
class Bundle(Value):
    """The content of a bundle file.

    Attributes:
        path: The file.
        holds: Kind of content.
        made: Time of writing (UTC, ISO 8601).
        versions: Versions of Python, trajopt and its dependencies at the time of writing, by name.
        problem: The problem, with robot and scene.
        arguments: Arguments of the planning call; None if not planned or unknown.
        method: Description of the planning method; empty if not planned.
        custom_method: Whether the method was an object with its own options, which a file cannot hold.
        trajectory: The motion, verified or not; None if planning did not reach one.
        path_planned: The path without timing; None if planning did not reach one.
        answer: The result, in the form of `Result.as_dict`.
        explanation: The output of `Result.explain` as plain data; empty if not explained.
    """

    path: FilePath
    holds: Holds
    made: str
    versions: Mapping[str, str]
    problem: Problem
    arguments: PlanArguments | None = None
    method: str = ""
    custom_method: bool = False
    trajectory: Trajectory | None = None
    path_planned: Path | None = None
    answer: Mapping[str, object] = field(default_factory=dict[str, object])
    explanation: Mapping[str, object] = field(default_factory=dict[str, object])

    @property
    def status(self) -> str:
        """Name of the status of planning; empty if not planned."""
        return str(self.answer.get("status", ""))

    def require(self) -> Trajectory:
        """Return the motion.

        Raises:
            ModelError: If the bundle has none.
        """
        if self.trajectory is None:
            raise ModelError(f"{self.path} holds {self.holds.value}, and no motion")
        return self.trajectory

    def judged(self) -> Certificate:
        """Verify the motion again, ignoring any verdict in the file.

        Raises:
            ModelError: If the bundle has no motion.
        """
        return judge(self.problem, self.require())

    def __repr__(self) -> str:
        """Return a one-line description."""
        return f"Bundle({shown(self.problem.name)}: {self.holds.value})"

    def __str__(self) -> str:
        """Return the request, the answer and the versions."""
        lines = [
            f"{self.path.name}: {self.holds.value}, written {self.made} by trajopt "
            f"{self.versions.get('trajopt', '(unknown)')}",
            str(self.problem),
        ]
        if self.answer:
            lines.append(f"  answer       {self.answer.get('message', '')}")
        if self.trajectory is not None:
            lines.append(f"  motion       {self.trajectory}")
        return "\n".join(lines)
