"""Transcription by a B-spline: the same rows as over knots, over control points.

A spline lies within the hull of its control points, so that bounds on these keep joint positions within
their limits everywhere, not at samples only.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.optimise.transcription.basis import SplineBasis
from trajopt.optimise.transcription.compilable import CompilableMotionNlp
from trajopt.optimise.transcription.knots import KnotsNlp, swept_samples
from trajopt.problem.motion import Motion
from trajopt.values.arrays import Floats, Ints, readonly
from trajopt.values.trajectory import Path, Trajectory

COARSE_SAMPLES = 2
"""Samples per piece while the motion is not free yet."""


@dataclass(frozen=True, eq=False)
class KnotPlaces:
    """Places of the spline on the polyline over knots, to which windows and margins refer.

    Attributes:
        parameters: Of the spline, increasing from 0 to 1, shape (m,).
        knots: The place there, in knots, from 0 to the last, shape (m,).
        exact: Parameters that must be samples, shape (w,): of waypoints.
    """

    parameters: Floats
    knots: Floats
    exact: Floats

    def __call__(self, parameters: Floats) -> Floats:
        """Return the places at parameters."""
        return np.interp(parameters, self.parameters, self.knots)

    @staticmethod
    def along(
        polyline: Floats, motion: Trajectory, waypoint_knots: Sequence[int] = (), begin: float = 0.0
    ) -> "KnotPlaces":
        """Match a motion, from a time on, to a polyline by equal shares of their lengths.

        Args:
            polyline: Knots, shape (N, n) [rad | m].
            motion: The motion.
            waypoint_knots: The knots of waypoints.
            begin: Time from which it is on the polyline [s].
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
    """The program over control points.

    Attributes:
        basis: The spline.
        places: Places of its parameters along the motion over knots.
    """

    basis: SplineBasis
    places: KnotPlaces

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        """Return samples per piece: few, or as many as the sweep of the bodies demands."""
        pieces = len(self.basis.breaks) - 1
        if not fine:
            return np.full(pieces, COARSE_SAMPLES)
        corners = self.basis.at(self.basis.breaks)(x)
        return swept_samples(self.query, corners, COARSE_SAMPLES)

    def motion(self, x: Floats, sampling: Ints) -> Motion:
        """Sample the spline at every break, `sampling - 1` parameters between, and waypoints."""
        parameters, stencils = self.basis.sampled(sampling, self.places.exact)
        places = self.places(parameters)
        return Motion(x, stencils.support, stencils.weight, places, stencils(x), self.query)

    def decode(self, x: Floats) -> Path:
        """Return a path through points of the spline, as dense as its finest samples."""
        sampling = self.sampling(x, fine=True)
        return Path(self.problem.reduced.joint_names, readonly(self.motion(x, sampling).positions))


def over_control_points(
    base: KnotsNlp, basis: SplineBasis, places: KnotPlaces, *, resting: int = 1
) -> BsplineNlp:
    """Transcribe a problem over the control points of a spline.

    Args:
        base: The problem over knots.
        basis: The spline.
        places: Places of its parameters along the motion.
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
