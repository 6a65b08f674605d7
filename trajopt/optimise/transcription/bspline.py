"""Transcription by a B-spline: the same rows as over knots, over control points.

A spline lies within the hull of its control points, so bounds on these keep joint limits everywhere.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from trajopt.optimise.transcription.compilable import CompilableMotionNlp
from trajopt.optimise.transcription.knots import KnotsNlp, swept_samples
from trajopt.problem.motion import Motion
from trajopt.values.arrays import Floats, Ints, readonly
from trajopt.values.trajectory import Path, Trajectory

Number = TypeVar("Number", np.float64, np.complex128)


@dataclass(frozen=True, eq=False)
class Stencils:
    """Linear functions of few neighbouring control points, m of them.

    Attributes:
        support: The control points of each, shape (m, k).
        weight: Their factors, shape (m, k).
    """

    support: Ints
    weight: Floats

    def __call__(self, control: Floats) -> Floats:
        return np.einsum("mk,mkn->mn", self.weight, control[self.support])


@dataclass(frozen=True, eq=False)
class SplineBasis:
    """A clamped B-spline: it begins and ends in a control point.

    Source: de Boor, A Practical Guide to Splines, 2001, chapters IX and X.

    Attributes:
        breaks: Parameters at which pieces meet, increasing from 0 to 1, shape (m + 1,).
    """

    degree: int
    breaks: Floats

    @property
    def count(self) -> int:
        return len(self.breaks) - 1 + self.degree

    @cached_property
    def knots(self) -> Floats:
        return np.concatenate((np.zeros(self.degree), self.breaks, np.ones(self.degree)))

    @property
    def averages(self) -> Floats:
        """Parameters of the control points in [0, 1]: means of the knots (Greville), shape (count,)."""
        return self.knots[np.arange(self.count)[:, None] + np.arange(1, self.degree + 1)].mean(axis=1)

    @cached_property
    def at_breaks(self) -> tuple["Stencils", ...]:
        return tuple(self.derivative_at(self.breaks, order) for order in range(3))

    def parameters(self, sampling: Ints) -> Floats:
        """Return every break, and `sampling - 1` parameters between, even in each piece, shape (m,)."""
        piece = np.repeat(np.arange(len(sampling)), sampling)
        starts = np.repeat(np.cumsum(sampling) - sampling, sampling)
        share = (np.arange(len(piece)) - starts) / sampling[piece]
        return np.append(self.breaks[piece] + share * np.diff(self.breaks)[piece], self.breaks[-1])

    @cached_property
    def derivatives(self) -> tuple["Stencils", ...]:
        return tuple(self.derivative(order) for order in range(1, self.degree + 1))

    def sampled(self, sampling: Ints, exact: Floats) -> tuple[Floats, "Stencils"]:
        """Return parameters, shape (s,), and the weights of control points there.

        Args:
            sampling: As for `parameters`.
            exact: Parameters that are samples too, shape (w,).
        """
        even = int(sampling[0])
        if len(exact) or not (sampling == even).all():
            parameters = np.union1d(self.parameters(sampling), exact)
            return parameters, self.at(parameters)
        if even not in self._even:
            parameters = self.parameters(sampling)
            self._even[even] = parameters, self.at(parameters)
        return self._even[even]

    @cached_property
    def _even(self) -> dict[int, tuple[Floats, "Stencils"]]:
        return {}

    def at(self, parameters: Floats) -> Stencils:
        return self.derivative_at(parameters, 0)

    def derivative(self, order: int) -> Stencils:
        """Return the matrix from the control points to those of a derivative.

        A derivative lies between its control points, so bounds on these bound it everywhere.
        """
        matrix = np.eye(self.count)
        for step in range(order):
            degree, rows = self.degree - step, self.count - step
            knots = self.knots[step : len(self.knots) - step]
            width = knots[degree + 1 : degree + rows] - knots[1:rows]
            matrix = np.diff(matrix, axis=0) * (degree / width)[:, None]
        support = np.arange(len(matrix))[:, None] + np.arange(order + 1)
        return Stencils(support, np.take_along_axis(matrix, support, axis=1))

    def derivative_at(self, parameters: Floats, order: int) -> Stencils:
        """Return weights of the control points in a derivative at parameters in [0, 1], shape (s,)."""
        piece = np.clip(np.searchsorted(self.breaks, parameters, side="right") - 1, 0, len(self.breaks) - 2)
        near = self.knots[piece[:, None] + np.arange(1, 2 * self.degree + 1)]
        weight = basis_weights(parameters[:, None], near, order)
        return Stencils(piece[:, None] + np.arange(self.degree + 1), weight)


def basis_weights(place: NDArray[np.number], knots: NDArray[Number], order: int) -> NDArray[Number]:
    """Return the weights of control points in a derivative of a B-spline, shape (s, degree + 1).

    By the recursion over degrees: up to the degree less the order shares of neighbouring pieces are summed,
    above differences are taken (de Boor, A Practical Guide to Splines, 2001, chapter X).

    Args:
        place: Shape (s, 1).
        knots: Around each place, which is between the two in the middle, shape (s, 2 degree).
    """
    whole = knots.shape[1] // 2
    weight = np.zeros((len(knots), whole + 1), dtype=knots.dtype)
    weight[:, 0] = 1.0
    for degree in range(1, whole + 1):
        after, before = knots[:, whole : whole + degree], knots[:, whole - degree : whole]
        lower = weight[:, :degree].copy()
        weight[:, :degree] = 0.0
        if degree <= whole - order:
            share = lower / (after - before)
            weight[:, 1 : degree + 1] = share * (place - before)
            weight[:, :degree] += share * (after - place)
        else:
            share = degree * lower / (after - before)
            weight[:, 1 : degree + 1] = share
            weight[:, :degree] -= share
    return weight


@lru_cache(maxsize=8)
def even_basis(degree: int, pieces: int) -> SplineBasis:
    return SplineBasis(degree, readonly(np.linspace(0.0, 1.0, pieces + 1)))


def fitted(
    basis: SplineBasis,
    parameters: Floats,
    positions: Floats,
    *,
    resting: int,
    first: Floats | None = None,
) -> Floats:
    """Return control points of the spline nearest to given points by least squares, shape (count, n).

    Args:
        parameters: In [0, 1], increasing, the first 0 and the last 1, shape (s,).
        positions: Points there, shape (s, n).
        resting: Control points at either end that coincide with the first or last point: with 3, velocity
            and acceleration vanish at both ends.
        first: Other values of the control points at the start, shape (resting, n).
    """
    stencils = basis.at(parameters)
    design = np.zeros((len(parameters), basis.count))
    np.put_along_axis(design, stencils.support, stencils.weight, axis=1)
    control = np.empty((basis.count, positions.shape[1]))
    control[:resting], control[-resting:] = positions[0] if first is None else first, positions[-1]
    inner = slice(resting, basis.count - resting)
    rest = positions - design[:, :resting] @ control[:resting] - design[:, -resting:] @ control[-resting:]
    # A trifle of ridge on second differences for control points that no sample sees.
    bend = 1e-4 * np.diff(np.eye(basis.count), n=2, axis=0)
    right = np.concatenate(
        (rest, -(bend[:, :resting] @ control[:resting] + bend[:, -resting:] @ control[-resting:]))
    )
    control[inner] = np.linalg.lstsq(np.vstack((design[:, inner], bend[:, inner])), right, rcond=None)[0]
    return control


COARSE_SAMPLES = 2
"""Samples per piece while the motion is not free yet."""


@dataclass(frozen=True, eq=False)
class KnotPlaces:
    """Places of the spline on the polyline over knots, to which windows and margins refer.

    Attributes:
        parameters: Of the spline, increasing from 0 to 1, shape (m,).
        knots: Places there, in knots, shape (m,).
        exact: Parameters that must be samples, shape (w,): of waypoints.
    """

    parameters: Floats
    knots: Floats
    exact: Floats

    def __call__(self, parameters: Floats) -> Floats:
        return np.interp(parameters, self.parameters, self.knots)

    @staticmethod
    def along(
        polyline: Floats, motion: Trajectory, waypoint_knots: Sequence[int] = (), begin: float = 0.0
    ) -> "KnotPlaces":
        """Match a motion to a polyline (N, n) by equal shares of their lengths.

        Args:
            begin: Time from which the motion is on the polyline [s].
        """
        legs = np.linalg.norm(np.diff(polyline, axis=0), axis=1)
        lengths = np.concatenate((np.zeros(1), np.cumsum(legs))) / max(float(legs.sum()), 1e-12)
        times = np.linspace(begin, motion.duration, 20 * len(legs))
        # Knots that coincide are one place; the last of them is.
        steps = np.linalg.norm(np.diff(motion(times), axis=0), axis=1)
        share = np.concatenate((np.zeros(1), np.cumsum(steps))) / max(float(steps.sum()), 1e-12)
        knots = np.interp(share, lengths, np.arange(len(lengths), dtype=np.float64))
        knots[0], knots[-1] = 0.0, float(len(legs))
        parameters = times / motion.duration
        exact = np.interp(np.array(waypoint_knots, dtype=np.float64), knots, parameters)
        return KnotPlaces(parameters, knots, exact)


@dataclass(eq=False)
class BsplineNlp(CompilableMotionNlp):
    """The program over control points, at `places` of the motion over knots."""

    basis: SplineBasis
    places: KnotPlaces

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        pieces = len(self.basis.breaks) - 1
        if not fine:
            return np.full(pieces, COARSE_SAMPLES)
        corners = self.basis.at(self.basis.breaks)(x)
        return swept_samples(self.query, corners, COARSE_SAMPLES)

    def motion(self, x: Floats, sampling: Ints) -> Motion:
        parameters, stencils = self.basis.sampled(sampling, self.places.exact)
        places = self.places(parameters)
        return Motion(x, stencils.support, stencils.weight, places, stencils(x), self.query)

    def decode(self, x: Floats) -> Path:
        sampling = self.sampling(x, fine=True)
        return Path(self.problem.reduced.joint_names, readonly(self.motion(x, sampling).positions))


def over_control_points(
    base: KnotsNlp, basis: SplineBasis, places: KnotPlaces, *, resting: int = 1
) -> BsplineNlp:
    """Transcribe a problem over the control points of a spline.

    Args:
        resting: Control points at either end that have the bounds of the first and last knot.
    """
    lower, upper = (
        np.concatenate(
            (
                np.tile(side[0], (resting, 1)),
                np.tile(side[1], (basis.count - 2 * resting, 1)),
                np.tile(side[-1], (resting, 1)),
            )
        )
        for side in (base.lower, base.upper)
    )
    return BsplineNlp(
        base.problem, base.counts, lower, upper, base.scale, base.query, base.constraints, basis, places
    )
