"""Requirements on points: in regions, on planes, on lines and on arcs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.requirement import MILLIMETRES, Relaxation, Requirement
from trajopt.values.arrays import LARGEST_SIZE, Floats, direction_of, floats, positive, sequence
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angle
from trajopt.values.placement import IDENTITY, WORLD, Placement, PlacementLike, as_placement
from trajopt.values.printed import in_axis, in_degrees, in_length, in_point, in_stated_angle, seen_from
from trajopt.values.shapes.shapes import Box, Cylinder, Plane, Sphere

Region = Box | Sphere | Cylinder | Plane
"""Shapes of a region; `Plane` is the half-space below its plane z = 0."""

Member = tuple[Region, Placement]
"""A shape and its placement in the region's reference."""


@dataclass(frozen=True, eq=False)
class PositionInRegion(Requirement):
    """A point of a frame is inside at least one of several convex shapes.

    Made by `position_in_region`: `members` are the shapes with their placements in `reference`.
    """

    frame: str
    members: tuple[Member, ...]
    reference: str
    offset: Floats

    @property
    def units(self) -> tuple[str, ...]:
        return ("m",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        what = f"region of {self.frame} grown on every side"
        return (Relaxation(what=what, now=0.0, largest=1.0, unit=MILLIMETRES, apply=self._grown),)

    def _grown(self, amount: float) -> PositionInRegion:
        return replace(self, members=tuple(_grown(shape, where, amount) for shape, where in self.members))

    def __str__(self) -> str:
        inside = " or ".join(_in_words(shape, where) for shape, where in self.members)
        return f"{self.frame} {inside}{seen_from(self.reference)}"


@checked
def position_in_region(
    frame: str,
    region: Region | Sequence[tuple[Region, PlacementLike]],
    placement: PlacementLike | None = None,
    *,
    reference: str = WORLD,
    offset: ArrayLike = (0.0, 0.0, 0.0),
) -> PositionInRegion:
    """Require a point of a frame to be inside a box, sphere, cylinder or half-space, or a union of them.

    The optimiser keeps the point inside the nearest member, chosen at every linearisation, with a margin of a
    tenth of its size, at most 5 mm: members between which the point passes should overlap by more than that.

    Args:
        frame: Link, tool frame or attached object.
        region: One shape, or several with their placements.
        placement: Placement of the whole region in `reference`; identity by default.
        reference: "world", or the frame in which the region is placed; it may move.
        offset: Point in the frame's coordinates, shape (3,) [m].

    Raises:
        ProblemError: If there is no shape, or a shape of another kind.
        ShapeError: If a number is not usable.
    """
    given = [(region, IDENTITY)] if isinstance(region, Region) else sequence("region", region)
    if not given:
        raise ProblemError(f"position_in_region({shown(frame)}): the region has no shape")
    for member in given:
        shape = member[0] if isinstance(member, tuple) else member  # pyright: ignore
        if not isinstance(shape, Region):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise ProblemError(
                f"position_in_region({shown(frame)}): {shown(shape)} is not a Box, Sphere, Cylinder or Plane"
            )
    base = IDENTITY if placement is None else as_placement("placement", placement)
    members = tuple((shape, base * as_placement("placement in the region", where)) for shape, where in given)
    return PositionInRegion(frame, members, reference, floats("offset", offset, (3,)))


@checked
def point_on_line(
    frame: str,
    through: ArrayLike,
    direction: ArrayLike,
    *,
    tolerance: float,
    length: float | None = None,
    reference: str = WORLD,
    offset: ArrayLike = (0.0, 0.0, 0.0),
) -> PositionInRegion:
    """Require a point of a frame on a line or segment, modelled as a thin cylinder.

    Args:
        frame: Link, tool frame or attached object.
        through: Point of the line, or the middle of the segment, in `reference`, shape (3,) [m].
        direction: Direction of the line in `reference`, shape (3,), any length but zero.
        tolerance: Largest distance from the line [m].
        length: Length of the segment [m]; 50 m by default.
        reference: "world", or the frame in which the line is given.
        offset: Point in the frame's coordinates, shape (3,) [m].

    Raises:
        ShapeError: If a number is not usable, or the direction has no length.
        ProblemError: If the tolerance is not positive.
    """
    tube = Cylinder(positive("tolerance", tolerance), LARGEST_SIZE if length is None else length)
    where = Placement(_upright(direction_of("direction", direction)), floats("through", through, (3,)))
    return position_in_region(frame, tube, where, reference=reference, offset=offset)


@checked
def point_on_plane(
    frame: str,
    through: ArrayLike,
    normal: ArrayLike,
    *,
    tolerance: float,
    reference: str = WORLD,
    offset: ArrayLike = (0.0, 0.0, 0.0),
) -> PositionInRegion:
    """Require a point of a frame on a plane, modelled as a thin slab 50 m wide.

    Args:
        frame: Link, tool frame or attached object.
        through: Point of the plane in `reference`, shape (3,) [m].
        normal: Normal of the plane in `reference`, shape (3,), any length but zero.
        tolerance: Largest distance from the plane, to either side [m].
        reference: "world", or the frame in which the plane is given.
        offset: Point in the frame's coordinates, shape (3,) [m].

    Raises:
        ShapeError: If a number is not usable, or the normal has no length.
        ProblemError: If the tolerance is not positive.
    """
    slab = Box(LARGEST_SIZE, LARGEST_SIZE, 2.0 * positive("tolerance", tolerance))
    where = Placement(_upright(direction_of("normal", normal)), floats("through", through, (3,)))
    return position_in_region(frame, slab, where, reference=reference, offset=offset)


def _grown(shape: Region, where: Placement, amount: float) -> Member:

    def larger(size: float, by: float) -> float:
        return min(size + by, LARGEST_SIZE)

    match shape:
        case Box():
            return Box(*(larger(edge, 2.0 * amount) for edge in (shape.x, shape.y, shape.z))), where
        case Sphere():
            return Sphere(larger(shape.radius, amount)), where
        case Cylinder():
            return Cylinder(larger(shape.radius, amount), larger(shape.length, 2.0 * amount)), where
        case Plane():
            return shape, where * Placement(np.eye(3), np.array((0.0, 0.0, amount)))


def _upright(axis: Floats) -> Floats:
    aside = np.zeros(3)
    aside[np.argmin(np.abs(axis))] = 1.0
    x = direction_of("x", np.cross(aside, axis))
    return floats("axes", np.stack((x, np.cross(axis, x), axis), axis=1), (3, 3))


def _in_words(shape: Region, where: Placement) -> str:
    through, axis = in_point(where.translation), in_axis(where.rotation[:, 2])
    match shape:
        case Box(x=x, y=y) if x == y == LARGEST_SIZE:
            return f"on the plane through {through} with normal {axis}, within {in_length(0.5 * shape.z)}"
        case Box():
            edges = " x ".join(in_length(edge) for edge in (shape.x, shape.y, shape.z))
            return f"in a box of {edges} at {where}"
        case Sphere():
            return f"in a sphere of radius {in_length(shape.radius)} at {through}"
        case Cylinder() if shape.length == LARGEST_SIZE:
            return f"on the line through {through} along {axis}, within {in_length(shape.radius)}"
        case Cylinder():
            size = f"radius {in_length(shape.radius)} and length {in_length(shape.length)}"
            return f"in a cylinder of {size} along {axis} at {through}"
        case Plane():
            return f"below the plane through {through} with normal {axis}"


@dataclass(frozen=True, eq=False)
class PointOnArc(Requirement):
    """A point of a frame is within a distance of an arc.

    Fields: arguments of `point_on_arc`.
    """

    frame: str
    centre: Placement
    radius: float
    sweep: float
    tolerance: float
    reference: str
    offset: Floats

    @property
    def units(self) -> tuple[str, ...]:
        return ("m",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        return (
            self.relaxed(
                "tolerance",
                f"distance of {self.frame} from the arc",
                0.99 * self.radius - self.tolerance,
                MILLIMETRES,
            ),
        )

    def __str__(self) -> str:
        whole = self.sweep >= 2.0 * np.pi - 1e-9
        shape = "a circle" if whole else f"an arc of {in_degrees(self.sweep)}"
        where = f"{self.centre}{seen_from(self.reference)}"
        on = f"{self.frame} on {shape} of radius {in_length(self.radius)} about {where}"
        return f"{on}, within {in_length(self.tolerance)}"


@checked
def point_on_arc(
    frame: str,
    centre: PlacementLike,
    *,
    radius: float,
    tolerance: float,
    sweep: float | None = None,
    reference: str = WORLD,
    offset: ArrayLike = (0.0, 0.0, 0.0),
    degrees: bool = False,
) -> PointOnArc:
    """Require a point of a frame on an arc.

    Args:
        centre: Placement of the circle in `reference`: about its z axis, the arc begins on its x
            axis and turns towards y.
        radius: Radius of the circle [m].
        tolerance: Largest distance from the arc, less than the radius [m].
        sweep: Angle of the arc, in (0, 2 pi] [rad]; the whole circle by default.
        reference: "world", or the frame in which the circle is placed; it may move.
        offset: Point in the frame's coordinates, shape (3,) [m].

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: If radius, tolerance or sweep is out of its range.
    """
    size, within = positive("radius", radius), positive("tolerance", tolerance)
    if within >= size:
        raise ProblemError(
            f"tolerance must be less than the radius {in_length(size)}, is {in_length(within)}"
        )
    angle = stated_angle("sweep", sweep, degrees=degrees, default=2.0 * np.pi)
    if not 0.0 < angle <= 2.0 * np.pi:
        raise ProblemError(f"sweep must lie in (0, 2 pi] rad, is {in_stated_angle(angle, degrees=degrees)}")
    where = as_placement("centre", centre)
    return PointOnArc(frame, where, size, angle, within, reference, floats("offset", offset, (3,)))
