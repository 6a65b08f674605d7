"""Distance of a line of sight from the objects of the scene.

In an object's frame only the ends of the line move. With n the normal from the object to the line and s
the place of the nearest point along it, d' = n . ((1 - s) c' + s p') for the camera c and the target p.
"""

from dataclasses import dataclass

import coal
import numpy as np

from trajopt.geometry.geometry import collision_geometry
from trajopt.optimise.terms.frames import RelativeFrame, relative_frame
from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion, MotionInTime
from trajopt.problem.requirements import LineOfSight
from trajopt.problem.residual import Constraint, Window, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Rows
from trajopt.values.errors import ProblemError, shown
from trajopt.values.placement import WORLD, Placement
from trajopt.values.shapes.clouds import Points, Voxels
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Shape, bounding_sphere

ACTIVATION = 0.1
"""Objects within the margin and this of the line get rows [m]."""
THICKNESS = 1e-3
"""Radius of the capsule that models the line; subtracted again [m]."""


@dataclass(frozen=True, eq=False)
class SightClearance:
    """Distance between the line of sight and each part of each object near it [m].

    Components are numbers of parts, over all objects that count. If the line goes through a part, it is the
    negative depth by which the line must be moved aside. Objects that move are at their predicted placements
    at each sample's time, less the prediction error; samples without times have no rows of them.
    """

    reduced: ReducedModel
    required: LineOfSight

    units = ("m",)

    @property
    def name(self) -> str:
        return f"line of sight of {self.required.frame}"

    def linearise(self, motion: Motion) -> Rows:
        need, reduced = self.required, self.reduced
        sample: list[int] = []
        value: list[float] = []
        slope: list[Floats] = []
        component: list[int] = []
        number = 0
        for name in _counted(need, reduced):
            camera, target, error = _seen_from(reduced, motion, need, name)
            for shape, where in reduced.scene.object(name).parts:
                for row in _near(shape, where, camera, target, need.margin + ACTIVATION + error):
                    distance, normal, share = _measured(shape, where, camera.point[row], target.point[row])
                    rate = (1.0 - share) * camera.point_jacobian[row] + share * target.point_jacobian[row]
                    sample.append(row)
                    value.append(distance - error[row])
                    slope.append(normal @ rate)
                    component.append(number)
                number += 1
        joints = motion.positions.shape[1]
        return motion.rows(
            np.array(sample, dtype=np.int64),
            np.array(value, dtype=np.float64),
            np.array(slope, dtype=np.float64).reshape(-1, joints),
            np.array(component, dtype=np.int64),
        )


def _counted(need: LineOfSight, reduced: ReducedModel) -> tuple[str, ...]:
    names = need.obstacles(reduced.scene)
    for name in names:
        shapes = [shape for shape, _ in reduced.scene.object(name).parts]
        if any(isinstance(shape, Mesh) for shape in shapes):
            raise ProblemError(
                f"{need}: object {shown(name)} has an exact mesh; add it as convex pieces, or ignore it"
            )
        if any(isinstance(shape, Points | Voxels) for shape in shapes):
            raise ProblemError(
                f"{need}: object {shown(name)} is a cloud, which no line of sight is measured to; add what"
                " may not be in between as boxes or hulls, and ignore the cloud"
            )
    return names


def _seen_from(
    reduced: ReducedModel, motion: Motion, need: LineOfSight, name: str
) -> tuple[RelativeFrame, RelativeFrame, Floats]:
    """Return camera, target and error (S,) [m] in an object's frame; -inf without times."""
    scene = reduced.scene
    carrier = scene.carrier(name)
    seen_from = WORLD if carrier else name
    camera = relative_frame(reduced, motion, need.frame, seen_from, need.origin)
    target = relative_frame(reduced, motion, need.reference, seen_from, need.target)
    prediction = None if carrier is None else scene.object(carrier).timing.motion
    if prediction is None:
        return camera, target, np.zeros(len(motion.positions))
    if not isinstance(motion, MotionInTime):
        return camera, target, np.full(len(motion.positions), -np.inf)
    times = motion.times.tolist()
    places = [scene.placement_at(name, time) for time in times]
    error = np.array([prediction.error_at(time) for time in times])
    return camera.seen_from(places), target.seen_from(places), error


def _near(
    shape: Shape, where: Placement, camera: RelativeFrame, target: RelativeFrame, reach: Floats
) -> list[int]:
    middle, radius = bounding_sphere(shape)
    begin, way = camera.point, target.point - camera.point
    centre = where * middle
    square = np.maximum(np.einsum("si,si->s", way, way), 1e-18)
    share = np.clip(np.einsum("si,si->s", centre - begin, way) / square, 0.0, 1.0)
    apart = np.linalg.norm(begin + share[:, None] * way - centre, axis=1)
    return np.flatnonzero(~(apart - radius >= reach)).tolist()


def _measured(shape: Shape, where: Placement, camera: Floats, target: Floats) -> tuple[float, Floats, float]:
    way = target - camera
    length = max(float(np.linalg.norm(way)), 1e-9)
    line = coal.Capsule(THICKNESS, length)
    placed = coal.Transform3s(_upright(way / length), (camera + target) / 2.0)
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    request.gjk_tolerance = 1e-9
    at = coal.Transform3s(where.rotation, where.translation)
    distance = coal.distance(collision_geometry(shape), at, line, placed, request, result)
    nearest = np.array(result.getNearestPoint2()) - camera
    share = float(np.clip(nearest @ way / length**2, 0.0, 1.0))
    return float(distance) + THICKNESS, np.array(result.normal), share


def _upright(axis: Floats) -> Floats:
    if np.linalg.norm(axis) < 0.5:
        return np.eye(3)
    aside: Floats = np.zeros(3)
    aside[np.argmin(np.abs(axis))] = 1.0
    x = np.cross(aside, axis) / np.linalg.norm(np.cross(aside, axis))
    return np.stack((x, np.cross(axis, x), axis), axis=1).astype(np.float64)


@constrain.register
def _(
    required: LineOfSight, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    return (
        constraint(
            SightClearance(reduced, required),
            lower=required.margin * (1.0 + inset),
            upper=np.inf,
            tolerance=max(required.margin * inset * 0.5, 1e-9),
            window=window,
            reach=ACTIVATION - required.margin * inset,
        ),
    )
