"""The judge's own reading of a curve: its points, and bounds on how it bends.

Points are vectors of length 3. An orientation C counts as the vector of its three columns, or of one
direction C a only where the frame may spin about a. When C turns with angular velocity w and acceleration
v, the first has a second derivative of length at most sqrt(2) (|v| + |w|^2), the other one |v| + |w|^2.
With C = C_0 exp(x), |w| <= |x'| and |v| <= |x''| + |x'|^2 / 2, since the Jacobian of rotations is the mean of
rotations by parts of x.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import comb

import numpy as np

from trajopt.values.arrays import Floats, Ints
from trajopt.values.curve import Curve, Piece

KINK = 0.05
"""Smaller jumps of direction are no kinks [-], [rad/m]."""


@dataclass(frozen=True, eq=False)
class Bends:
    """Bounds over intervals of a curve, per metre along it, each of shape (c, 2): of points, of orientations.

    Attributes:
        rate: Of the first derivative [-], [rad/m].
        second: Of the second derivative [1/m], [rad/m^2], where there is one.
        kinks: Sum of the jumps of the first derivative inside.
    """

    rate: Floats
    second: Floats
    kinks: Floats


class CurvePlaces:
    """A curve as the judge reads it."""

    def __init__(self, curve: Curve) -> None:
        """Read the pieces."""
        self._pieces = curve.pieces
        self._edges = np.concatenate(((0.0,), np.cumsum([piece.length for piece in curve.pieces])))
        self._rates = np.array([_rates(piece) for piece in curve.pieces])
        self._seconds = np.array([_seconds(piece) for piece in curve.pieces])
        jumps = [_jump(before, after) for before, after in pairwise(curve.pieces)]
        self._kinks = np.concatenate((np.zeros((1, 2)), np.cumsum(np.reshape(jumps, (-1, 2)), axis=0)))

    @property
    def edges(self) -> Floats:
        """Where pieces begin and end [m]."""
        return self._edges

    @property
    def kinked(self) -> Floats:
        """Where the direction of point or orientation jumps [m]."""
        jumps = np.diff(self._kinks, axis=0).max(axis=1)
        return self._edges[1:-1][jumps > KINK]

    def _number(self, s: Floats) -> Ints:
        found = np.searchsorted(self._edges, s, side="right") - 1
        return np.clip(found, 0, len(self._pieces) - 1).astype(np.int64)

    def at(self, s: Floats) -> tuple[Floats, Floats]:
        """Return rotations (c, 3, 3) and points (c, 3) [m] at lengths (c,) along the curve [m]."""
        rotation, point = np.empty((len(s), 3, 3)), np.empty((len(s), 3))
        number = self._number(s)
        for index in sorted(set(map(int, number))):
            here, piece = number == index, self._pieces[index]
            u = (s[here] - self._edges[index]) / piece.length
            angle = piece.sweep * u
            point[here] = (
                _bernstein(len(piece.points) - 1, u) @ piece.points
                + np.outer(np.cos(angle), piece.cosine)
                + np.outer(np.sin(angle), piece.sine)
            )
            rotation[here] = piece.rotation @ _turns(_bernstein(len(piece.turns) - 1, u) @ piece.turns)
        return rotation, point

    def bends(self, begin: Floats, end: Floats) -> Bends:
        """Bound the derivatives over intervals of the curve, shape (c,) each [m]."""
        first = self._number(begin)
        last = np.maximum(first, np.searchsorted(self._edges, end, side="left") - 1)
        rate, second = self._rates[first], self._seconds[first]
        for step in range(1, int((last - first).max(initial=0)) + 1):
            other = np.minimum(first + step, last)
            rate = np.maximum(rate, self._rates[other])
            second = np.maximum(second, self._seconds[other])
        return Bends(rate, second, self._kinks[last] - self._kinks[first])


def _bernstein(degree: int, u: Floats) -> Floats:
    """Weights of control points, shape (c, degree + 1)."""
    powers = np.arange(degree + 1)
    binomials = np.array([comb(degree, int(k)) for k in powers], dtype=np.float64)
    return binomials * u[:, None] ** powers * (1.0 - u[:, None]) ** (degree - powers)


def _skew(w: Floats) -> Floats:
    """Cross products with vectors as matrices, (c, 3) -> (c, 3, 3)."""
    x, y, z = w.T
    zero = np.zeros_like(x)
    return np.stack((zero, -z, y, z, zero, -x, -y, x, zero), axis=1).reshape(-1, 3, 3)


def _turns(w: Floats) -> Floats:
    """Rotation matrices of rotation vectors, by Rodrigues' formula, (c, 3) -> (c, 3, 3)."""
    angle = np.linalg.norm(w, axis=1)[:, None, None]
    cross = _skew(w)
    whole = np.asarray(np.sinc(angle / np.pi), dtype=np.float64)  # sin(a) / a
    half = np.asarray(np.sinc(angle / (2.0 * np.pi)), dtype=np.float64)
    return np.eye(3) + whole * cross + 0.5 * half**2 * (cross @ cross)


