"""Campaign: a table of problems, and of how each is planned."""

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from trajopt.files.bundle.bundle import versions
from trajopt.lab.campaign.recipes import Packer, digest, written
from trajopt.lab.campaign.sources import ProblemSource
from trajopt.optimise.methods import method_named
from trajopt.planning.budget import Budget
from trajopt.planning.plan import plan
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.values.arrays import positive, several
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked


@checked
@dataclass(frozen=True)
class Options:
    """Method, options and budget, as plain data.

    Attributes:
        improve: Whether to search for a motion shorter than along its path.
        seconds: CPU time of one problem [s]; results then depend on the machine.
        work: Number of configurations that one problem may evaluate.
    """

    method: str | None = None
    improve: bool = False
    every_goal: bool = False
    seconds: float | None = None
    work: int | None = None
    attempts: int | None = None

    def __post_init__(self) -> None:
        if self.method is not None:
            method_named(self.method)
        _ = self.budget

    @property
    def budget(self) -> Budget:
        """The bounds as a budget of CPU time."""
        return Budget(self.seconds, self.work, self.attempts, clock=time.process_time)

    def plan(self, problem: Problem, seed: int) -> Result:
        """Plan a problem with these options; seed 0 is the default of `plan`."""
        return plan(
            problem,
            method=self.method,
            improve=self.improve,
            every_goal=self.every_goal,
            budget=self.budget,
            rng=np.random.default_rng(seed) if seed else None,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the non-default options, as plain data for JSON."""
        changed = (item for item in fields(self) if getattr(self, item.name) != item.default)
        return {item.name: getattr(self, item.name) for item in changed}


DEFAULT_OPTIONS = (Options(),)
LONGEST = 300.0
"""Wall-clock time after which a problem counts as hanging [s]."""
SYSTEM = frozenset({"python", "machine"})


@dataclass(frozen=True)
class CampaignTask:
    """A row to be planned: a problem with its options.

    Attributes:
        problem_id: Hash of the problem's contents and of the seed.
        robot: Empty if unknown before the problem is made.
        recipe: As JSON.
    """

    id: str
    problem_id: str
    family: str
    number: int
    robot: str
    seed: int
    options: int
    recipe: str
    parameters: Mapping[str, float]


@checked
@dataclass(frozen=True, eq=False)
class Campaign:
    """A table of problems, each planned with all options.

    Attributes:
        seeds: Seeds of planning for each problem; 0 is the default of `plan`.
        most_seconds: Wall-clock time after which a problem counts as hanging, and is ended [s].
    """

    name: str
    sources: Sequence[ProblemSource]
    options: Sequence[Options] = DEFAULT_OPTIONS
    seeds: Sequence[int] = (0,)
    most_seconds: float = LONGEST

    def __post_init__(self) -> None:
        for label, kind in (("sources", ProblemSource), ("options", Options), ("seeds", int)):
            object.__setattr__(self, label, several(label, getattr(self, label), kind))
            if not getattr(self, label):
                raise ProblemError(f"{label} is empty: there is nothing to plan")
        if min(self.seeds) < 0:
            raise ProblemError(f"seeds must not be negative, one is {min(self.seeds)}")
        positive("most_seconds", self.most_seconds)

    def __len__(self) -> int:
        return sum(source.count for source in self.sources) * len(self.options) * len(self.seeds)

    def __repr__(self) -> str:
        return f"Campaign({self.name!r}, {len(self)} rows)"

    def tasks(self, packer: Packer) -> Iterator[CampaignTask]:
        """Yield the task of each future row, always in the same way; shared values are packed."""
        stood = {name: each for name, each in versions().items() if name not in SYSTEM}
        ways = [each.as_dict() for each in self.options]
        for source in self.sources:
            for posed in source.pose(packer):
                text = written(posed.recipe)
                for seed in self.seeds:
                    problem_id = digest(text, seed)
                    for place, way in enumerate(ways):
                        yield CampaignTask(
                            id=digest(problem_id, way, stood),
                            problem_id=problem_id,
                            family=posed.family,
                            number=posed.number,
                            robot=posed.robot,
                            seed=seed,
                            options=place,
                            recipe=text,
                            parameters=posed.parameters,
                        )

    def as_dict(self) -> dict[str, Any]:
        """Return the data common to all rows, as plain data for JSON."""
        return {
            "name": self.name,
            "options": [each.as_dict() for each in self.options],
            "seeds": list(self.seeds),
            "most_seconds": self.most_seconds,
            "versions": dict(versions()),
        }
