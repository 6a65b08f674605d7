"""What a random problem asks, as plain numbers, with formulas of its own."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

import trajopt as to
from tests.fuzz.random_problems.chain import Chain
from trajopt.values.arrays import Floats


class Asked(Protocol):
    """A requirement: how it is asked of trajopt, and by how much a motion breaks it."""

    def requirement(self) -> to.Requirement:
        """Ask it."""
        ...

    def excess(self, chain: Chain, positions: Floats, places: Mapping[str, Floats]) -> Floats:
        """By how much it is broken at each time, shape (t,); at most 0 where it holds."""
        ...


@dataclass(frozen=True, eq=False)
class Joints:
    """Joints near positions."""

    at: Mapping[str, float]
    below: Mapping[str, float]
    above: Mapping[str, float]

    def requirement(self) -> to.Requirement:
        return to.joint_positions(self.at, tolerance=0.0, below=self.below, above=self.above)

    def excess(self, chain: Chain, positions: Floats, places: Mapping[str, Floats]) -> Floats:
        names = [joint.name for joint in chain.moving]
        values = chain.all_joints(positions)
        off = [values[:, names.index(name)] - at for name, at in self.at.items()]
        sides = [
            np.maximum(-d - self.below[name], d - self.above[name])
            for name, d in zip(self.at, off, strict=True)
        ]
        return np.max(sides, axis=0)


def near(at: Mapping[str, float], tolerance: float) -> Joints:
    """The same tolerance for all, to both sides."""
    same = dict.fromkeys(at, tolerance)
    return Joints(at, same, same)


@dataclass(frozen=True, eq=False)
class Coupled:
    """A weighted sum of joints near a value."""

    weights: Mapping[str, float]
    value: float
    tolerance: float

    def requirement(self) -> to.Requirement:
        return to.coupled_joints(self.weights, self.value, tolerance=self.tolerance)

    def excess(self, chain: Chain, positions: Floats, places: Mapping[str, Floats]) -> Floats:
        names = [joint.name for joint in chain.moving]
        values = chain.all_joints(positions)
        total = sum(weight * values[:, names.index(name)] for name, weight in self.weights.items())
        return np.abs(total - self.value) - self.tolerance


@dataclass(frozen=True, eq=False)
class Spot:
    """A point of a link near a point of the world, by axis."""

    link: str
    point: Floats
    tolerance: float

    def requirement(self) -> to.Requirement:
        where = to.placement(self.point)
        return to.frame_placement(
            self.link, where, position_tolerance=self.tolerance, rotation_tolerance=np.inf
        )

    def excess(self, chain: Chain, positions: Floats, places: Mapping[str, Floats]) -> Floats:
        return np.abs(places[self.link][:, :3, 3] - self.point).max(axis=1) - self.tolerance


@dataclass(frozen=True, eq=False)
class Within:
    """The origin of a link inside an upright box of the world."""

    link: str
    low: Floats
    high: Floats

    def requirement(self) -> to.Requirement:
        middle = to.placement((self.low + self.high) / 2.0)
        return to.position_in_region(self.link, to.Box(*(self.high - self.low)), middle)

    def excess(self, chain: Chain, positions: Floats, places: Mapping[str, Floats]) -> Floats:
        points = places[self.link][:, :3, 3]
        return np.maximum(self.low - points, points - self.high).max(axis=1)


@dataclass(frozen=True, eq=False)
class Pointing:
    """An axis of a link along a direction of the world, within a cone."""

    link: str
    axis: Floats
    direction: Floats
    cone: float

    def requirement(self) -> to.Requirement:
        return to.axis_alignment(self.link, axis=self.axis, direction=self.direction, tolerance=self.cone)

    def excess(self, chain: Chain, positions: Floats, places: Mapping[str, Floats]) -> Floats:
        along = places[self.link][:, :3, :3] @ (self.axis / np.linalg.norm(self.axis))
        direction = self.direction / np.linalg.norm(self.direction)
        sine = np.linalg.norm(np.cross(along, direction), axis=1)
        return np.arctan2(sine, along @ direction) - self.cone


@dataclass(frozen=True, eq=False)
class Apart:
    """The origins of two links at a distance."""

    first: str
    second: str
    lower: float
    upper: float

    def requirement(self) -> to.Requirement:
        return to.distance_between(self.first, self.second, lower=self.lower, upper=self.upper)

    def excess(self, chain: Chain, positions: Floats, places: Mapping[str, Floats]) -> Floats:
        between = np.linalg.norm(places[self.first][:, :3, 3] - places[self.second][:, :3, 3], axis=1)
        return np.maximum(self.lower - between, between - self.upper)
