"""Motion: knots, the samples between them, and their kinematics, evaluated once for all terms."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.arrays import Bools, Floats, Ints
from trajopt.nlp import Rows
from trajopt.query import Kinematics, Query


@dataclass(frozen=True, eq=False)
class Motion:
    """A polyline through knots and the samples on it.

    Attributes:
        knots: The knots, shape (N, n) [rad | m].
        segment: Segment of each sample, shape (S,), in 0 ... N - 2.
        fraction: Where in the segment each sample is, shape (S,), in [0, 1].
        positions: Configuration of each sample, shape (S, n).
        query: Evaluates them.
    """

    knots: Floats
    segment: Ints
    fraction: Floats
    positions: Floats
    query: Query

    @staticmethod
    def through(knots: Floats, sampling: Ints, query: Query) -> "Motion":
        """Sample a polyline: every knot, and `sampling - 1` places between.

        Args:
            knots: Shape (N, n).
            sampling: Samples per segment, its first knot included, shape (N - 1,), each >= 1.
            query: Evaluates the kinematics.
        """
        segment = np.repeat(np.arange(len(sampling)), sampling)
        starts = np.repeat(np.cumsum(sampling) - sampling, sampling)
        fraction = (np.arange(len(segment)) - starts) / sampling[segment]
        segment = np.append(segment, len(sampling) - 1)
        fraction = np.append(fraction, 1.0)
        weight = fraction[:, None]
        positions = (1.0 - weight) * knots[segment] + weight * knots[segment + 1]
        return Motion(knots, segment, fraction, positions, query)

    @staticmethod
    def standing(positions: Floats, query: Query) -> "Motion":
        """Sample a single configuration of the group, shape (n,)."""
        knots = np.stack((positions, positions))
        first = np.zeros(1, dtype=np.int64)
        at = positions[None, :]
        return Motion(knots, first, np.zeros(1), at, query)

    @staticmethod
    def each(positions: Floats, query: Query) -> "Motion":
        """Sample configurations that have nothing to do with each other, shape (S, n).

        Each is a knot, and its rows' derivatives by that knot are those by the configuration.
        """
        return Motion(positions, np.arange(len(positions)), np.zeros(len(positions)), positions, query)

    @cached_property
    def kinematics(self) -> Kinematics:
        """Placements and Jacobians of all joints at the samples; evaluated when first asked for."""
        return self.query.kinematics(self.positions)

    @property
    def place(self) -> Floats:
        """Where along the motion each sample is, in knots, shape (S,)."""
        return self.segment + self.fraction

    def where(self, mask: Bools) -> "Motion":
        """Return the motion with only some of its samples."""
        index = np.flatnonzero(mask)
        return Motion(
            self.knots,
            self.segment[index],
            self.fraction[index],
            self.positions[index],
            self.query,
        )

    def rows(self, sample: Ints, value: Floats, jacobian: Floats, component: Ints) -> Rows:
        """Chain derivatives by a sample's configuration to the two knots around it.

        Args:
            sample: Sample of each row, shape (m,).
            value: Residuals, shape (m,).
            jacobian: By the sample's configuration, shape (m, n).
            component: Which component each row is, shape (m,).
        """
        fraction = self.fraction[sample][:, None]
        first = self.segment[sample]
        return Rows(
            value,
            np.stack(((1.0 - fraction) * jacobian, fraction * jacobian), axis=1),
            np.stack((first, first + 1), axis=1),
            component,
            first + self.fraction[sample],
        )

    def rows_of_all(self, value: Floats, jacobian: Floats) -> Rows:
        """Make rows of a residual with d components at every sample.

        Args:
            value: Shape (S, d).
            jacobian: By the samples' configurations, shape (S, d, n).
        """
        count, dim = value.shape
        sample = np.repeat(np.arange(count, dtype=np.int64), dim)
        component = np.tile(np.arange(dim, dtype=np.int64), count)
        return self.rows(sample, value.ravel(), jacobian.reshape(count * dim, jacobian.shape[-1]), component)
