"""B-spline basis on [0, 1]: weights of control points, and control points of derivatives.

Source: de Boor, A Practical Guide to Splines, 2001, chapters IX and X.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from trajopt.values.arrays import Floats, Ints, readonly


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
        """Evaluate at control points (M, n): shape (m, n)."""
        return np.einsum("mk,mkn->mn", self.weight, control[self.support])


@dataclass(frozen=True, eq=False)
class SplineBasis:
    """A clamped B-spline: it begins and ends in a control point.

    Attributes:
        degree: Of its polynomials.
        breaks: Parameters at which pieces meet, increasing from 0 to 1, shape (m + 1,).
    """

    degree: int
    breaks: Floats

    @property
    def count(self) -> int:
        """Number of control points."""
        return len(self.breaks) - 1 + self.degree

    @cached_property
    def knots(self) -> Floats:
        """The spline's knots, the ends repeated, shape (count + degree + 1,)."""
        return np.concatenate((np.zeros(self.degree), self.breaks, np.ones(self.degree)))

    @property
    def averages(self) -> Floats:
        """Parameters of the control points in [0, 1]: means of the knots (Greville), shape (count,)."""
        return self.knots[np.arange(self.count)[:, None] + np.arange(1, self.degree + 1)].mean(axis=1)

    @cached_property
    def at_breaks(self) -> tuple["Stencils", ...]:
        """Weights of the control points in positions, first and second derivatives at the breaks."""
        return tuple(self.derivative_at(self.breaks, order) for order in range(3))

    def parameters(self, sampling: Ints) -> Floats:
        """Return every break, and `sampling - 1` parameters between, even in each piece.

        Args:
            sampling: For each piece, >= 1, shape (m,).
        """
        piece = np.repeat(np.arange(len(sampling)), sampling)
        starts = np.repeat(np.cumsum(sampling) - sampling, sampling)
        share = (np.arange(len(piece)) - starts) / sampling[piece]
        return np.append(self.breaks[piece] + share * np.diff(self.breaks)[piece], self.breaks[-1])

    @cached_property
    def derivatives(self) -> tuple["Stencils", ...]:
        """Matrices from the control points to the control points of the first, second ... derivative."""
        return tuple(self.derivative(order) for order in range(1, self.degree + 1))

    def sampled(self, sampling: Ints, exact: Floats) -> tuple[Floats, "Stencils"]:
        """Return parameters, shape (s,), and the weights of control points there.

        Args:
            sampling: Samples of each piece, as of `parameters`.
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
        """Samples of equally many to each piece."""
        return {}

    def at(self, parameters: Floats) -> Stencils:
        """Return the weights of control points at parameters in [0, 1], shape (s,)."""
        return self.derivative_at(parameters, 0)

    def derivative(self, order: int) -> Stencils:
        """Return the matrix from the control points to the control points of a derivative.

        The derivative is a spline of lower degree on the same pieces: it lies between its control points,
        so bounds on these bound it everywhere.

        Args:
            order: 1 up to the degree.
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
        """Return weights of the control points in a derivative at parameters in [0, 1], shape (s,).

        By the recursion over degrees: degrees up to the degree less the order sum shares of the neighbouring
        pieces, higher ones take differences.
        """
        piece = np.clip(np.searchsorted(self.breaks, parameters, side="right") - 1, 0, len(self.breaks) - 2)
        weight = np.zeros((len(parameters), self.degree + 1))
        weight[:, 0] = 1.0
        place = parameters[:, None]
        for degree in range(1, self.degree + 1):
            ends = piece[:, None] + self.degree + np.arange(1, degree + 1)
            after, before = self.knots[ends], self.knots[ends - degree]
            lower = weight[:, :degree].copy()
            weight[:, :degree] = 0.0
            if degree <= self.degree - order:
                share = lower / (after - before)
                weight[:, 1 : degree + 1] = share * (place - before)
                weight[:, :degree] += share * (after - place)
            else:
                share = degree * lower / (after - before)
                weight[:, 1 : degree + 1] = share
                weight[:, :degree] -= share
        return Stencils(piece[:, None] + np.arange(self.degree + 1), weight)


@lru_cache(maxsize=8)
def even_basis(degree: int, pieces: int) -> SplineBasis:
    """Return a clamped B-spline of pieces of equal length; one for all plans, since its weights take long."""
    return SplineBasis(degree, readonly(np.linspace(0.0, 1.0, pieces + 1)))


def fitted(
    basis: SplineBasis,
    parameters: Floats,
    positions: Floats,
    *,
    resting: int,
    first: Floats | None = None,
) -> Floats:
    """Return control points of the spline nearest to given points, by least squares.

    Args:
        basis: The basis.
        parameters: In [0, 1], increasing, the first 0 and the last 1, shape (s,).
        positions: Points there, shape (s, n).
        resting: Control points at either end that coincide with the first or last point: with 3, velocity
            and acceleration vanish at both ends.
        first: Other values of the control points at the start, shape (resting, n).

    Returns:
        Shape (count, n).
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
