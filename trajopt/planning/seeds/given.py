"""Paths of the caller as seeds, for example of a motion that solved a similar problem."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from trajopt.planning.seeds.source import Blocked, GivenSeed, MakeSeed, SeedContext, SeedKind, with_knots
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats, floats, readonly, sequence
from trajopt.values.errors import JointNotFound, ProblemError
from trajopt.values.trajectory import Path, Trajectory

SeedLike: TypeAlias = Path | Trajectory | ArrayLike
"""A path, a motion whose path is meant, or knots of the group's joints, shape (k, n) [rad | m]."""


def stated_seeds(problem: Problem, seeds: Sequence[SeedLike]) -> tuple[Floats, ...]:
    """Return the knots of the seeds that a caller passes, in the order of the group's joints, (k, n) each.

    Raises:
        ProblemError: If a seed is not a path, or the problem has waypoints, whose places on a path
            are unknown.
        JointNotFound: If a path does not name a joint of the group.
        ShapeError: If the knots do not fit the group's joints, are fewer than two, or not finite.
    """
    given = sequence("seeds", seeds)
    if given and problem.waypoints:
        raise ProblemError("seeds do not say where they pass the waypoints: leave one of both out")
    return tuple(_knots(problem, f"seeds[{number}]", each) for number, each in enumerate(given))


def _knots(problem: Problem, name: str, seed: SeedLike) -> Floats:
    joints = problem.reduced.joint_names
    if isinstance(seed, Trajectory):
        seed = Path(seed.joint_names, seed.positions)
    if isinstance(seed, Path):
        for joint in joints:
            if joint not in seed.joint_names:
                raise JointNotFound(f"joint of {name}", joint, seed.joint_names)
        seed = seed.knots[:, [seed.joint_names.index(joint) for joint in joints]]
    knots = floats(name, seed, (None, len(joints)))
    if len(knots) < 2:
        raise ProblemError(f"{name} needs at least two knots")
    return knots


@dataclass(frozen=True, eq=False)
class GivenPaths:
    """The `SeedSource` of given paths, each moved so that it leads from the start to a goal configuration.

    Attributes:
        paths: Their knots, shape (k, n) each.
    """

    paths: tuple[Floats, ...]
    kind: SeedKind = SeedKind.GIVEN

    def seeds(
        self, context: SeedContext, blocked: Sequence[Blocked], rng: np.random.Generator
    ) -> Iterator[MakeSeed]:
        """Yield one for each path, to the goal configuration nearest to its end; see `Source.seeds`."""
        del blocked, rng
        start, ends = context.line.knots[0], context.ends
        for path in self.paths:
            knots = with_knots(path, len(context.line.knots))
            goal = ends[np.abs(ends - knots[-1]).max(axis=1).argmin()]
            share = np.linspace(0.0, 1.0, len(knots))[:, None]
            moved = knots + (1.0 - share) * (start - knots[0]) + share * (goal - knots[-1])
            moved[0], moved[-1] = start, goal  # to the last digit
            yield GivenSeed(readonly(moved))
