"""Numbers in a likely wrong unit: degrees for radians, millimetres for metres.

A plausible number is accepted with a warning; the error of a refused one suggests the likely unit.
"""

from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import Floats, floats, number, one_of, readonly
from trajopt.values.errors import shown, warn_of_unit

WHOLE_TURN = 6.3
"""Two pi, rounded up [rad]: an orientation never needs a larger angle."""
SHARE = 0.05
"""A value out of range is likely in the smaller unit if it then fits and uses at least this share of the
range.
"""
FARTHEST_OBJECT = 50.0
"""Objects farther away are likely placed in millimetres [m]; the largest size of shapes."""

FAR_APART = 4.0
"""Larger clearances are likely in millimetres [m]: no arm reaches that far."""

WIDE_MESH = 20.0
"""Wider meshes are likely in millimetres [m]: a 20 mm part read in metres, and robot cells are narrower."""
WIDE = 2.0
"""Larger tolerances are likely in millimetres [m]: they cover the whole workspace of an arm."""
FASTEST = {"m/s": 10.0, "rad/s": 30.0}
"""Larger speed limits are likely in the smaller unit: no arm moves its tool that fast."""
DEEP = 1.0
"""If an arm is deeper inside an object, its size or position is likely in millimetres [m]."""


def stated_angle(
    name: str, value: float | None, *, degrees: bool, default: float | None = None, infinite: bool = False
) -> float:
    """Return an angle [rad] that is given in radians or degrees, or the default [rad] for None."""
    one_of("degrees", degrees, bool)
    if value is None and default is not None:
        return default
    given = number(name, cast("float", value), infinite=infinite)
    return float(np.deg2rad(given)) if degrees else given


def stated_angles(
    name: str, value: ArrayLike, shape: Sequence[int | None], *, degrees: bool, infinite: bool = False
) -> Floats:
    """Return angles of an orientation [rad] that are given in radians or degrees."""
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
    """Suggest the likely unit of a joint position beyond its limits [rad | m]; empty without a likely one."""
    beyond = max(lower - value, value - upper)
    if unit == "rad" and beyond > WHOLE_TURN and lower <= np.deg2rad(value) <= upper:
        return f"; were degrees meant? {joint} at {value:g} deg is inside (degrees=True takes degrees)"
    if unit == "m" and beyond > SHARE * 1e3 * (upper - lower) and lower <= value / 1e3 <= upper:
        return f"; were millimetres meant? {joint} at {value:g} mm is inside (lengths are in metres)"
    return ""


def meant_at_distance(distance: float, room: float) -> str:
    """Suggest millimetres for a place at a distance [m] beyond the largest possible; empty if unlikely."""
    if SHARE * room <= distance / 1e3 <= room:
        return "; were millimetres meant? Lengths are in metres"
    return ""


def meant_at_speed(speed: float, limit: float, unit: str) -> str:
    """Suggest degrees or millimetres for a speed beyond its limit; empty if that is unlikely."""
    name, size = ("degrees", np.degrees(1.0)) if unit.startswith("rad") else ("millimetres", 1e3)
    if SHARE * limit <= speed / size <= limit:
        return f"; were {name} meant? It is given in {unit}"
    return ""


def warn_of_far_object(name: str, xyz: Floats) -> None:
    """Warn of an object that is farther away than the largest shape."""
    if float(np.linalg.norm(xyz)) > FARTHEST_OBJECT:
        metres, fewer = (", ".join(f"{value:g}" for value in (size * xyz).tolist()) for size in (1.0, 1e-3))
        warn_of_unit(f"{name} is ({metres}) m: were millimetres meant? Lengths are in metres: ({fewer})")


def warn_of_wide_mesh(name: str, vertices: Floats) -> None:
    """Warn of a mesh wider than a robot cell."""
    width = float(np.ptp(vertices, axis=0).max(initial=0.0)) if len(vertices) else 0.0
    if width > WIDE_MESH:
        warn_of_unit(f"{name} is {width:g} m wide: were millimetres meant? Then load_mesh(path, scale=0.001)")


def warn_of_far_apart(name: str, distance: float) -> None:
    """Warn of a clearance [m] that no arm can keep from its work."""
    if distance >= FAR_APART:
        warn_of_unit(
            f"{name} is {distance:g} m: were millimetres meant? Lengths are in metres: {distance / 1e3:g}"
        )


def meant_at_depth(depth: float) -> str:
    """Suggest millimetres for an object that the arm is deep inside [m]; empty if that is unlikely."""
    return "; were millimetres meant? Lengths are in metres" if depth > DEEP else ""


def warn_of_wide_tolerance(name: str, tolerance: ArrayLike) -> None:
    """Warn of a tolerance [m] that covers the whole reach of an arm; infinite ones are accepted."""
    given = np.asarray(tolerance, dtype=np.float64)
    wide = given[np.isfinite(given) & (given >= WIDE)]
    if wide.size:
        metres = float(wide.max())
        warn_of_unit(
            f"{name} is {metres:g} m: were millimetres meant? Lengths are in metres: {metres / 1e3:g}"
        )


def warn_of_fast_limit(name: str, limit: float, unit: str) -> None:
    """Warn of a speed limit ("m/s" or "rad/s") that no arm comes near."""
    if FASTEST[unit] <= limit < np.inf:
        meant = f"millimetres meant? Speeds are in m/s: {limit / 1e3:g}"
        if unit == "rad/s":
            meant = "degrees meant? degrees=True takes deg/s"
        warn_of_unit(f"{name} is {limit:g} {unit}: were {meant}")
