"""Signed distances of pairs of bodies, and the search for a proof of clearance, by the native core."""

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.native import proof
from trajopt.verify.kernel.kinematics import Poses
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.native_forms import native_form
from trajopt.verify.kernel.native_kinematics import NativeKinematics
from trajopt.verify.kernel.pair_distances import PairDistances
from trajopt.verify.kernel.windows import Windows
from trajopt.verify.search.clearance_record import Contact, Findings, Gap, Tally


class NativeDistances(PairDistances):
    """Workspace for distances of pairs whose loops are compiled."""

    def __init__(self, kinematics: NativeKinematics, *, error: float) -> None:
        """Hand the bodies to the core.

        Args:
            kinematics: Of the model.
            error: Taken off every distance [m].

        Raises:
            ModelError: If two half-spaces have to keep apart.
        """
        super().__init__(kinematics.reduced)
        self._kinematics = kinematics
        bodies = self.reduced.bodies
        self._proof = proof.Proof(
            kinematics.arm,
            [native_form(body.shape) for body in bodies],
            np.array([body.joint for body in bodies], dtype=np.int64),
            np.array([body.placement.rotation for body in bodies]),
            np.array([body.placement.translation for body in bodies]),
            self.first,
            self.second,
            self.reduced.pairs.required,
            ~self.strict,
            error,
        )
        self._error = error

    @property
    def calls(self) -> int:
        """Distances measured so far."""
        return self._proof.calls

    def measure(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure signed distances, shape (i,) [m]."""
        return self._proof.measure(poses.rotation, poses.translation, cell, pair)

    def measure_hulls(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure with hulls in the place of exact meshes, shape (i,) [m]."""
        return self._proof.measure_hulls(poses.rotation, poses.translation, cell, pair)

    def search_depths(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure by a search of all directions, shape (i,) [m]."""
        return self._proof.search_depths(poses.rotation, poses.translation, cell, pair)

    def nearest(self, poses: Poses) -> Floats:
        """Measure every pair that may touch or be the nearest strict one, shape (p,) [m]."""
        return self._proof.nearest(poses.rotation, poses.translation, self.strict)

    def search(self, motion: Motion) -> Findings:
        """Search for a proof that all pairs keep apart over a motion."""
        trajectory, reduced, options = motion.trajectory, self.reduced, motion.options
        windows = Windows(reduced.pairs, motion.duration)
        windowed = np.flatnonzero(~self.strict)
        free, accepted, contacts, gap, configurations = self._proof.search(
            trajectory.times,
            np.ascontiguousarray(trajectory.coefficients),
            motion.differentiable,
            reduced.mimic_matrix,
            reduced.mimic_offset,
            windowed,
            windows.rows(windowed),
            windows.edges,
            np.array(
                (
                    options.resolution,
                    options.far,
                    options.smallest_interval,
                    options.most_distances,
                    self._error,
                )
            ),
        )
        self._kinematics.calls += configurations
        return Findings(
            Tally(*free),
            Tally(*accepted),
            tuple(Contact(int(pair), float(time), float(distance)) for pair, time, distance in contacts),
            Gap(*gap) if gap[0] >= 0 else None,
            windows,
        )
