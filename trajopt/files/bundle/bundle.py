"""Bundle: what a file holds of a problem and of what became of it."""

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
"""Of the format. Later versions of trajopt read all earlier ones; what is newer is refused."""
SUFFIX = ".trajopt"
"""What the names of bundles end in."""
DESCRIPTION, PROBLEM, ARGUMENTS, ANSWER, MOTION, EXPLANATION, URDF = (
    *("bundle.json", "problem.json", "arguments.json", "answer.json", "motion.json"),
    *("explanation.json", "robot.urdf"),
)
"""The documents of a bundle; arrays are in `arrays/`, meshes in `meshes/`."""


class Holds(Enum):
    """What a bundle holds; each value says it."""

    PLAN = "a plan"
    FAILURE = "a problem that planning did not solve"
    PROBLEM = "a problem"


@dataclass(frozen=True, eq=False, kw_only=True)
class Bundle(Value):
    """What a bundle's file holds.

    Attributes:
        path: The file.
        holds: What it is.
        made: When it was written (UTC, as ISO 8601 has it).
        versions: Of Python, trajopt and what it stands on, by name, when it was written.
        problem: The problem, with robot and scene.
        arguments: How planning was called; None of a problem that was not planned, or where it is not known.
        method: The method that planned, in words; empty where none did.
        custom_method: Whether it was given as an object with options of its own, which no file holds.
        trajectory: The motion, verified or not; None where planning did not get so far.
        path_planned: Its path without time; None where planning did not get so far.
        answer: What planning answered, as `Result.as_dict` says it.
        explanation: What `Result.explain` said, as plain data; empty where nothing was explained.
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
        """The name of the status with which planning ended; empty where nothing was planned."""
        return str(self.answer.get("status", ""))

    def require(self) -> Trajectory:
        """Return the motion.

        Raises:
            ModelError: If the bundle holds none.
        """
        if self.trajectory is None:
            raise ModelError(f"{self.path} holds {self.holds.value}, and no motion")
        return self.trajectory

    def judged(self) -> Certificate:
        """Judge the motion anew: of what the file says of itself nothing is believed.

        Raises:
            ModelError: If the bundle holds no motion.
        """
        return judge(self.problem, self.require())

    def __repr__(self) -> str:
        """Say what it holds."""
        return f"Bundle({shown(self.problem.name)}: {self.holds.value})"

    def __str__(self) -> str:
        """Return what was asked, what was answered, and by which versions."""
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
