"""Messages of a robot among its objects: joint states, frames and shapes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.files.log.logs import FRAMES, JOINTS, SCENE, Json, Log, stamp
from trajopt.geometry import evaluator
from trajopt.robot.joints import FixedBody
from trajopt.scene.reduced import ReducedModel, TimedModel
from trajopt.values.arrays import Floats, Value
from trajopt.values.placement import WORLD, Placement, placement
from trajopt.values.shapes.clouds import cloud_surface
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import (
    Box,
    Capsule,
    Cone,
    Convex,
    Cylinder,
    Plane,
    Points,
    Shape,
    Sphere,
    Voxels,
)
from trajopt.values.trajectory import Trajectory

LINK: Json = {"r": 0.8, "g": 0.81, "b": 0.83, "a": 1.0}
OBJECT: Json = {"r": 0.47, "g": 0.67, "b": 0.87, "a": 1.0}
FLOOR = (4.0, 4.0, 1e-3)
"""Size of the box that shows a half-space [m]."""
DELETE_ALL = 1
PRIMITIVES = ("cubes", "spheres", "cylinders", "triangles")
UNUSED = ("metadata", "arrows", "lines", "texts", "models")


def write_joint_states(log: Log, names: Sequence[str], times: Floats, states: Floats) -> None:
    """Write joint states at times (k,) [s]: positions and perhaps their derivatives, (k, 1 to 3, n)."""
    orders = ("position", "velocity", "acceleration")[: states.shape[1]]
    for time, rows in zip(times.tolist(), states, strict=True):
        columns = zip(names, rows.T.tolist(), strict=True)
        joints = [{"name": name, **dict(zip(orders, row, strict=True))} for name, row in columns]
        log.add(JOINTS, time, {"timestamp": stamp(time), "joints": joints})


def motion(begin: float, trajectory: Trajectory) -> Json:
    """Return a message of a motion that begins at a time [s]."""
    rates = {"velocities": trajectory.velocities, "accelerations": trajectory.accelerations}
    return {
        "begin": stamp(begin),
        "joint_names": list(trajectory.joint_names),
        "times": trajectory.times.tolist(),
        "positions": trajectory.positions.tolist(),
        **{name: list[float]() if rows is None else rows.tolist() for name, rows in rates.items()},
    }


@dataclass(frozen=True, eq=False)
class RobotMessages(Value):
    """Messages of a robot and a scene."""

    reduced: ReducedModel

    def write(self, log: Log, times: Floats, positions: Floats, clock: Floats) -> None:
        """Write the frames at some times, and the scene.

        The scene is written first, and again when objects appear or disappear.
        """
        shown: tuple[str, ...] | None = None
        for time, frames, there in zip(
            times.tolist(), self._frames(positions, clock), self._there(clock), strict=True
        ):
            log.add(FRAMES, time, {"transforms": [_transform(time, name, at) for name, at in frames]})
            if there != shown:
                shown = there
                log.add(SCENE, time, self.scene(time, there))

    def scene(self, time: float, names: Sequence[str]) -> Json:
        now = stamp(time)
        entities = [self._entity(name, now) for name in names]
        return {"deletions": [{"timestamp": now, "type": DELETE_ALL, "id": ""}], "entities": entities}

    @cached_property
    def _timed(self) -> TimedModel | None:
        return self.reduced.timed

    @property
    def _model(self) -> ReducedModel:
        return self.reduced if self._timed is None else self._timed.reduced

    @cached_property
    def _bodies(self) -> dict[str, list[FixedBody]]:
        found = dict[str, list[FixedBody]]()
        for body in self._model.bodies:
            found.setdefault(body.owner, []).append(body)
        return found

    def _there(self, clock: Floats) -> Iterator[tuple[str, ...]]:
        timed = self._timed
        for time in clock.tolist():
            yield tuple(name for name in self._bodies if timed is None or timed.there(name, time))

    def _frames(self, positions: Floats, clock: Floats) -> Iterator[list[tuple[str, Placement]]]:
        timed = self._timed
        placed = evaluator(self._model).kinematics(
            positions if timed is None else timed.positions(positions, clock)
        )
        for rotation, translation in zip(placed.rotation, placed.translation, strict=True):
            joints = [Placement(*each) for each in zip(rotation, translation, strict=True)]
            yield [
                (name, joints[anchor.joint] * anchor.placement)
                for name, anchor in self._model.anchors.items()
                if name != WORLD
            ]

    def _entity(self, name: str, now: Json) -> Json:
        colour = OBJECT if name in self._model.scene.objects else LINK
        primitives: dict[str, list[Json]] = {kind: [] for kind in PRIMITIVES}
        frame = self._model.anchors[name].placement.inverse()
        for body in self._bodies[name]:
            for kind, primitive in _primitives(body.shape, frame * body.placement):
                primitives[kind].append({**primitive, "color": colour})
        return {
            "timestamp": now,
            "frame_id": name,
            "id": name,
            "lifetime": {"sec": 0, "nsec": 0},
            "frame_locked": True,
            **{kind: list[Json]() for kind in UNUSED},
            **primitives,
        }


def _transform(time: float, name: str, at: Placement) -> Json:
    pose = _pose(at)
    return {
        "timestamp": stamp(time),
        "parent_frame_id": WORLD,
        "child_frame_id": name,
        "translation": pose["position"],
        "rotation": pose["orientation"],
    }


def _primitives(shape: Shape, at: Placement) -> Iterator[tuple[str, Json]]:
    match shape:
        case Box():
            yield "cubes", _sized(at, (shape.x, shape.y, shape.z))
        case Plane():
            yield "cubes", _sized(at * placement((0.0, 0.0, -FLOOR[2] / 2.0)), FLOOR)
        case Sphere():
            yield "spheres", _sized(at, (2.0 * shape.radius,) * 3)
        case Cylinder() | Cone():
            yield "cylinders", _round(at, shape.radius, shape.length, 0.0 if isinstance(shape, Cone) else 1.0)
        case Capsule():
            yield "cylinders", _round(at, shape.radius, shape.length, 1.0)
            for end in (-0.5, 0.5):
                centre = at * placement((0.0, 0.0, end * shape.length))
                yield "spheres", _sized(centre, (2.0 * shape.radius,) * 3)
        case Points() | Voxels():
            yield "triangles", _triangles(at, *cloud_surface(shape))
        case Convex() | Mesh():
            yield "triangles", _triangles(at, shape.vertices, shape.faces)


def _sized(at: Placement, size: Sequence[float]) -> Json:
    return {"pose": _pose(at), "size": _vector(size)}


def _round(at: Placement, radius: float, length: float, top: float) -> Json:
    size = (2.0 * radius, 2.0 * radius, length)
    return {**_sized(at, size), "bottom_scale": 1.0, "top_scale": top}


def _triangles(at: Placement, vertices: Floats, faces: np.ndarray) -> Json:
    points = [_vector(each) for each in vertices.tolist()]
    return {"pose": _pose(at), "points": points, "colors": list[Json](), "indices": faces.ravel().tolist()}


def _pose(at: Placement) -> Json:
    x, y, z, w = at.quaternion
    orientation = {"x": float(x), "y": float(y), "z": float(z), "w": float(w)}
    return {"position": _vector(at.translation.tolist()), "orientation": orientation}


def _vector(values: Sequence[float]) -> Json:
    return dict(zip("xyz", values, strict=True))
