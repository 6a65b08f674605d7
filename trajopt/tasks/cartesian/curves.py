"""Curves of a tool: straight lines, arcs, splines and polylines with rounded corners.

Between poses the rotation is about one axis at a constant rate (slerp).
"""

import csv
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import Floats, floats, number, readonly, sequence
from trajopt.values.curve import TURN_LENGTH, Curve, Piece, bezier, joined
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import FileFormatError, ProblemError, ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angle, stated_angles
from trajopt.values.placement import Placement, PlacementLike, as_placement, placement
from trajopt.values.printed import in_degrees, in_length

__all__ = [
    "Curve",
    "arc_about",
    "arc_through",
    "circle",
    "joined",
    "line",
    "polyline",
    "read_poses",
    "spline",
]

NOWHERE = 1e-9
"""Poses closer than this are equal [m | rad]."""
RADIUS_DIFFERENCE = 1e-3
"""Accepted difference of the distances of an arc's ends from its centre [m]; the centre is moved."""
COLLINEAR = 1e-5
"""Sine of the angle below which three points span no plane."""
ROUNDEST = 0.5
"""Largest part of the shorter side that a rounded corner may take."""
HANDLE = 0.6
"""Position of the last control point between the end of a rounding and the corner."""
FINE = 200
"""Number of chords that measure the length of a curved piece."""


def line(begin: PlacementLike, end: PlacementLike) -> Curve:
    """Return the straight line between two placements (Pilz's LIN).

    Raises:
        ProblemError: If they are equal.
    """
    return polyline((as_placement("begin", begin), as_placement("end", end)))


def polyline(poses: Sequence[PlacementLike], *, blend: float = 0.0) -> Curve:
    """Return straight lines through placements, with rounded corners if `blend` is positive.

    Args:
        blend: Radius about each inner pose within which the corner may be cut [m]; at most half of the
            shorter side is used. The curvature is continuous. 0 passes through the poses.

    Raises:
        ProblemError: If there are fewer than two poses, consecutive poses are equal, or the radius is
            negative.
    """
    poses = [as_placement("each of poses", pose) for pose in sequence("poses", poses)]
    if len(poses) < 2:
        raise ProblemError(f"a polyline needs at least two poses, has {len(poses)}")
    radius = number("blend", blend)
    if radius < 0.0:
        raise ProblemError(f"blend is a radius and must not be negative, is {in_length(radius)}")
    sides = [_side(first, second, place) for place, (first, second) in enumerate(pairwise(poses))]
    cut = [0.0, *(min(radius, ROUNDEST * min(a.length, b.length)) for a, b in pairwise(sides)), 0.0]
    pieces: list[Piece] = []
    along, reached = [0.0], 0.0
    for place, side in enumerate(sides):
        if side.length - cut[place] - cut[place + 1] > NOWHERE:
            pieces.append(_part(side, cut[place] / side.length, 1.0 - cut[place + 1] / side.length))
            reached += pieces[-1].length
        if cut[place + 1] > NOWHERE:
            corner = _corner(side, sides[place + 1], cut[place + 1])
            pieces.append(corner)
            along.append(reached + corner.length / 2.0)
            reached += corner.length
        else:
            along.append(reached)
    return Curve(tuple(pieces), readonly(np.array(along)))


def arc_about(begin: PlacementLike, end: PlacementLike, *, centre: ArrayLike) -> Curve:
    """Return the shorter arc between two placements about a centre (3,) [m] (Pilz's CIRC with `center`).

    Raises:
        ProblemError: If the three points are collinear, or the ends are at different distances from the
            centre.
    """
    begin, end = as_placement("begin", begin), as_placement("end", end)
    middle = floats("centre", centre, (3,))
    first, last = begin.translation - middle, end.translation - middle
    radii = float(np.linalg.norm(first)), float(np.linalg.norm(last))
    if abs(radii[0] - radii[1]) > RADIUS_DIFFERENCE:
        raise ProblemError(
            f"the ends of the arc are {radii[0]:.6g} m and {radii[1]:.6g} m from its centre; "
            "an arc has one radius"
        )
    normal = cross(first, last)
    if float(np.linalg.norm(normal)) < COLLINEAR * max(radii[0] * radii[1], NOWHERE):
        raise ProblemError(
            "centre and ends of the arc lie on a line and span no plane: use arc_through(...), or two arcs"
        )
    # Moved along the chord until both ends are equally far: the circle passes exactly through them.
    chord = last - first
    middle = middle + chord * (np.dot(first + last, chord) / (2.0 * np.dot(chord, chord)))
    first, last = begin.translation - middle, end.translation - middle
    return _arc(begin, end, middle, cross(first, last))


