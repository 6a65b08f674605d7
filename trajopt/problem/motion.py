"""Knots, the samples between them, and their kinematics, evaluated once for all terms."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.geometry import Evaluator, JointPlacements
from trajopt.values.arrays import Bools, Floats, Ints, Rows


@dataclass(frozen=True, eq=False)
class Motion:
    """A curve whose points are weighted means of few knots, and samples on it.

    On a polyline a sample lies between two knots; on a spline the knots are its control points.

    Attributes:
        knots: Knots, shape (N, n) [rad | m].
        support: Indices of the k knots that each sample depends on, shape (S, k).
        weight: Their weights, shape (S, k); each row sums to 1.
        place: Location of each sample along the motion, in knots of a polyline, shape (S,).
        positions: Configuration of each sample, shape (S, n).
    """

    knots: Floats
    support: Ints
    weight: Floats
    place: Floats
    positions: Floats
    query: Evaluator

    @staticmethod
    def through(knots: Floats, sampling: Ints, query: Evaluator) -> "Motion":
        """Sample a polyline: every knot, and `sampling - 1` points between.

        Args:
            knots: Shape (N, n).
            sampling: Samples per segment, including its first knot, shape (N - 1,), each >= 1.
        """
        segment = np.repeat(np.arange(len(sampling)), sampling)
        starts = np.repeat(np.cumsum(sampling) - sampling, sampling)
        fraction = (np.arange(len(segment)) - starts) / sampling[segment]
        segment = np.append(segment, len(sampling) - 1)
        fraction = np.append(fraction, 1.0)
        return Motion.between(knots, segment, fraction, query)

    @staticmethod
    def between(knots: Floats, segment: Ints, fraction: Floats, query: Evaluator) -> "Motion":
        """Sample a polyline at fractions in [0, 1] of segments 0 ... N - 2, each of shape (S,)."""
        weight = np.stack((1.0 - fraction, fraction), axis=1)
        positions = weight[:, :1] * knots[segment] + weight[:, 1:] * knots[segment + 1]
        support = np.stack((segment, segment + 1), axis=1)
        return Motion(knots, support, weight, segment + fraction, positions, query)

    @staticmethod
    def single(positions: Floats, query: Evaluator) -> "Motion":
        """Sample a single configuration of the group, shape (n,)."""
        return Motion.each(positions[None, :], query)

    @staticmethod
    def each(positions: Floats, query: Evaluator) -> "Motion":
        """Sample unrelated configurations, shape (S, n).

        Each is a knot, so derivatives by knots equal derivatives by configurations.
        """
        support = np.arange(len(positions))
        weight = np.ones((len(positions), 1))
        return Motion(positions, support[:, None], weight, support.astype(np.float64), positions, query)

    @cached_property
    def kinematics(self) -> JointPlacements:
        """Placements and Jacobians of all joints at the samples, evaluated on first use."""
        return self.query.kinematics(self.positions)

    def where(self, mask: Bools) -> "Motion":
        """Return the motion with a subset of its samples."""
        index = np.flatnonzero(mask)
        return Motion(
            self.knots,
            self.support[index],
            self.weight[index],
            self.place[index],
            self.positions[index],
            self.query,
        )

    def rows(self, sample: Ints, value: Floats, jacobian: Floats, component: Ints) -> Rows:
        """Chain derivatives by a sample's configuration to the knots that it depends on.

        Args:
            sample: Sample of each row, shape (m,).
            value: Residuals, shape (m,).
            jacobian: Derivatives by the sample's configuration, shape (m, n).
            component: Component of each row, shape (m,).
        """
        return Rows(
            value,
            self.weight[sample][:, :, None] * jacobian[:, None, :],
            self.support[sample],
            component,
            self.place[sample],
        )

    def rows_of_all(self, value: Floats, jacobian: Floats) -> Rows:
        """Return rows of a residual with d components at every sample.

        Args:
            value: Shape (S, d).
            jacobian: Derivatives by the samples' configurations, shape (S, d, n).
        """
        count, dim = value.shape
        sample = np.repeat(np.arange(count, dtype=np.int64), dim)
        component = np.tile(np.arange(dim, dtype=np.int64), count)
        return self.rows(sample, value.ravel(), jacobian.reshape(count * dim, jacobian.shape[-1]), component)


@dataclass(frozen=True, eq=False)
class MotionInTime(Motion):
    """A motion whose samples have times.

    Attributes:
        times: Time of each sample, shape (S,) [s].
    """

    times: Floats

    def where(self, mask: Bools) -> "MotionInTime":
        part = super().where(mask)
        fields = (part.knots, part.support, part.weight, part.place, part.positions, part.query)
        return MotionInTime(*fields, self.times[mask])
