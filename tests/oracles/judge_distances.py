"""The judge's signed distances in plain Python."""

import numpy as np

from tests.oracles.judge_geometry import CoalPairs, Solid, gaps, inside
from tests.oracles.largest_gap import largest_gap
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.values.shapes.shapes import Mesh, Plane, bounding_sphere
from trajopt.values.shapes.surfaces import part_points
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.pair_distances import DOUBTFUL, PairDistances
from trajopt.verify.kernel.shapes import hull_of

_FIRST_MEASURED = 48
"""So many pairs whose bounding spheres are nearest are measured before the others."""


class PlainDistances(PairDistances):
    """Workspace for signed distances of pairs of bodies in plain Python.

    Between convex bodies Coal proposes a direction and the gap along it is taken, which is a lower
    bound of the distance whatever Coal says. Distances to an exact mesh are Coal's.

    Attributes:
        centre: Centre of each body's bounding sphere in its joint's frame, shape (b, 3) [m].
        radius: Radius of each, infinite for planes, shape (b,) [m].
        joint: Joint that carries each body, shape (b,).
    """

    def __init__(self, reduced: ReducedModel, *, error: float) -> None:
        """Build Coal's geometries.

        Args:
            reduced: The model.
            error: Taken off every distance [m].

        Raises:
            ModelError: If two half-spaces have to keep apart.
        """
        super().__init__(Kinematics(reduced), error=error)
        self._calls = 0
        bodies = reduced.bodies
        spheres = [bounding_sphere(body.shape) for body in bodies]
        self.centre: Floats = np.array(
            [body.placement * centre for body, (centre, _) in zip(bodies, spheres, strict=True)]
        ).reshape(-1, 3)
        self.radius: Floats = np.array([radius for _, radius in spheres])
        self.joint: Ints = np.array([body.joint for body in bodies], dtype=np.int64)
        solids: list[Solid] = [Solid(body.owner, body.joint, body.placement, body.shape) for body in bodies]
        meshes = np.array([isinstance(solid.shape, Mesh) for solid in solids], dtype=np.bool_)
        self._meshed: Bools = (meshes[self.first] | meshes[self.second]) & ~self.planar
        hull: Ints = np.arange(len(solids), dtype=np.int64)
        for place, solid in enumerate(tuple(solids)):
            if isinstance(solid.shape, Mesh):
                hull[place] = len(solids)
                solids.append(Solid(solid.owner, solid.joint, solid.placement, hull_of(solid.shape)))
        self._solids = tuple(solids)
        # Pairs with hulls in the place of meshes follow behind the others.
        self._hulled: Ints = np.arange(len(self.first))
        self._hulled[self._meshed] = len(self.first) + np.arange(self._meshed.sum())
        self._one: Ints = np.concatenate((self.first, hull[self.first[self._meshed]]))
        self._other: Ints = np.concatenate((self.second, hull[self.second[self._meshed]]))
        self._coal = CoalPairs(reduced.model, self._solids, self._one, self._other)

    @property
    def calls(self) -> int:
        """Distances measured so far."""
        return self._calls

    def centres(self, poses: Poses) -> Floats:
        """Place the centres of the bodies' bounding spheres in the world, shape (c, b, 3) [m]."""
        turned = np.einsum("cbij,bj->cbi", poses.rotation[:, self.joint], self.centre)
        return turned + poses.translation[:, self.joint]

    def apart(self, centres: Floats, cell: Ints, pair: Ints) -> Floats:
        """Bound distances from below by bounding spheres.

        Args:
            centres: Of the bodies' spheres in the world, for c configurations, (c, b, 3) [m].
            cell: Which configuration, shape (i,).
            pair: Which pair, shape (i,).

        Returns:
            Shape (i,) [m]; minus infinity for half-spaces.
        """
        first, second = self.first[pair], self.second[pair]
        between = centres[cell, first] - centres[cell, second]
        spread = np.sqrt(np.einsum("ij,ij->i", between, between))
        return spread - self.radius[first] - self.radius[second]

    def measure(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure signed distances, less the error they may have, shape (i,) [m]."""
        result = np.full(len(cell), -np.inf)
        planar, meshed = self.planar[pair], self._meshed[pair]
        for number in np.unique(pair[planar]).tolist():
            chosen = planar & (pair == number)
            result[chosen] = self._height(poses, cell[chosen], number)
        result[meshed] = self._coal.measure(poses, cell[meshed], pair[meshed])[0] - self.error
        convex = ~planar & ~meshed
        result[convex] = self._convex(poses, cell[convex], pair[convex])
        touching = meshed & (result <= 0.0)
        for item in np.flatnonzero(meshed & ~touching).tolist():
            touching[item] = self._encloses(poses, int(cell[item]), int(pair[item]))
        result[touching] = np.minimum(
            result[touching], self.measure_hulls(poses, cell[touching], pair[touching])
        )
        self._calls += len(cell)
        return result

    def measure_hulls(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure pairs without half-spaces as `measure` does, with hulls in the place of meshes."""
        self._calls += len(cell)
        return self._convex(poses, cell, self._hulled[pair])

    def search_depths(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure pairs by a search of all directions, shape (i,) [m]."""
        self._calls += len(cell)
        found = [
            -np.inf if self.planar[number] else self._search(poses, row, int(self._hulled[number]))
            for row, number in zip(cell.tolist(), pair.tolist(), strict=True)
        ]
        return np.array(found) - self.error

    def meshed(self, pair: Ints) -> Bools:
        """Say which pairs have an exact mesh in them (and no half-space)."""
        return self._meshed[pair]

    def nearest(self, poses: Poses) -> Floats:
        """Measure every pair that may touch or be the nearest strict one, shape (p,) [m]."""
        count = len(self.first)
        cell, measured = np.zeros(count, dtype=np.int64), np.full(count, np.inf)
        lower = self.apart(self.centres(poses), cell, np.arange(count))
        order = np.argsort(lower, kind="stable")
        for some in (order[:_FIRST_MEASURED], order[_FIRST_MEASURED:]):
            nearest = float(measured[self.strict].min(initial=np.inf))
            near = some[lower[some] <= np.maximum(nearest, self.reduced.pairs.required[some])]
            measured[near] = self.measure(poses, cell[near], near)
        return measured

    def _encloses(self, poses: Poses, cell: int, pair: int) -> bool:
        """Say whether one body of a pair is enclosed by the other's exact mesh."""
        one, other = self._ends(pair)
        for solid, shell in ((one, other), (other, one)):
            if isinstance(shell.shape, Mesh):
                seen = shell.at(poses, cell).inverse() * solid.at(poses, cell)
                if inside(seen * part_points(solid.shape), shell.shape).any():
                    return True
        return False

    def _convex(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure pairs of convex bodies by the gap along the direction that Coal proposes."""
        proposed, normals = self._coal.measure(poses, cell, pair)
        length = np.linalg.norm(normals, axis=1)
        usable = np.isfinite(length) & (length > 0.5)
        normals[~usable] = (0.0, 0.0, 1.0)
        normals /= np.where(usable, length, 1.0)[:, None]
        found = gaps(
            self._solids,
            poses,
            cell,
            first=self._one[pair],
            second=self._other[pair],
            directions=normals,
        )
        for item in np.flatnonzero(~usable | (np.abs(found - proposed) > DOUBTFUL)).tolist():
            found[item] = max(found[item], self._search(poses, int(cell[item]), int(pair[item])))
        return found - self.error

    def _search(self, poses: Poses, cell: int, pair: int) -> float:
        one, other = self._ends(pair)
        return largest_gap(one.shape, other.shape, one.at(poses, cell).inverse() * other.at(poses, cell))

    def _ends(self, pair: int) -> tuple[Solid, Solid]:
        return self._solids[int(self._one[pair])], self._solids[int(self._other[pair])]

    def _height(self, poses: Poses, cell: Ints, pair: int) -> Floats:
        """Height of a body over a half-space."""
        one, other = self._ends(pair)
        plane, body = (one, other) if isinstance(one.shape, Plane) else (other, one)
        rotation, point = plane.in_world(poses, cell)
        normal = rotation[..., 2]
        lowest = -body.reach(poses, cell, -normal)
        return lowest - np.einsum("ij,ij->i", normal, point) - self.error
