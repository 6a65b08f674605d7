"""Kinds of seeds, and the protocol of a source of seeds of one kind."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from trajopt.geometry import Evaluator, WorkCounts
from trajopt.planning.seeds.waypoints import WaypointLine
from trajopt.problem.problem import Problem
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Value, floats, readonly, sequence
from trajopt.values.errors import JointNotFound, ProblemError
from trajopt.values.trajectory import Path, Trajectory


class SeedKind(Enum):
    """Source of a seed; each value is a phrase."""

    STRAIGHT = "the straight line to the nearest goal configuration"
    BRANCH = "the straight line to another goal configuration"
    FREE_END = "the straight line, with the goal configuration free to change"
    AROUND = "the line bent around what blocked an earlier attempt"
    BUMP = "the line bent to a random side"
    GIVEN = "a path that was given or remembered"
    RUNNING = "what is left of the running motion"
    SAMPLED = "the path of a sampling planner, shortened"


Check = Callable[[], None]
"""Called between pieces of work; raises when it is time to stop."""
MakeSeed = Callable[[WorkCounts, Check], Floats]
"""Makes the knots of a seed, shape (N, n); counts its work. Raises `NoSeed` if it cannot."""


class NoSeed(Exception):
    """A source could not make a seed; the message states the reason."""


@dataclass(frozen=True, eq=False)
class SeedContext(Value):
    """Input of a source of seeds.

    Attributes:
        scale: A step of ordinary size in each joint, shape (n,) [rad | m].
        other_ends: Goal configurations that a seed may lead to instead of the line's, each of shape (n,).
    """

    problem: Problem
    line: WaypointLine
    scale: Floats
    other_ends: tuple[Floats, ...] = ()

    @property
    def reduced(self) -> ReducedModel:
        return self.problem.reduced

    def query(self, counts: WorkCounts) -> Evaluator:
        """Return an evaluator of the robot among its surroundings, which adds its work to the counts."""
        return self.problem.evaluator(self.reduced, counts)

    @property
    def ends(self) -> Floats:
        """Goal configurations that a seed may lead to, the line's first, shape (g, n)."""
        return np.stack((self.line.knots[-1], *self.other_ends))


@dataclass(frozen=True, eq=False)
class Blocked(Value):
    """Contact that ended an attempt.

    Attributes:
        knots: Last knots of the solver, shape (N, n).
        place: Place of the worst violation along them, in knots.
    """

    knots: Floats
    place: float
    pair: int


@dataclass(frozen=True, eq=False)
class GivenSeed(Value):
    """The `MakeSeed` of knots that are there already.

    Attributes:
        knots: Shape (N, n) [rad | m].
    """

    knots: Floats

    def __call__(self, counts: WorkCounts, check: Check) -> Floats:
        del counts, check
        return self.knots


def with_knots(knots: Floats, count: int) -> Floats:
    """Return a path (k, n) with another number of knots, evenly along it."""
    if len(knots) == count:
        return knots
    lengths = np.linalg.norm(np.diff(knots, axis=0), axis=1)
    along = np.concatenate((np.zeros(1), np.cumsum(lengths)))
    at = np.linspace(0.0, float(along[-1]), count)
    return np.stack([np.interp(at, along, knots[:, joint]) for joint in range(knots.shape[1])], axis=1)


class SeedSource(Protocol):
    """Makes seeds of one kind."""

    @property
    def kind(self) -> SeedKind:
        """Its kind."""
        ...

    def seeds(
        self, context: SeedContext, blocked: Sequence[Blocked], rng: np.random.Generator
    ) -> Iterator[MakeSeed]:
        """Yield seeds, each a function of its own: one that is not called costs nothing."""
        ...


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
        del blocked, rng
        start, ends = context.line.knots[0], context.ends
        for path in self.paths:
            knots = with_knots(path, len(context.line.knots))
            goal = ends[np.abs(ends - knots[-1]).max(axis=1).argmin()]
            share = np.linspace(0.0, 1.0, len(knots))[:, None]
            moved = knots + (1.0 - share) * (start - knots[0]) + share * (goal - knots[-1])
            moved[0], moved[-1] = start, goal  # to the last digit
            yield GivenSeed(readonly(moved))
