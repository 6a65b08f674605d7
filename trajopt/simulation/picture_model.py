"""The MuJoCo model for pictures, and its state at a time of a motion."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.robot.loading.urdf import LinkGeometry
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import tool_frames, tool_point
from trajopt.simulation.dynamic_scene import DynamicScene, MujocoGeom, mujoco_geoms, surface
from trajopt.simulation.halo import THINNEST, Halo, halo, has_halo
from trajopt.simulation.sampled_motion import SampledMotion
from trajopt.simulation.spec import add_geom, add_joints
from trajopt.values.arrays import Floats
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import MeshFileError
from trajopt.values.placement import Placement, from_quaternion, scalar_first
from trajopt.values.shapes.clouds import Points, Voxels, cloud_surface
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Plane, Shape, placed_box

Colour = tuple[float, float, float, float]

FLOOR_GROUP, ROBOT_GROUP, OBJECT_GROUP, HALO_GROUP, UNSEEN_GROUP = range(5)
"""Geometry groups of MuJoCo: the floor; robot, attached and loose objects; other objects; halos of objects
with a position error; absent objects."""
HALO = 0.18
HALO_BUILT = 0.01
"""Initial distance of halos, which need some size as surfaces [m]."""

LIGHT_LINK: Colour = (0.90, 0.91, 0.92, 1.0)
DARK_LINK: Colour = (0.52, 0.55, 0.59, 1.0)
ATTACHED: Colour = (0.95, 0.55, 0.15, 1.0)
ALARM: Colour = (0.86, 0.15, 0.18, 1.0)
ALARM_OBJECT: Colour = (0.86, 0.15, 0.18, 0.45)
WOOD: Colour = (0.80, 0.66, 0.48, 1.0)
PALETTE: tuple[Colour, ...] = (
    (0.42, 0.60, 0.74, 1.0),
    (0.56, 0.69, 0.52, 1.0),
    (0.78, 0.57, 0.53, 1.0),
    (0.62, 0.56, 0.73, 1.0),
    (0.83, 0.74, 0.50, 1.0),
    (0.45, 0.67, 0.66, 1.0),
)
FARTHEST = 15.0
"""Distance at which the floor fades into the sky, in sizes of the shown region."""
WOODEN = ("table", "shelf", "desk", "bench", "board", "pallet")
"""An object whose name contains one of these words is drawn as wood."""


@dataclass(frozen=True, eq=False)
class PictureSpec:
    """A model for pictures.

    Attributes:
        owners: Name of a geometry -> its object, for objects that the robot does not move.
        coming: Name of a geometry -> its object, for objects that appear or expire.
        halos: Name of the geometry of a halo -> its object, and the halo.
    """

    spec: mujoco.MjSpec
    owners: dict[str, str]
    changing: DynamicScene
    coming: dict[str, str]
    halos: dict[str, tuple[str, Halo]]


def picture_spec(
    reduced: ReducedModel,
    shown: Floats,
    *,
    loose: Collection[str] = (),
    highlight: frozenset[str] = frozenset(),
) -> PictureSpec:
    """Return a model for pictures.

    Args:
        shown: Points around the shown region, shape (k, 3) in the world [m].
        loose: Names of loose objects, which become mocap bodies.
    """
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    bodies, _ = add_joints(spec, reduced)
    low, high = shown.min(axis=0), shown.max(axis=0)
    spec.stat.center = (low + high) / 2
    spec.stat.extent = max(float(np.linalg.norm(high - low)) / 2, 0.01)
    _set_the_stage(spec, _floor_height(reduced, float(low[2])))
    for count, (joint, where, piece, colour) in enumerate(_robot_pieces(reduced, highlight)):
        geom = add_geom(spec, bodies[joint], f"robot {count}", piece, where)
        geom.rgba, geom.group, geom.material = np.array(colour), ROBOT_GROUP, "paint"
    colours = object_colours(reduced, loose) | dict.fromkeys(highlight, ALARM_OBJECT)
    links = reduced.scene.robot.links
    changing = DynamicScene.of(reduced)
    frames = changing.add_frames(spec, bodies)
    picture = PictureSpec(spec, {}, changing, {}, {})
    count = 0
    free = {name: spec.worldbody.add_body(name=name, mocap=True) for name in loose}
    for body in changing.whole.bodies:
        if body.owner in links or isinstance(body.shape, Plane):
            continue
        carrier, where = frames[body.joint], changing.placement(body)
        if body.owner in free:
            carrier, where = free[body.owner], reduced.attachment(body.owner)[1].inverse() * where
        for piece in _drawn_geoms(body.shape):
            name = f"object {count}"
            count += 1
            geom = add_geom(spec, carrier, name, piece, where)
            geom.rgba, geom.material = np.array(colours[body.owner]), "paint"
            carried = 0 < body.joint < reduced.model.njoints or body.owner in free
            geom.group = ROBOT_GROUP if carried else OBJECT_GROUP
            if not carried:
                picture.owners[name] = body.owner
            if body.owner in changing.timings:
                picture.coming[name] = body.owner
        if changing.is_uncertain(body.owner) and has_halo(body):
            grown = halo(body.shape, where)
            piece = surface(grown.grown(HALO_BUILT), grown.faces)
            geom = add_geom(spec, carrier, f"halo {count}", piece, Placement())
            geom.rgba, geom.group = np.array((*colours[body.owner][:3], HALO)), HALO_GROUP
            picture.halos[geom.name] = body.owner, grown
    return picture


def object_colours(reduced: ReducedModel, loose: Collection[str] = ()) -> dict[str, Colour]:
    """Choose a colour for each object: accent if attached or loose, wood by its name, or one of the palette.

    Objects with equal names before a slash share a colour: "other/link1" and "other/link2" are one robot.
    """
    carried = {body.owner for body in reduced.scene.carried_bodies()}
    colours: dict[str, Colour] = {}
    used: dict[str, Colour] = {}
    for name in reduced.scene.objects:
        if name in carried or name in loose:
            colours[name] = ATTACHED
        elif any(word in name.lower() for word in WOODEN):
            colours[name] = WOOD
        else:
            colours[name] = used.setdefault(name.split("/")[0], PALETTE[len(used) % len(PALETTE)])
    return colours


def _drawn_geoms(shape: Shape) -> tuple[MujocoGeom, ...]:
    if isinstance(shape, Mesh):
        return (surface(shape.vertices, shape.faces),)
    if isinstance(shape, Points | Voxels):
        return (surface(*cloud_surface(shape)),)
    return mujoco_geoms(shape, moving=False)[0]


def _robot_pieces(
    reduced: ReducedModel, highlight: frozenset[str]
) -> Iterator[tuple[int, Placement, MujocoGeom, Colour]]:
    robot = reduced.scene.robot
    drawn, failed = _visual_pieces(robot)
    for visual, piece in drawn:
        plain = visual.colour or _link_colour(reduced, visual.link)
        joint, placed = reduced.attachment(visual.link)
        yield joint, placed * visual.placement, piece, ALARM if visual.link in highlight else plain
    for body in reduced.bodies:
        if body.owner in failed or (not robot.visuals and body.owner in robot.links):
            for piece in _drawn_geoms(body.shape):
                plain = _link_colour(reduced, body.owner)
                yield body.joint, body.placement, piece, ALARM if body.owner in highlight else plain


@cached_per_value
def _visual_pieces(robot: Robot) -> tuple[tuple[tuple[LinkGeometry, MujocoGeom], ...], frozenset[str]]:
    read: list[tuple[LinkGeometry, MujocoGeom]] = []
    failed: set[str] = set()
    for visual in robot.visuals:
        try:
            read.extend((visual, piece) for piece in _drawn_geoms(visual.shape))
        except MeshFileError:
            failed.add(visual.link)
    return tuple(pair for pair in read if pair[0].link not in failed), frozenset(failed)


def _link_colour(reduced: ReducedModel, link: str) -> Colour:
    robot = reduced.scene.robot
    hands = {name for effector in robot.end_effectors.values() for name in _links_of(reduced, effector.group)}
    return DARK_LINK if link in hands else LIGHT_LINK


def _links_of(reduced: ReducedModel, group: str) -> tuple[str, ...]:
    groups = reduced.scene.robot.groups
    return groups[group].links if group in groups else ()


def _floor_height(reduced: ReducedModel, lowest: float) -> float:
    for body in reduced.bodies:
        if body.joint:
            continue
        if not isinstance(body.shape, Plane):
            lowest = min(lowest, float(placed_box(body.shape, body.placement)[0, 2]))
        elif body.placement.rotation[2, 2] > 1.0 - 1e-9:
            return float(body.placement.translation[2])
    # Not in the plane of a table top or base plate, with which it would flicker.
    return min(lowest, 0.0) - 1e-3


def _set_the_stage(spec: mujoco.MjSpec, floor: float) -> None:
    visual = spec.visual
    visual.quality.offsamples = 4
    visual.quality.numslices, visual.quality.numstacks = 40, 16
    visual.headlight.ambient = np.full(3, 0.52)
    visual.headlight.diffuse = np.full(3, 0.20)
    visual.headlight.specular = np.full(3, 0.05)
    visual.rgba.haze = np.array((0.94, 0.96, 0.98, 1.0))
    visual.map.haze, visual.map.shadowclip = 0.5, 2.5
    visual.map.zfar = FARTHEST
    textures, marks = mujoco.mjtTexture, mujoco.mjtMark
    sky = spec.add_texture(name="sky", type=textures.mjTEXTURE_SKYBOX, width=128, height=768)
    sky.builtin = mujoco.mjtBuiltin.mjBUILTIN_GRADIENT
    sky.rgb1, sky.rgb2 = np.array((0.80, 0.88, 0.96)), np.array((0.94, 0.96, 0.98))
    grid = spec.add_texture(name="grid", type=textures.mjTEXTURE_2D, width=512, height=512)
    grid.builtin, grid.mark = mujoco.mjtBuiltin.mjBUILTIN_CHECKER, marks.mjMARK_EDGE
    grid.rgb1, grid.rgb2 = np.array((0.86, 0.88, 0.90)), np.array((0.83, 0.85, 0.87))
    grid.markrgb = np.array((0.76, 0.79, 0.82))
    ground = spec.add_material(name="ground", texuniform=True, specular=0.0, shininess=0.0)
    ground.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "grid"
    ground.texrepeat = np.array((2.0, 2.0))
    spec.add_material(name="paint", specular=0.25, shininess=0.35)
    plane = spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE)
    plane.size, plane.pos = np.array((0.0, 0.0, 0.05)), np.array((0.0, 0.0, floor))
    plane.material, plane.group = "ground", FLOOR_GROUP
    plane.contype, plane.conaffinity = 0, 0
    key = spec.worldbody.add_light(name="key", type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
    key.diffuse, key.specular, key.ambient = np.full(3, 0.45), np.full(3, 0.25), np.zeros(3)
    key.castshadow = True


def adapt_to_camera(model: mujoco.MjModel, azimuth: float, distance: float) -> None:
    """Place the light above and to the left behind a camera, and extend the view to its distance [m]."""
    model.vis.map.zfar = FARTHEST + distance / model.stat.extent
    towards = azimuth - np.deg2rad(50.0)
    direction = np.array((0.55 * np.cos(towards), 0.55 * np.sin(towards), -1.0))
    key = model.light("key").id
    model.light_dir[key] = direction / np.linalg.norm(direction)
    model.light_pos[key] = model.stat.center - 2.5 * model.stat.extent * model.light_dir[key]


T = TypeVar("T")
PATH_POINTS = 61


class PosedModel:
    """The MuJoCo model of robot and scene for pictures, with paths of tools (tools, PATH_POINTS, 3) [m]."""

    def __init__(
        self,
        reduced: ReducedModel,
        motion: SampledMotion,
        shown: Floats,
        highlight: Iterable[str] = (),
    ) -> None:
        self._reduced, self.motion = reduced, motion
        picture = picture_spec(reduced, shown, loose=tuple(motion.placements), highlight=frozenset(highlight))
        self.model = picture.spec.compile()
        self.data = mujoco.MjData(self.model)
        self.owners = self._numbered(picture.owners)
        self.changing = picture.changing
        self._coming = self._numbered(picture.coming)
        self._group = {geom: int(self.model.geom_group[geom]) for geom in self._coming}
        self._halos = self._numbered(picture.halos)
        names = tuple(reduced.model.names[1:])
        self._address = [self.model.jnt_qposadr[self.model.joint(name).id] for name in names]
        self._bodies = [int(self.model.jnt_bodyid[self.model.joint(name).id]) for name in names]
        self.paths = tool_paths(reduced, motion)

    def pose(self, t: float) -> None:
        """Set the state at a time [s]."""
        reduced, changing, data = self._reduced, self.changing, self.data
        for name, where in self.motion.loose_at(t).items():
            place = int(self.model.body(name).mocapid[0])
            data.mocap_pos[place], data.mocap_quat[place] = where.translation, scalar_first(where)
        changing.put(self.model, data, t)
        for geom, owner in self._coming.items():
            self.model.geom_group[geom] = self._group[geom] if changing.present(owner, t) else UNSEEN_GROUP
        for geom, (owner, _) in self._halos.items():
            shown = changing.present(owner, t) and changing.error(owner, t) > THINNEST
            self.model.geom_group[geom] = HALO_GROUP if shown else UNSEEN_GROUP
        self.data.qpos[self._address] = reduced.mimic_matrix @ self.motion(t) + reduced.mimic_offset
        mujoco.mj_kinematics(self.model, self.data)

    def grow_halos(self, t: float) -> tuple[int, ...]:
        """Give halos their size at a time [s]; return the changed meshes."""
        model = self.model
        meshes: list[int] = []
        for geom, (owner, grown) in self._halos.items():
            mesh = int(model.geom_dataid[geom])
            begin, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
            w, x, y, z = model.mesh_quat[mesh].tolist()
            own = Placement(from_quaternion(x, y, z, w), model.mesh_pos[mesh]).inverse()
            model.mesh_vert[begin : begin + count] = own * grown.grown(self.changing.error(owner, t))
            meshes.append(mesh)
        return tuple(meshes)

    def skeleton(self) -> Floats:
        parents = self.model.body_parentid[self._bodies]
        inner = parents > 0
        ends = self.data.xpos[np.array(self._bodies)[inner]]
        return np.stack((self.data.xpos[parents[inner]], ends), axis=1)

    def _numbered(self, named: Mapping[str, T]) -> dict[int, T]:
        return {self.model.geom(name).id: value for name, value in named.items()}


def tool_paths(reduced: ReducedModel, motion: SampledMotion) -> Floats:
    """Return the paths of the tools of the group, shape (tools, PATH_POINTS, 3) in the world [m]."""
    along = [motion(t) for t in np.linspace(0.0, motion.duration, PATH_POINTS)]
    return np.array([[tool_point(reduced, tool, at) for at in along] for tool in tool_frames(reduced)])