def _rates(piece: Piece) -> tuple[float, float]:
    """Bound the first derivatives of point and orientation along a piece [-], [rad/m].

    The derivative of a Bezier polynomial is one too, with the differences of the control points times the
    degree, and stays within their hull.
    """
    arm = max(float(np.linalg.norm(piece.cosine)), float(np.linalg.norm(piece.sine)))
    point = _largest(piece.points, 1) + arm * abs(piece.sweep) * np.sqrt(2.0)
    return point / piece.length, _largest(piece.turns, 1) / piece.length


def _seconds(piece: Piece) -> tuple[float, float]:
    """Bound the second derivatives; of the orientation without the part due to turning itself."""
    arm = max(float(np.linalg.norm(piece.cosine)), float(np.linalg.norm(piece.sine)))
    point = _largest(piece.points, 2) + arm * piece.sweep**2 * np.sqrt(2.0)
    turn = _largest(piece.turns, 2) + _largest(piece.turns, 1) ** 2 / 2.0
    return point / piece.length**2, turn / piece.length**2


def _largest(control: Floats, order: int) -> float:
    """Largest length of a derivative of a Bezier polynomial over its parameter."""
    degree = len(control) - 1
    if degree < order:
        return 0.0
    factor = float(np.prod(np.arange(degree, degree - order, -1)))
    return factor * float(np.linalg.norm(np.diff(control, n=order, axis=0), axis=1).max())


def _jump(before: Piece, after: Piece) -> tuple[float, float]:
    """Jumps of the first derivatives where one piece ends and the next begins."""
    old, new = _slopes(before, 1.0), _slopes(after, 0.0)
    point, turn = (float(np.linalg.norm(new[row] - old[row])) for row in (0, 1))
    return point, turn


def _slopes(piece: Piece, u: float) -> tuple[Floats, Floats]:
    """Derivative of the point, and the angular velocity, at an end of a piece, both (3,), per metre."""
    at_end = np.array((u,))
    angle = piece.sweep * u
    point = piece.sweep * (np.cos(angle) * piece.sine - np.sin(angle) * piece.cosine)
    if len(piece.points) > 1:
        slopes = (len(piece.points) - 1) * np.diff(piece.points, axis=0)
        point = point + (_bernstein(len(slopes) - 1, at_end) @ slopes)[0]
    if len(piece.turns) == 1:
        return point / piece.length, np.zeros(3)
    slopes = (len(piece.turns) - 1) * np.diff(piece.turns, axis=0)
    rate = (_bernstein(len(slopes) - 1, at_end) @ slopes)[0]
    x = (_bernstein(len(piece.turns) - 1, at_end) @ piece.turns)[0]
    # The mean of the rotations by parts of x takes x' to the angular velocity (Gauss-Legendre, exact enough).
    nodes, weights = np.polynomial.legendre.leggauss(24)
    mean = np.einsum("c,cij->ij", weights / 2.0, _turns((nodes[:, None] + 1.0) / 2.0 * x))
    return point / piece.length, piece.rotation @ mean @ rate / piece.length