def arc_through(begin: PlacementLike, interim: ArrayLike, end: PlacementLike) -> Curve:
    """Return the arc between two placements through a point (3,) [m] (Pilz's CIRC with `interim`).

    The arc may be more than half of the circle. The rotation has a constant rate.

    Raises:
        ProblemError: If the three points are collinear.
    """
    begin, end = as_placement("begin", begin), as_placement("end", end)
    passed = floats("interim", interim, (3,))
    a, b = begin.translation - passed, end.translation - passed
    normal = cross(a, b)
    square = float(normal @ normal)
    if np.sqrt(square) < COLLINEAR * max(float(np.linalg.norm(a) * np.linalg.norm(b)), NOWHERE):
        raise ProblemError("begin, interim point and end of the arc lie on a line: no circle passes them")
    centre = passed + cross((a @ a) * b - (b @ b) * a, normal) / (2.0 * square)
    # Seen from the side of (end - interim) x (begin - interim) begin, interim, end are anticlockwise.
    return _arc(begin, end, centre, -normal)


def circle(
    centre: PlacementLike,
    *,
    radius: float,
    rotation: ArrayLike,
    sweep: float | None = None,
    degrees: bool = False,
) -> Curve:
    """Return a circle, or an arc of one, with a fixed orientation of the tool.

    Args:
        centre: About its z axis; the circle starts on its x axis and turns towards y.
        radius: Its radius [m].
        rotation: Of the tool in the world, shape (3, 3).
        sweep: Angle of the arc, not 0; negative turns the other way [rad]; the whole circle if None.

    Raises:
        ProblemError: If radius or sweep is out of range.
    """
    size = number("radius", radius)
    angle = stated_angle("sweep", sweep, degrees=degrees, default=2.0 * np.pi)
    centre = as_placement("centre", centre)
    if size <= 0.0 or abs(angle) < NOWHERE:
        raise ProblemError(
            f"a circle needs a positive radius and a sweep, not {in_length(size)} and {in_degrees(angle)}"
        )
    turned = placement(rotation=floats("rotation", rotation, (3, 3))).rotation
    piece = Piece(
        readonly(centre.translation[None]),
        turned,
        readonly(np.zeros((1, 3))),
        size * abs(angle),
        readonly(size * centre.rotation[:, 0]),
        readonly(size * centre.rotation[:, 1]),
        angle,
    )
    return Curve((piece,), readonly(np.array((0.0, piece.length))))


def spline(poses: Sequence[PlacementLike]) -> Curve:
    """Return a smooth curve through placements: a cubic spline of their points, with C1 rotations.

    Raises:
        ProblemError: If there are fewer than three poses, or consecutive ones are equal.
    """
    from scipy.interpolate import CubicSpline

    poses = [as_placement("each of poses", pose) for pose in sequence("poses", poses)]
    if len(poses) < 3:
        raise ProblemError(f"a spline needs at least three poses, has {len(poses)}; use line(...)")
    sides = [_side(first, second, place) for place, (first, second) in enumerate(pairwise(poses))]
    spans = np.array([side.length for side in sides])
    places = np.concatenate(((0.0,), np.cumsum(spans)))
    points = np.array([pose.translation for pose in poses])
    closed = float(np.abs(points[0] - points[-1]).max()) < NOWHERE
    if closed:
        points[-1] = points[0]
    smooth = CubicSpline(places, points, bc_type="periodic" if closed else "not-a-knot")
    slopes = np.asarray(smooth(places, 1), dtype=np.float64)
    rates = _rates(sides, spans, closed=closed)
    pieces: list[Piece] = []
    for place, side in enumerate(sides):
        span, turn = spans[place], side.turns[-1]
        outgoing = _inverse_right_jacobian(turn) @ rates[place + 1]
        pieces.append(
            _measured(
                _hermite(points[place], points[place + 1], slopes[place] * span, slopes[place + 1] * span),
                side.rotation,
                _hermite(np.zeros(3), turn, rates[place] * span, outgoing * span),
            )
        )
    lengths = np.cumsum([piece.length for piece in pieces])
    return Curve(tuple(pieces), readonly(np.concatenate(((0.0,), lengths))))


