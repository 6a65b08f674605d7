"""Numbers that are likely in another unit: degrees given for radians, millimetres for metres.

What can be meant as it is given is taken, with a warning; where it is refused anyway, the refusal says what
was likely meant.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import Floats, floats, number, one_of, readonly
from trajopt.values.errors import shown, warn_of_unit

WHOLE_TURN = 6.3
"""Two pi, rounded up. Angles that differ by whole turns are the same orientation: none has to be beyond one
[rad]."""
SHARE = 0.05
"""What does not fit was likely meant in the smaller unit if, in that, it fits and takes at least this share
of the room. Less of it is seldom meant, and far too many metres or radians are not so seldom."""
FARTHEST_OBJECT = 50.0
"""As far away as shapes may be large: objects beyond were likely placed in millimetres [m]."""

FAR_APART = 4.0
"""Distances to keep from this on were likely meant in millimetres: no arm reaches so far, so it would have no
room [m]."""

WIDE_MESH = 20.0
"""Meshes wider than this were likely drawn in millimetres: a part of 20 mm read as metres is so wide, and
robot cells are narrower [m]."""
WIDE = 2.0
"""Tolerances from this on were likely meant in millimetres: what may be as far off as the whole of an arm's
workspace is wide is not asked for [m]."""
FASTEST = {"m/s": 10.0, "rad/s": 30.0}
"""Limits of speed from these on were likely meant in the smaller unit: no arm moves its tool so fast, and
as a limit they would bind nothing."""
DEEP = 1.0
"""Deeper inside a thing than this an arm is where its size or place was likely meant in millimetres [m]."""


def stated_angle(
    name: str, value: float | None, *, degrees: bool, default: float = 0.0, infinite: bool = False
) -> float:
    """Return an angle [rad] that is given in radians or degrees, or the default [rad] where none is.

    Raises:
        ShapeError: If it is no number, or not finite where it must be.
        ProblemError: If `degrees` is neither true nor false.
    """
    one_of("degrees", degrees, bool)
    if value is None:
        return default
    given = number(name, value, infinite=infinite)
    return float(np.deg2rad(given)) if degrees else given


def stated_angles(
    name: str, value: ArrayLike, shape: Sequence[int | None], *, degrees: bool, infinite: bool = False
) -> Floats:
    """Return angles of an orientation [rad] that are given in radians or degrees.

    Raises:
        ShapeError: If they are not of the shape, or not finite where they must be.
        ProblemError: If `degrees` is neither true nor false.

    Warns:
        UnitWarning: If one is given in radians and is beyond a whole turn.
    """
    given = floats(name, value, shape, infinite=infinite)
    if one_of("degrees", degrees, bool):
        return readonly(np.deg2rad(given))
    finite = np.abs(given[np.isfinite(given)])
    if finite.size and finite.max() > WHOLE_TURN:
        each = shown(given[()]) if given.ndim == 0 else f"({', '.join(f'{angle:g}' for angle in given)})"
        warn_of_unit(
            f"{name} is {each} rad, beyond a whole turn: were degrees meant? degrees=True takes them"
        )
    return given


def meant_in_joint(joint: str, value: float, lower: float, upper: float, unit: str) -> str:
    """Say what the position of a joint beyond its limits was likely meant to be; empty if nothing is.

    Args:
        joint: The joint's name.
        value: The position [rad | m].
        lower: Its lower limit.
        upper: Its upper limit.
        unit: "rad" or "m".
    """
    beyond = max(lower - value, value - upper)
    if unit == "rad" and beyond > WHOLE_TURN and lower <= np.deg2rad(value) <= upper:
        return f"; were degrees meant? {joint} at {value:g} deg is inside (degrees=True takes degrees)"
    if unit == "m" and beyond > SHARE * 1e3 * (upper - lower) and lower <= value / 1e3 <= upper:
        return f"; were millimetres meant? {joint} at {value:g} mm is inside (lengths are in metres)"
    return ""


def meant_at_distance(distance: float, room: float) -> str:
    """Say that a place out of reach was likely meant in millimetres; empty where it was not.

    Args:
        distance: How far away it is [m].
        room: How far away it may be [m].
    """
    if SHARE * room <= distance / 1e3 <= room:
        return "; were millimetres meant? Lengths are in metres"
    return ""


def meant_at_speed(speed: float, limit: float, unit: str) -> str:
    """Say that a speed beyond its limit was likely meant in degrees or millimetres; empty where it was not.

    Args:
        speed: The speed or acceleration, positive.
        limit: Its limit.
        unit: Their unit, from radians or metres.
    """
    name, size = ("degrees", np.degrees(1.0)) if unit.startswith("rad") else ("millimetres", 1e3)
    if SHARE * limit <= speed / size <= limit:
        return f"; were {name} meant? It is given in {unit}"
    return ""


def warn_of_far_object(name: str, xyz: Floats) -> None:
    """Warn of an object that is farther away than any shape may be large.

    Args:
        name: What is placed.
        xyz: Where it is in its frame, shape (3,) [m].
    """
    if float(np.linalg.norm(xyz)) > FARTHEST_OBJECT:
        metres, fewer = (", ".join(f"{value:g}" for value in (size * xyz).tolist()) for size in (1.0, 1e-3))
        warn_of_unit(f"{name} is ({metres}) m: were millimetres meant? Lengths are in metres: ({fewer})")


def warn_of_wide_mesh(name: str, vertices: Floats) -> None:
    """Warn of a mesh that is wider than a robot cell.

    Args:
        name: Name of the object.
        vertices: Its corners, shape (n, 3) [m].
    """
    width = float(np.ptp(vertices, axis=0).max(initial=0.0)) if len(vertices) else 0.0
    if width > WIDE_MESH:
        warn_of_unit(f"{name} is {width:g} m wide: were millimetres meant? Then load_mesh(path, scale=0.001)")


def warn_of_far_apart(name: str, distance: float) -> None:
    """Warn of a distance to keep that no arm can keep from what it works on.

    Args:
        name: What is kept.
        distance: How far apart things shall stay [m].
    """
    if distance >= FAR_APART:
        warn_of_unit(
            f"{name} is {distance:g} m: were millimetres meant? Lengths are in metres: {distance / 1e3:g}"
        )


def meant_at_depth(depth: float) -> str:
    """Say that what an arm is deep inside of was likely meant in millimetres; empty where it was not.

    Args:
        depth: How deep [m].
    """
    return "; were millimetres meant? Lengths are in metres" if depth > DEEP else ""


def warn_of_wide_tolerance(name: str, tolerance: ArrayLike) -> None:
    """Warn of a tolerance that leaves a place free within all of an arm's reach.

    Args:
        name: What it is called.
        tolerance: One for all axes or one each [m]; infinite ones are meant so.
    """
    given = np.asarray(tolerance, dtype=np.float64)
    wide = given[np.isfinite(given) & (given >= WIDE)]
    if wide.size:
        metres = float(wide.max())
        warn_of_unit(
            f"{name} is {metres:g} m: were millimetres meant? Lengths are in metres: {metres / 1e3:g}"
        )


def warn_of_fast_limit(name: str, limit: float, unit: str) -> None:
    """Warn of a limit of speed that no arm comes near.

    Args:
        name: What is limited.
        limit: The limit; inf for none.
        unit: "m/s" or "rad/s".
    """
    if FASTEST[unit] <= limit < np.inf:
        meant = f"millimetres meant? Speeds are in m/s: {limit / 1e3:g}"
        if unit == "rad/s":
            meant = "degrees meant? degrees=True takes deg/s"
        warn_of_unit(f"{name} is {limit:g} {unit}: were {meant}")
