"""The scene in MuJoCo over time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trajopt.robot.bodies import MeshPolicy, cover_mesh
from trajopt.robot.joints import FixedBody
from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.reduced import ReducedModel, TimedModel
from trajopt.scene.track import Prediction, Timing
from trajopt.values.arrays import Floats, Ints, readonly
from trajopt.values.placement import IDENTITY, Placement, scalar_first
from trajopt.values.printed import in_length
from trajopt.values.shapes.clouds import Points, Voxels, centres_of, fewer
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Plane, Shape, Sphere, convex

NOWHERE = ("nothing", "nothing else")
"""Names of two specks that never touch; they replace pairs of which one body is absent."""
SPECK = 1e-3
"""Their radius, much smaller than their distance [m]."""


@dataclass(frozen=True, eq=False)
class DynamicScene:
    """A scene over time.

    Attributes:
        whole: The reduced model with all objects; joints driven by time come after its own.
        timed: The part that changes; None if the scene is static.
        tracks: Name of a frame that moves by itself -> its motion.
    """

    whole: ReducedModel
    timed: TimedModel | None
    tracks: Mapping[str, Prediction]

    @staticmethod
    def of(reduced: ReducedModel) -> "DynamicScene":
        timed, objects = reduced.timed, reduced.scene.objects
        if timed is None:
            return DynamicScene(reduced, None, {})
        moved = {name: objects[name].timing.motion for name in timed.timings}
        tracks = {name: motion for name, motion in moved.items() if motion is not None}
        return DynamicScene(timed.reduced, timed, tracks)

    @property
    def timings(self) -> Mapping[str, Timing]:
        return {} if self.timed is None else self.timed.timings

    def present(self, name: str, time: float) -> bool:
        return self.timed is None or self.timed.there(name, time)

    def error(self, name: str, time: float) -> float:
        return 0.0 if self.timed is None else self.timed.error(name, time)

    def is_uncertain(self, name: str) -> bool:
        return self.timed is not None and self.timed.is_uncertain(name)

    def moved(self, name: str, time: float) -> Placement:
        timing = self.timings.get(name)
        if timing is None or timing.motion is None:
            return IDENTITY
        track = timing.motion.track
        return track.at(time) * track.at(0.0).inverse()

    def state(self, time: float) -> Floats:
        flags = np.array([(float(self.present(name, time)), self.error(name, time)) for name in self.timings])
        places = [motion.track.at(time).homogeneous.ravel() for motion in self.tracks.values()]
        return np.concatenate((flags.ravel(), *places))

    def placement(self, body: FixedBody) -> Placement:
        carrier = self._carriers.get(body.joint)
        if carrier is None:
            return body.placement
        return self.whole.anchors[carrier].placement.inverse() * body.placement

    def add_frames(
        self, spec: mujoco.MjSpec, joints: Sequence[mujoco.MjsBody]
    ) -> Mapping[int, mujoco.MjsBody]:
        moved = {
            joint: spec.worldbody.add_body(name=name, mocap=True) for joint, name in self._carriers.items()
        }
        return {**dict(enumerate(joints)), **moved}

    def put(self, model: mujoco.MjModel, data: mujoco.MjData, time: float) -> None:
        for name, motion in self.tracks.items():
            where, place = motion.track.at(time), int(model.body(name).mocapid[0])
            data.mocap_pos[place], data.mocap_quat[place] = where.translation, scalar_first(where)

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence for each object with a position error, which is simulated exactly on its track."""
        errors: dict[str, tuple[float, bool]] = {}
        for name, motion in self.tracks.items():
            thing = name.split("/")[0]
            first, grows = errors.get(thing, (0.0, False))
            errors[thing] = max(first, motion.error[0]), grows or any(motion.error[1:])
        return tuple(
            f"{thing}: simulated exactly on its track, from which it may be {in_length(first)} away"
            f"{' at first, and more with time' if grows else ''}"
            for thing, (first, grows) in errors.items()
            if first > 0.0 or grows
        )

    @property
    def _carriers(self) -> Mapping[int, str]:
        return {self.whole.anchors[name].joint: name for name in self.tracks}


def add_specks(spec: mujoco.MjSpec) -> None:
    for height, name in enumerate(NOWHERE):
        speck = spec.worldbody.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE)
        speck.size, speck.pos = np.full(3, SPECK), np.array((0.0, 0.0, float(height)))
        speck.mass, speck.contype, speck.conaffinity = 0.0, 0, 0
        speck.rgba = np.zeros(4)


class Presence:
    """Disables the pairs of absent bodies; one for each simulation."""

    def __init__(self, changing: DynamicScene, model: mujoco.MjModel, owners: Sequence[str]) -> None:
        self._changing, self._model = changing, model
        self._pairs = np.stack((model.pair_geom1, model.pair_geom2))
        come_and_go = {
            name
            for name, timing in changing.timings.items()
            if np.isfinite((timing.appears, timing.expires)).any()
        }
        self._of: dict[str, list[int]] = {name: [] for name in come_and_go}
        for pair, both in enumerate(self._pairs.T.tolist()):
            for geom in both:
                if owners[int(geom)] in come_and_go:
                    self._of[owners[int(geom)]].append(pair)

    def show(self, time: float) -> None:
        if not self._of:
            return
        model = self._model
        model.pair_geom1[:], model.pair_geom2[:] = self._pairs
        for name, pairs in self._of.items():
            if not self._changing.present(name, time):
                one, other = (self._model.geom(name).id for name in NOWHERE)
                model.pair_geom1[pairs], model.pair_geom2[pairs] = one, other


