"""The path of a frame, as polynomial pieces and arcs over arc length.

Rotations are R(u) = R_0 exp(w(u)) with polynomials w, so that a turn at constant rate about one axis (slerp)
is of degree one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from trajopt.values.arrays import Floats, Value, floats_of_any_shape, readonly
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.placement import Placement
from trajopt.values.printed import in_degrees, in_length, in_number

TURN_LENGTH = 1.0 / 3.5
"""Length that a turn by one radian counts as [m/rad], if turning takes longer than moving.

The ratio of MoveIt (`MaxEEFStep`): a step of 1 m corresponds to 3.5 rad.
"""
NEAR = 1e-3
"""A frame may be ahead of its place on a curve by this [m]."""
SHARES = readonly(np.linspace(0.0, 1.0, 17))
"""Lengths that are compared for each place on the way along a curve, as shares of the way ahead."""
JOINED = 1e-7
"""Largest gap between consecutive pieces [m | rad]."""


@dataclass(frozen=True, eq=False)
class Piece(Value):
    """A smooth piece of a curve, over a parameter u from 0 to 1.

    The point is b(u) + cosine cos(sweep u) + sine sin(sweep u), with b the Bezier polynomial of `points`; the
    rotation is `rotation` exp(w(u)), with w the Bezier polynomial of `turns`.

    Attributes:
        points: Control points, shape (d + 1, 3) [m].
        turns: Control points of rotation vectors, shape (e + 1, 3) [rad].
        cosine: Radius vector of an arc at its start, shape (3,) [m]; zero if the piece is not an arc.
        sine: Radius vector of the arc a right angle later, shape (3,) [m].
    """

    points: Floats
    rotation: Floats
    turns: Floats
    length: float
    cosine: Floats = field(default_factory=lambda: readonly(np.zeros(3)))
    sine: Floats = field(default_factory=lambda: readonly(np.zeros(3)))
    sweep: float = 0.0

    def __call__(self, u: Floats) -> "Places":
        from scipy.spatial.transform import Rotation

        angle = (self.sweep * u)[:, None]
        point = bezier(self.points, u) + np.cos(angle) * self.cosine + np.sin(angle) * self.sine
        turned = Rotation.from_rotvec(bezier(self.turns, u)).as_matrix()
        return Places(self.rotation @ turned, point)

    def after(self, u: float) -> "Piece":
        """Return the part after a parameter below 1."""
        angle = self.sweep * u
        return Piece(
            readonly(_bezier_after(self.points, u)),
            self.rotation,
            readonly(_bezier_after(self.turns, u)),
            self.length * (1.0 - u),
            readonly(np.cos(angle) * self.cosine + np.sin(angle) * self.sine),
            readonly(np.cos(angle) * self.sine - np.sin(angle) * self.cosine),
            self.sweep * (1.0 - u),
        )


@dataclass(frozen=True, eq=False)
class Places(Value):
    """Placements of a frame at s points of a curve: rotations (s, 3, 3), and translations (s, 3) [m]."""

    rotation: Floats
    translation: Floats


@checked_class
@dataclass(frozen=True, eq=False)
class Curve(Value):
    """A path through space that a frame can be required to follow; pieces joined end to end.

    Locations are given by s, the length along the curve [m]: of the point's path, or `TURN_LENGTH` times the
    angle if that is larger.

    Attributes:
        poses: Locations of the poses that the curve was made from, increasing, shape (p,) [m].
    """

    pieces: tuple[Piece, ...]
    poses: Floats

    def __post_init__(self) -> None:
        if not self.pieces or not all(piece.length > 0.0 for piece in self.pieces):
            raise ProblemError("a curve needs pieces with a length")
        at = np.array((0.0, 1.0))
        for before, after in pairwise(self.pieces):
            end, begin = before(at), after(at)
            gap = float(np.abs(end.translation[1] - begin.translation[0]).max())
            if gap > JOINED:
                raise ProblemError(f"pieces of a curve do not meet: {in_length(gap)} apart")
            change = end.rotation[1] - begin.rotation[0]
            if np.abs(change).max() > JOINED:
                angle = 2.0 * np.arcsin(min(float(np.linalg.norm(change)) / np.sqrt(8.0), 1.0))
                raise ProblemError(f"pieces of a curve do not meet: turned by {in_degrees(angle)}")

    @cached_property
    def edges(self) -> Floats:
        """Locations of the ends of the pieces, shape (number of pieces + 1,) [m]."""
        lengths = [piece.length for piece in self.pieces]
        return readonly(np.concatenate(((0.0,), np.cumsum(lengths))))

    @property
    def length(self) -> float:
        """Length of the whole curve [m]."""
        return float(self.edges[-1])

    def __call__(self, s: Floats) -> Places:
        """Return placements at lengths along the curve, which are clipped to it."""
        lengths = floats_of_any_shape("s", s)
        if lengths.ndim != 1:
            raise ShapeError("s", f"needs shape (any,), has {lengths.shape}")
        along = np.clip(lengths, 0.0, self.length)
        number = np.clip(np.searchsorted(self.edges, along, side="right") - 1, 0, len(self.pieces) - 1)
        rotation, translation = np.empty((len(along), 3, 3)), np.empty((len(along), 3))
        for index in sorted(set(map(int, number))):
            piece, here = self.pieces[index], number == index
            places = piece((along[here] - self.edges[index]) / piece.length)
            rotation[here], translation[here] = places.rotation, places.translation
        return Places(rotation, translation)

    def placement(self, s: float) -> Placement:
        """Return the placement at a length along the curve [m]."""
        place = self(np.array((s,)))
        return Placement(readonly(place.rotation[0]), readonly(place.translation[0]))

    def after(self, s: float) -> "Curve":
        """Return the part after a length along the curve [m].

        Raises:
            ProblemError: If nothing is left.
        """
        if not 0.0 <= s < self.length - JOINED:
            raise ProblemError(f"s must be from 0 to below {in_length(self.length)}, is {in_length(s)}")
        first = int(np.searchsorted(self.edges, s + JOINED, side="right")) - 1
        piece = self.pieces[first].after(max(s - float(self.edges[first]), 0.0) / self.pieces[first].length)
        poses = self.poses[self.poses > s + JOINED] - s
        return Curve((piece, *self.pieces[first + 1 :]), readonly(np.concatenate(((0.0,), poses))))

    def travelled(self, places: Places, *, turns: bool = True) -> float:
        """Return the length reached by a frame that follows the curve through places [m].

        It is tracked from the beginning, so that a curve may cross itself or end at its beginning.

        Args:
            places: From the beginning on, some millimetres apart.
            turns: Whether rotations count; not if the frame may turn freely.
        """
        reached: float = 0.0
        weight = TURN_LENGTH if turns else 0.0
        moved = _apart(
            places.translation[1:] - places.translation[:-1],
            places.rotation[1:] - places.rotation[:-1],
            weight,
        )
        for k, step in enumerate(moved.tolist(), start=1):
            ahead: float = min(2.0 * step + NEAR, self.length - reached)
            lengths = reached + ahead * SHARES
            here = self(lengths)
            off = _apart(here.translation - places.translation[k], here.rotation - places.rotation[k], weight)
            reached = float(lengths[off.argmin()])
        return reached

    def pose_before(self, s: float) -> int:
        """Return the index of the last pose at or before a length [m]."""
        return int(np.searchsorted(self.poses, s + JOINED, side="right")) - 1

    def __add__(self, other: "Curve") -> "Curve":
        """Append another curve, which starts at the end of this one."""
        poses = np.concatenate((self.poses, self.length + other.poses[1:]))
        return Curve((*self.pieces, *other.pieces), readonly(poses))

    def __repr__(self) -> str:
        first, last = self.placement(0.0), self.placement(self.length)
        return f"Curve({self.length:.4g} m, {in_number(self.pieces, 'piece')}, from {first} to {last})"


@checked
def joined(curves: Sequence[Curve]) -> Curve:
    """Join curves end to end."""
    if not curves:
        raise ProblemError("a curve needs pieces that go somewhere")
    whole = curves[0]
    for curve in curves[1:]:
        whole = whole + curve
    return whole


def _apart(translation: Floats, rotation: Floats, weight: float) -> Floats:
    """Return distances (k,), where turns by small angles count by a weight [m/rad]."""
    turned = np.linalg.norm(rotation, axis=(1, 2)) / np.sqrt(2.0)
    return np.linalg.norm(translation, axis=1) + weight * turned


def _bezier_after(points: Floats, u: float) -> Floats:
    """Return the control points of the part after u, by the algorithm of de Casteljau."""
    last = [points[-1]]
    while len(points) > 1:
        points = (1.0 - u) * points[:-1] + u * points[1:]
        last.append(points[-1])
    return np.array(last[::-1])


def bezier(control: Floats, u: Floats) -> Floats:
    """Evaluate a Bezier polynomial of control points (d + 1, k) at parameters (s,), shape (s, k).

    By de Casteljau's algorithm. Source: Farin, Curves and Surfaces for CAGD, section 4.2.
    """
    weight = u[:, None, None]
    level = np.broadcast_to(control, (len(u), *control.shape))
    while level.shape[1] > 1:
        level = (1.0 - weight) * level[:, :-1] + weight * level[:, 1:]
    return np.array(level[:, 0])
