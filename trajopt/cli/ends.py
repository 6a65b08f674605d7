"""Start and goal of a motion from the command line, instead of a request in YAML."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from trajopt.cli.options import RobotSource
from trajopt.files.moveit import read_motions, read_scene
from trajopt.problem.problem import Problem
from trajopt.scene.scene import Scene
from trajopt.values.errors import ProblemError, shown
from trajopt.values.placement import Placement, placement

POSE = 6
"""Numbers of a placement: x, y, z, roll, pitch, yaw."""


@dataclass(frozen=True)
class Ends:
    """Start and goal as written: a state, numbers of joints, or joint=position.

    Attributes:
        start: The start.
        goal: The goal; six numbers are a placement of the group's tool: x y z roll pitch yaw.
        group: The planning group; may be empty for a robot with one group.
        degrees: Whether angles are in degrees instead of radians.
    """

    start: str
    goal: str
    group: str = ""
    degrees: bool = False

    def problem(self, scene: Scene) -> Problem:
        """Return the problem of moving from the start to the goal.

        Raises:
            ProblemError: If a word is neither a state nor a number nor joint=position.
            TrajoptError: If the problem is not well stated; see `Problem`.
        """
        numbers = _numbers(self.goal.split())
        goal: Placement | str | Sequence[float] | Mapping[str, float]
        if numbers is not None and len(numbers) == POSE:
            goal = placement(numbers[:3], rpy=numbers[3:], degrees=self.degrees)
        else:
            goal = _configuration("--goal", self.goal)
        start = _configuration("--start", self.start)
        return Problem(scene=scene, start=start, goal=goal, group=self.group, degrees=self.degrees)

    def as_dict(self) -> dict[str, object]:
        """Return plain data from which `from_dict` makes the same ends."""
        return {"start": self.start, "goal": self.goal, "group": self.group, "degrees": self.degrees}

    @staticmethod
    def from_dict(document: Mapping[str, object]) -> "Ends | None":
        """Return the ends that `as_dict` wrote; None if there are none."""
        start, goal = document.get("start"), document.get("goal")
        if not isinstance(start, str) or not isinstance(goal, str):
            return None
        return Ends(start, goal, str(document.get("group", "")), bool(document.get("degrees")))


def scene_around(source: RobotSource, scene: Path | None, motions: Path | None) -> tuple[Scene, list[str]]:
    """Return the robot in a scene, or alone, and notes on how files were read.

    Raises:
        FileFormatError: If a file is missing or malformed.
    """
    robot = source.load()
    read = None if scene is None else read_scene(scene, robot)
    around = Scene(robot) if read is None else read.scene
    notes = [*robot.notes, *(() if read is None else read.notes)]
    return around if motions is None else read_motions(motions, around), notes


def _configuration(option: str, text: str) -> str | list[float] | dict[str, float]:
    """Return the name of a state, positions of joints, or joint -> position."""
    words = text.split()
    if any("=" in word for word in words):
        return dict(_assigned(option, word) for word in words)
    numbers = _numbers(words)
    if numbers is not None:
        return numbers
    if len(words) != 1:
        raise ProblemError(
            f'{option} must be the name of a state, numbers ("0 0.5 ...") or joint=position, is {shown(text)}'
        )
    return text.strip()


def _assigned(option: str, word: str) -> tuple[str, float]:
    joint, _, value = word.partition("=")
    numbers = _numbers([value])
    if not joint or numbers is None:
        raise ProblemError(f"{option}: {shown(word)} is not joint=position, such as joint_1=0.5")
    return joint, numbers[0]


def _numbers(words: Sequence[str]) -> list[float] | None:
    """Return words as numbers; None if there are none or one is not a number."""
    try:
        return [float(word) for word in words] or None
    except ValueError:
        return None