CONE_TOLERANCE = 5e-6
"""Largest distance of the pyramid around a cone from it [m]."""
MOST_CONE_SIDES = 512
"""Most sides of that pyramid; reached at a radius of 13 cm."""
MOST_OF_CLOUD = 5_000
"""Most spheres or cubes of a cloud; MuJoCo checks each of them in every step."""
HALF_SPACE_EDGE = 40.0
"""Edge of the box that replaces a half-space on a moving body [m]."""


@dataclass(frozen=True, eq=False)
class MujocoGeom:
    """Geometry of MuJoCo: vertices and outward faces of a mesh, empty for native types.

    Attributes:
        size: Size parameters of MuJoCo, shape (3,) [m].
        placement: In the frame of the shape.
    """

    kind: mujoco.mjtGeom
    size: Floats
    placement: Placement
    vertices: Floats
    faces: Ints


def mujoco_geoms(shape: Shape, *, moving: bool) -> tuple[tuple[MujocoGeom, ...], str]:
    """Return the geometries of a shape, and a sentence on the difference if they are not exact."""
    match shape:
        case Plane():
            return _half_space(moving=moving)
        case Cone():
            return _pyramid(shape)
        case Convex():
            return (surface(shape.vertices, shape.faces),), ""
        case Points() | Voxels():
            return _cloud(shape)
        case Mesh():
            cover = cover_mesh(shape, MeshPolicy())
            hulls = (hull for hull in cover.shapes if isinstance(hull, Convex))
            parts = tuple(surface(hull.vertices, hull.faces) for hull in hulls)
            return parts, f"the exact mesh is simulated by a cover that contains it: {cover.note}"
        case _:
            return (_primitive(shape),), ""


def surface(vertices: Floats, faces: NDArray[np.integer]) -> MujocoGeom:
    """Return a mesh, which is drawn exactly; contacts use its convex hull."""
    return MujocoGeom(mujoco.mjtGeom.mjGEOM_MESH, np.zeros(3), Placement(), vertices, faces.astype(np.int64))


def _primitive(shape: Box | Sphere | Cylinder | Capsule) -> MujocoGeom:
    kinds = mujoco.mjtGeom
    match shape:
        case Box():
            return _native(kinds.mjGEOM_BOX, shape.x / 2, shape.y / 2, shape.z / 2)
        case Sphere():
            return _native(kinds.mjGEOM_SPHERE, shape.radius)
        case Cylinder():
            return _native(kinds.mjGEOM_CYLINDER, shape.radius, shape.length / 2)
        case Capsule():
            return _native(kinds.mjGEOM_CAPSULE, shape.radius, shape.length / 2)


def _native(kind: mujoco.mjtGeom, *size: float) -> MujocoGeom:
    padded = np.zeros(3)
    padded[: len(size)] = size
    return MujocoGeom(kind, readonly(padded), Placement(), np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))


def _cloud(cloud: Points | Voxels) -> tuple[tuple[MujocoGeom, ...], str]:
    shown = fewer(cloud, MOST_OF_CLOUD)
    one = _primitive(Sphere(shown.radius) if isinstance(shown, Points) else Box(*(shown.size,) * 3))
    each = tuple(
        replace(one, placement=Placement(translation=readonly(at.copy()))) for at in centres_of(shown)
    )
    if shown is cloud:
        return each, ""
    return each, f"{cloud} is simulated as {shown}, which contains it"


def _half_space(*, moving: bool) -> tuple[tuple[MujocoGeom, ...], str]:
    if not moving:
        return (_native(mujoco.mjtGeom.mjGEOM_PLANE, 0.0, 0.0, 1.0),), ""
    half = HALF_SPACE_EDGE / 2
    box = _native(mujoco.mjtGeom.mjGEOM_BOX, half, half, half)
    below = Placement(translation=readonly(np.array((0.0, 0.0, -half))))
    moved = MujocoGeom(box.kind, box.size, below, box.vertices, box.faces)
    return (moved,), f"the moving half-space is simulated as a box with edges of {HALF_SPACE_EDGE:g} m"


def _pyramid(shape: Cone) -> tuple[tuple[MujocoGeom, ...], str]:
    least = np.pi * np.sqrt(shape.radius / (2.0 * CONE_TOLERANCE))
    sides = int(np.clip(np.ceil(least), 16, MOST_CONE_SIDES))
    outer = shape.radius / np.cos(np.pi / sides)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    base = np.stack((outer * np.cos(angle), outer * np.sin(angle), np.full(sides, -shape.length / 2)), axis=1)
    points = np.vstack((base, (0.0, 0.0, shape.length / 2)))
    excess = outer - shape.radius
    hull = convex(points)
    note = f"the cone is simulated as a pyramid of {sides} sides, up to {excess:.1e} m larger"
    return (surface(hull.vertices, hull.faces),), note
