"""Signed distances of the pairs of bodies that are judged, by the native core."""

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType

import numpy as np

from trajopt.native import proof
from trajopt.scene.timing import Timing
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.values.errors import ModelError
from trajopt.values.shapes.shapes import Mesh, Plane
from trajopt.verify.kernel.forms import form_of
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.required import required_clearances

NONE: Mapping[str, Timing] = MappingProxyType({})
"""Nothing changes with time."""
DOUBTFUL = 1e-5
"""Where a distance by Coal and the gap along its normal differ by more, all directions are searched [m]."""


class PairDistances:
    """Workspace for signed distances of pairs of bodies; one for each thread.

    A distance is positive between bodies apart and minus the depth in penetration. Each is a lower
    bound of the true one, from the judge's own support functions; that of half-spaces is exact. An
    exact mesh has no depth, so its convex hull stands for it in contact and around what it encloses.

    Attributes:
        reduced: The model.
        first: Index of the first body of each pair, shape (p,).
        second: Index of the second, shape (p,).
        planar: Whether a half-space is in each pair, shape (p,).
        core: The bodies and pairs as the native core knows them.
        error: Taken off every distance [m].
        present: When both of each pair are there, from and to, shape (p, 2) [s]; None where nothing changes.
        changing: Whether one of each pair moves by itself, appears or expires, shape (p,).
    """

    def __init__(self, kinematics: Kinematics, *, error: float, timings: Mapping[str, Timing] = NONE) -> None:
        """Pass the bodies and pairs of a model to the core.

        Args:
            kinematics: Of the model.
            error: Taken off every distance [m].
            timings: Of the objects that change with time, by name; how far they may be off their tracks is
                taken off their distances too.

        Raises:
            ModelError: If two half-spaces have to keep apart.
        """
        reduced = kinematics.reduced
        self.reduced, self.error = reduced, error
        self.first, self.second = reduced.pairs.first, reduced.pairs.second
        planes = np.array([isinstance(body.shape, Plane) for body in reduced.bodies], dtype=np.bool_)
        self.planar: Bools = planes[self.first] | planes[self.second]
        both = planes[self.first] & planes[self.second]
        if both.any():
            pair = int(both.argmax())
            raise ModelError(f"half-spaces {self.pair_name(pair)} meet always; allow their contact")
        bodies = reduced.bodies
        self.present: Floats | None = None
        self.changing: Bools = np.zeros(len(self.first), dtype=np.bool_)
        errors = self._changing(timings)
        self.core = proof.Proof(
            kinematics.arm,
            [form_of(body.shape) for body in bodies],
            np.array([body.joint for body in bodies], dtype=np.int64),
            np.array([body.placement.rotation for body in bodies]),
            np.array([body.placement.translation for body in bodies]),
            self.first,
            self.second,
            required_clearances(reduced),
            errors,
            ~self.strict | errors.any(axis=1),
            error,
        )

    def _changing(self, timings: Mapping[str, Timing]) -> Floats:
        """Note when pairs are there, and return how the error of each grows, shape (p, 3)."""
        errors: Floats = np.zeros((len(self.first), 3))
        if not timings:
            return errors
        present: Floats = np.tile((-np.inf, np.inf), (len(self.first), 1))
        owners = np.array([body.owner for body in self.reduced.bodies])
        for side in (self.first, self.second):
            of_pair = owners[side]
            for name, timing in timings.items():
                mine = of_pair == name
                self.changing |= mine
                present[mine, 0] = np.maximum(present[mine, 0], timing.appears)
                present[mine, 1] = np.minimum(present[mine, 1], timing.expires)
                if timing.motion is not None:
                    errors[mine] += timing.motion.error
        self.present = present
        return errors

    def owners(self, pair: int) -> tuple[str, str]:
        """Return the links or objects of a pair."""
        return self.reduced.owners(pair)

    def pair_name(self, pair: int) -> str:
        """Return the links or objects of a pair as one text."""
        return " - ".join(self.owners(pair))

    @cached_property
    def owner_pairs(self) -> Ints:
        """Number of the two links or objects of each pair, the same for the same two, shape (p,)."""
        numbers: dict[str, int] = {}
        owner = np.array(
            [numbers.setdefault(body.owner, len(numbers)) for body in self.reduced.bodies], dtype=np.int64
        )
        return owner[self.first] * len(numbers) + owner[self.second]

    @cached_property
    def strict(self) -> Bools:
        """Whether both of a pair are always there and their contact is never accepted, shape (p,)."""
        return self.always_apart(self.present)

    def always_apart(self, present: Floats | None) -> Bools:
        """Say of which pairs contact is never accepted, shape (p,).

        Args:
            present: When pairs are looked at, from and to, shape (p, 2) [s]; always when None.
        """
        strict = np.ones(len(self.first), dtype=np.bool_)
        strict[[pair for pair, _ in self.reduced.pairs.allowances]] = False
        if present is None:
            return strict
        return strict & (present[:, 0] == -np.inf) & (present[:, 1] == np.inf)

    def present_since(self, clock: float) -> Floats | None:
        """Return `present` by a clock that shows 0 when the scene's shows so much [s]."""
        return self.present if self.present is None or clock == 0.0 else self.present - clock

    def uncertainty(self, pair: Ints, distance: Floats, error: float) -> Floats:
        """Return by how much true distances may exceed measured ones.

        Where an exact mesh is in contact, its hull was measured, which says nothing about the mesh.

        Args:
            pair: Which pairs, shape (i,).
            distance: As measured, shape (i,) [m].
            error: Taken off every distance [m].

        Returns:
            Shape (i,) [m].
        """
        hulled = self._meshed[pair] & ~self.planar[pair] & (distance <= 0.0)
        return np.where(hulled, np.inf, 2.0 * error + DOUBTFUL)

    @cached_property
    def _meshed(self) -> Bools:
        """Whether an exact mesh is in each pair, shape (p,)."""
        meshes = np.array([isinstance(body.shape, Mesh) for body in self.reduced.bodies], dtype=np.bool_)
        return meshes[self.first] | meshes[self.second]

    @property
    def calls(self) -> int:
        """Distances measured so far."""
        return self.core.calls

    def measure(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure signed distances, less the error they may have.

        Args:
            poses: Of the robot at c configurations.
            cell: Which configuration, shape (i,).
            pair: Which pair, shape (i,).

        Returns:
            Shape (i,) [m].
        """
        return self.core.measure(*_placed(poses), cell, pair)

    def measure_hulls(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure pairs without half-spaces as `measure` does, with hulls in the place of meshes."""
        return self.core.measure_hulls(*_placed(poses), cell, pair)

    def search_depths(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure pairs by a search of all directions: slow, and right where Coal's depth is not.

        Args:
            poses: Of the robot at c configurations.
            cell: Which configuration, shape (i,).
            pair: Which pair, shape (i,).

        Returns:
            Lower bounds of the distances, those between the hulls of exact meshes, shape (i,) [m];
            minus infinity for half-spaces.
        """
        return self.core.search_depths(*_placed(poses), cell, pair)

    def nearest(self, poses: Poses) -> Floats:
        """Measure, in the first configuration, every pair that may touch or be the nearest strict one.

        Returns:
            Infinite for the others, shape (p,) [m].
        """
        return self.core.nearest(*_placed(poses), self.strict)


def _placed(poses: Poses) -> tuple[Floats, Floats, Floats]:
    """Return when and where the joint frames are, as the core takes them."""
    times = np.zeros(len(poses.rotation)) if poses.times is None else poses.times
    return np.ascontiguousarray(times), poses.rotation, poses.translation
