"""The source of a campaign named on the command line."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np

from trajopt.cli.options import read_files
from trajopt.files.moveit import read_scene
from trajopt.lab.campaign import (
    ProblemSource,
    base_placements,
    from_folder,
    from_table,
    installed,
    perturbed,
    random_motions,
)
from trajopt.lab.suite import definitions
from trajopt.problem.problem import Problem
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.errors import NameNotFound, ProblemError

TABLE = ".parquet"
"""Suffix of a table of problems."""


class Generated(Enum):
    """Names of sources that generate problems, in addition to installed problems."""

    RANDOM = "random"
    PERTURBED = "perturbed"
    PLACEMENTS = "placements"


@dataclass(frozen=True)
class Words:
    """The source as given on the command line.

    Attributes:
        source: A folder, a table, or the name of a generated or installed source.
        robot: The robot, or None.
        scene: MoveIt's scene.
        requests: MoveIt's requests.
        group: The group that moves.
        count: Number of drawn problems.
        seed: Of the random generator.
        shift: Largest shift of an object along each axis [m].
        turn: Largest turn of an object about the vertical [rad].
        grid: Places of the base by axis [m, rad].
        sets: Sets of a folder.
        limit: Largest number of problems of each set of a folder.
    """

    source: str
    robot: Robot | None
    scene: Path | None
    requests: tuple[Path, ...]
    group: str
    count: int
    seed: int
    shift: float
    turn: float
    grid: Mapping[str, tuple[float, float, int]]
    sets: Sequence[str]
    limit: int | None

    def made(self) -> ProblemSource:
        """Return the source.

        Raises:
            NameNotFound: If there is neither a folder nor a source of that name.
            ProblemError: If a needed option is missing.
            FileFormatError: If a file is invalid.
        """
        if Path(self.source).is_dir():
            return from_folder(self.source, self._robot(), sets=self.sets, limit=self.limit)
        if Path(self.source).suffix == TABLE:
            return from_table(self.source, self._around(), group=self.group)
        match self.source:
            case Generated.RANDOM.value:
                around = self._around()
                return random_motions(around, self.count, group=self.group, seed=self.seed)
            case Generated.PERTURBED.value:
                (problem,) = self._problems(most=1)
                return perturbed(problem, self.count, shift=self.shift, turn=self.turn, seed=self.seed)
            case Generated.PLACEMENTS.value:
                places = {axis: steps(*range_) for axis, range_ in self.grid.items()}
                return base_placements(self._problems(), **places)
            case _:
                names = [item.name for item in definitions()]
                if self.source not in names:
                    known = [*(each.value for each in Generated), *names]
                    raise NameNotFound("folder, generator or installed problem", self.source, known)
                return installed(self.source, self.count)

    def _robot(self) -> Robot:
        if self.robot is None:
            raise ProblemError(f"{self.source} needs a robot: name one with --robot")
        return self.robot

    def _around(self) -> Scene:
        robot = self._robot()
        return Scene(robot) if self.scene is None else read_scene(self.scene, robot).scene

    def _problems(self, most: int | None = None) -> tuple[Problem, ...]:
        if self.scene is None or not self.requests:
            raise ProblemError(f"{self.source} needs what is asked: give --scene and --request")
        if most is not None and len(self.requests) > most:
            raise ProblemError(f"{self.source} takes {most} --request, {len(self.requests)} are given")
        robot = self._robot()
        return tuple(read_files(robot, self.scene, each)[1].problem() for each in self.requests)


def steps(first: float, last: float, count: int) -> tuple[float, ...]:
    """Return evenly spread numbers, both ends included.

    Raises:
        ProblemError: If the count is not positive.
    """
    if count < 1:
        raise ProblemError(f"a grid needs at least one step, {count} are given")
    return tuple(float(value) for value in np.linspace(first, last, count))
