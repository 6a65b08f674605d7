"""Kinematics of all samples and rows of close pairs; see `trajopt.geometry`."""

from collections.abc import Callable
from typing import overload

import coal
import pinocchio as pin

from trajopt.native.descent import RobotDynamics, RobotQuery
from trajopt.values.arrays import Floats, Ints

class Solid:
    """Points of a shape's parts, its closed triangles, its corners if convex, or a cloud's centres."""

    def __init__(
        self, points: Floats, closed: Floats, geometry: coal.CollisionGeometry, cloud: Floats
    ) -> None: ...

class CloudCover:
    """Few boxes that contain a cloud; never changed."""

    def __init__(self, solid: Solid, cell: float, most: int) -> None: ...
    def axes(self) -> Floats: ...
    def pieces(self) -> tuple[Floats, Floats]: ...
    def cut(self, solid: Solid, chosen: Ints, edge: float, parts: int) -> CloudCover: ...
    def points_within(self, solid: Solid, chosen: Ints) -> Floats: ...

class Cell:
    """A robot among its obstacles; never changed, shared by threads."""

    def __init__(
        self,
        model: pin.Model,
        expand: Floats,
        offset: Floats,
        geometries: list[coal.CollisionGeometry],
        solids: list[Solid],
        joint: Ints,
        rotation: Floats,
        translation: Floats,
        centre: Floats,
        half: Floats,
        first: Ints,
        second: Ints,
        accuracy: tuple[float, float, float],
    ) -> None: ...

class Dynamics(RobotDynamics):
    """Inverse dynamics of many states."""

    def __init__(self, model: pin.Model, expand: Floats, offset: Floats) -> None: ...
    def torques(self, positions: Floats, velocities: Floats, accelerations: Floats) -> Floats: ...
    def slopes(
        self, positions: Floats, velocities: Floats, accelerations: Floats
    ) -> tuple[Floats, Floats, Floats]: ...
    def gravity(self, positions: Floats) -> tuple[Floats, Floats]: ...

class Query(RobotQuery):
    """What one thread asks a cell with."""

    @overload
    def __init__(self, cell: Cell) -> None: ...
    @overload
    def __init__(self, cell: Cell, stands_for: Ints, count: int) -> None: ...
    def close_pairs(
        self, positions: Floats, reach: Floats, aim: Floats
    ) -> tuple[Ints, Ints, Floats, Floats, Floats, Floats, Floats]: ...
    def placements(self, positions: Floats) -> tuple[Floats, Floats, Floats]: ...
    def displacement(self, start: Floats, end: Floats) -> Floats: ...
    def forget(self) -> None: ...
    @property
    def bounds(self) -> int: ...
    @property
    def distances(self) -> int: ...

def search_path(
    cell: Cell,
    start: Floats,
    goals: Floats,
    lower: Floats,
    upper: Floats,
    unit: Floats,
    reach: Floats,
    step: float,
    looks: int,
    shortening: int,
    seed: int,
    check: Callable[[int], None],
) -> tuple[Floats, bool, int, int, int]:
    """Corners of a clear path, whether exhausted, configurations looked at, bounds, calls of Coal."""