def _side(first: Placement, second: Placement, place: int) -> Piece:
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(first.rotation.T @ second.rotation).as_rotvec()
    piece = _measured(
        np.stack((first.translation, second.translation)), first.rotation, np.stack((np.zeros(3), turn))
    )
    if piece.length < NOWHERE:
        raise ProblemError(f"poses {place} and {place + 1} are the same: a curve needs poses apart")
    return piece


def _part(side: Piece, begin: float, end: float) -> Piece:
    at = np.array((begin, end))
    return Piece(
        readonly(bezier(side.points, at)),
        side.rotation,
        readonly(bezier(side.turns, at)),
        side.length * (end - begin),
    )


def _corner(before: Piece, after: Piece, cut: float) -> Piece:
    at_corner = before(np.ones(1))
    enter, leave = 1.0 - cut / before.length, cut / after.length
    corner = at_corner.translation[0]
    points = _rounded(
        bezier(before.points, np.array((enter,)))[0], corner, bezier(after.points, np.array((leave,)))[0]
    )
    # Counted from the corner's rotation, both sides turn about fixed axes through zero.
    turns = _rounded(-(1.0 - enter) * before.turns[-1], np.zeros(3), leave * after.turns[-1])
    return _measured(points, at_corner.rotation[0], turns)


def _rounded(begin: Floats, corner: Floats, end: Floats) -> Floats:
    handles = [begin + part * (corner - begin) for part in (0.0, HANDLE / 2.0, HANDLE)]
    return np.stack((*handles, *(end + part * (corner - end) for part in (HANDLE, HANDLE / 2.0, 0.0))))


def _arc(begin: Placement, end: Placement, centre: Floats, normal: Floats) -> Curve:
    from scipy.spatial.transform import Rotation

    axis = normal / np.linalg.norm(normal)
    first, last = begin.translation - centre, end.translation - centre
    across = cross(axis, first)
    sweep = float(np.arctan2(last @ across, last @ first)) % (2.0 * np.pi)
    turn = Rotation.from_matrix(begin.rotation.T @ end.rotation).as_rotvec()
    length = max(sweep * float(np.linalg.norm(first)), TURN_LENGTH * float(np.linalg.norm(turn)))
    piece = Piece(
        readonly(centre[None]),
        begin.rotation,
        readonly(np.stack((np.zeros(3), turn))),
        length,
        readonly(first),
        readonly(across),
        sweep,
    )
    return Curve((piece,), readonly(np.array((0.0, length))))


def cross(first: Floats, second: Floats) -> Floats:
    return np.array(np.cross(first, second), dtype=np.float64)


def _measured(points: Floats, rotation: Floats, turns: Floats) -> Piece:
    u = np.linspace(0.0, 1.0, 2 if len(points) == 2 and len(turns) == 2 else FINE + 1)
    way = float(np.linalg.norm(np.diff(bezier(points, u), axis=0), axis=1).sum())
    turn = float(np.linalg.norm(np.diff(bezier(turns, u), axis=0), axis=1).sum())
    return Piece(readonly(points), rotation, readonly(turns), max(way, TURN_LENGTH * turn))


def _hermite(begin: Floats, end: Floats, outward: Floats, inward: Floats) -> Floats:
    return np.stack((begin, begin + outward / 3.0, end - inward / 3.0, end))


def _rates(sides: Sequence[Piece], spans: Floats, *, closed: bool) -> Floats:
    """Return the angular velocity at each pose, in its frame, the mean of both sides, shape (p, 3)."""
    even = np.array([side.turns[-1] for side in sides]) / spans[:, None]
    inner = (even[:-1] + even[1:]) / 2.0
    first, last = even[0], even[-1]
    if closed:
        first = last = (even[0] + even[-1]) / 2.0
    return np.concatenate((first[None], inner, last[None]))


def _inverse_right_jacobian(w: Floats) -> Floats:
    """Return the matrix from the angular velocity in the frame to the rate of the rotation vector w.

    Source: Sola et al., A micro Lie theory for state estimation in robotics, 2018, equation 144.
    """
    angle = float(np.linalg.norm(w))
    x, y, z = w.tolist()
    skew = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    factor = 1.0 / 12.0 if angle < 1e-4 else (1.0 - 0.5 * angle / np.tan(0.5 * angle)) / angle**2
    return np.eye(3) + 0.5 * skew + factor * (skew @ skew)


POINT = ("x", "y", "z")
QUATERNION = ("qx", "qy", "qz", "qw")
RPY = ("roll", "pitch", "yaw")


@checked
def read_poses(
    path: Path | str, *, rpy: ArrayLike = (0.0, 0.0, 0.0), degrees: bool = False
) -> tuple[Placement, ...]:
    """Read poses, in order, from a file.

    CSV has a header with the columns x, y, z [m], and for orientations qx, qy, qz, qw, or roll, pitch, yaw
    [rad], or neither. YAML has a list `poses` of mappings, each with a `position` of three numbers and
    optionally a `quaternion` (x, y, z, w) or `rpy`.

    Args:
        path: The file; read as YAML unless its suffix is ".csv".
        rpy: Orientation of poses without one: roll, pitch, yaw [rad].
        degrees: Whether roll, pitch and yaw are in degrees, here and in the file.

    Raises:
        FileFormatError: If the file is missing or invalid.
    """
    turned = stated_angles("rpy", rpy, (3,), degrees=degrees)
    fixed = placement(rpy=turned).rotation
    if str(path).lower().endswith(".csv"):
        poses = _read_csv(Path(path), fixed, degrees=degrees)
    else:
        listed = read_document(path).only(("poses",))["poses"]
        poses = [pose_of(node, fixed, degrees=degrees) for node in listed.elements()]
    if len(poses) < 2:
        raise FileFormatError(str(path), f"has {len(poses)} poses; a curve needs at least two")
    return tuple(poses)


def _read_csv(path: Path, fixed: Floats, *, degrees: bool) -> list[Placement]:
    try:
        with path.open(newline="") as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            names, rows = tuple(reader.fieldnames or ()), list(reader)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FileFormatError(str(path), str(error)) from error
    turned = next((columns for columns in (QUATERNION, RPY) if columns[0] in names), ())
    if set(names) != {*POINT, *turned}:
        raise FileFormatError(
            str(path),
            f"has the columns {', '.join(names) or 'none'}; needs x, y, z, and for orientations "
            f"{', '.join(QUATERNION)} or {', '.join(RPY)}",
        )
    poses: list[Placement] = []
    for line, row in enumerate(rows, start=2):
        try:
            point = [float(row[name]) for name in POINT]
            numbers = [float(row[name]) for name in turned]
            poses.append(_placed(point, turned, numbers, fixed, degrees=degrees))
        except (TypeError, ValueError) as error:
            raise FileFormatError(str(path), f"line {line}: {error}") from error
    return poses


def pose_of(node: Node, fixed: Floats, *, degrees: bool) -> Placement:
    """Read a pose: `position` [m], and `quaternion` (x, y, z, w) or `rpy`, else a fixed rotation (3, 3)."""
    node.only(("position", "quaternion", "rpy"))
    if not node.has("position"):
        raise node["position"].error("is missing")
    if node.has("quaternion") and node.has("rpy"):
        raise node["rpy"].error("is beside a quaternion: leave one of them out")
    turned = QUATERNION if node.has("quaternion") else RPY if node.has("rpy") else ()
    numbers = node["quaternion" if node.has("quaternion") else "rpy"].numbers()
    try:
        return _placed(list(node["position"].numbers()), turned, list(numbers), fixed, degrees=degrees)
    except ShapeError as error:
        raise node.error(str(error)) from error


def _placed(
    point: list[float],
    turned: tuple[str, ...],
    numbers: list[float],
    fixed: Floats,
    *,
    degrees: bool,
) -> Placement:
    if turned == QUATERNION:
        return placement(point, quaternion=numbers)
    if turned == RPY:
        return placement(point, rpy=numbers, degrees=degrees)
    return placement(point, rotation=fixed)
