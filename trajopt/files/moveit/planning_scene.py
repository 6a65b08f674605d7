"""Planning scene messages: whole scenes from files, and edits of a scene."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

from trajopt.files.messages import (
    AllowedCollisionEntry,
    AllowedCollisionMatrix,
    OctomapWithPose,
    PlanningScene,
    PlanningSceneWorld,
    TransformStamped,
    field_names,
)
from trajopt.files.moveit.frames import Reading, frame_id, read_placement, require, world_names
from trajopt.files.moveit.objects import apply_attached, apply_object, read_object, without
from trajopt.files.moveit.scene_messages import (
    attached_messages,
    layered_positions,
    placed_robot,
    read_joint_positions,
)
from trajopt.robot.bodies import MeshPolicy
from trajopt.robot.robot import Robot
from trajopt.scene.clearances import AllowedCollisions, Clearances
from trajopt.scene.scene import Scene
from trajopt.scene.track import Prediction, Track
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node, read_document, read_list
from trajopt.values.errors import FrameNotFound, ModelError, ObjectNotFound, ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement, placement


def apply_matrix(node: Node, scene: Scene, notes: list[str]) -> Scene:
    """Return the scene with the message's allowed-collision matrix in place of the robot's.

    The matrix replaces the description's entries for pairs of links that it both names. A matrix without
    pairs only adds its defaults. If two defaults apply to a pair, both must allow contact, as in MoveIt.
    """
    node.only(field_names(AllowedCollisionMatrix))
    names = [name.text() for name in node["entry_names"].elements()]
    defaults = _defaults(node)
    if len(set(names)) != len(names):
        raise node["entry_names"].error("a name comes twice")
    if not names and not defaults:
        return scene
    rows = _rows(node, len(names))
    known = frozenset((*scene.robot.links, *scene.objects))
    strangers = sorted({*names, *defaults} - known)
    if strangers:
        notes.append(f"{node.place}: left out, being neither link nor object: {', '.join(strangers)}")
    kept = {name: allowed for name, allowed in defaults.items() if name in known}
    described = (pair for pair in scene.robot.disabled_pairs if not pair <= set(names))
    entries = dict.fromkeys(described, True) if names else dict(scene.allowed.entries)
    conflicts = (pair for pair in combinations(kept, 2) if kept[pair[0]] != kept[pair[1]])
    entries = dict.fromkeys(map(frozenset, conflicts), False) | entries
    for (i, a), (j, b) in combinations(enumerate(names), 2):
        if rows[i][j] != rows[j][i]:
            notes.append(f"{node.place}: {a} and {b} differ by order; the row of {a} counts")
        if a in known and b in known:
            _set(entries, frozenset((a, b)), rows[i][j], kept)
    if names:
        _note_unnamed(node, names, scene, notes)
    if not entries and not kept:
        # A scene without any entry would fall back to the robot's own matrix.
        a, b = (*scene.robot.links, *scene.robot.links)[:2]
        entries[frozenset((a, b))] = False
    return replace(scene, allowed=AllowedCollisions(entries, kept))


def _set(
    entries: dict[frozenset[str], bool], pair: frozenset[str], allowed: bool, defaults: dict[str, bool]
) -> None:
    entries.pop(pair, None)
    if allowed != any(defaults.get(name, False) for name in pair):
        entries[pair] = allowed


def _defaults(node: Node) -> dict[str, bool]:
    names = node["default_entry_names"].elements()
    values = node["default_entry_values"].elements()
    if len(names) != len(values):
        raise node["default_entry_names"].error(f"{len(names)} names, but {len(values)} values")
    return {name.text(): value.flag() for name, value in zip(names, values, strict=True)}


def _rows(node: Node, count: int) -> list[list[bool]]:
    rows: list[list[bool]] = []
    for row in node["entry_values"].elements():
        cells = (
            row if isinstance(row.value, list) else row.only(field_names(AllowedCollisionEntry))["enabled"]
        )
        rows.append([cell.flag() for cell in cells.elements()])
        if len(rows[-1]) != count:
            raise row.error(f"{len(rows[-1])} values for {count} names")
    if len(rows) != count:
        raise node["entry_values"].error(f"{len(rows)} rows for {count} names")
    return rows


def _note_unnamed(node: Node, names: list[str], scene: Scene, notes: list[str]) -> None:
    owners = dict.fromkeys(body.owner for body in scene.robot.bodies)
    unnamed = [owner for owner in owners if owner not in names]
    if unnamed:
        notes.append(
            f"{node.place}: does not name {', '.join(unnamed)}: "
            "their contacts that the robot's description allows stay allowed"
        )


@dataclass(frozen=True, eq=False)
class SceneFile:
    """The content of a planning scene file.

    Attributes:
        state: Joint positions given in the file, by joint [rad | m].
        notes: Sentences on omissions and deviations from the file.
    """

    path: Path
    scene: Scene
    state: Mapping[str, float]
    world_names: frozenset[str]
    notes: tuple[str, ...]

    @property
    def positions(self) -> Floats:
        return layered_positions(self.scene.robot, self.state)


@checked
def read_scene(path: Path | str, robot: Robot, *, meshes: MeshPolicy | None = None) -> SceneFile:
    """Read a `moveit_msgs/PlanningScene` from YAML.

    Objects in the frame of a link are placed in the world at the file's robot state. A fixed frame in a frame
    of the robot becomes a tool frame (`Scene.with_tool`). Link padding and scale: see `with_padding`. Colours
    are ignored.

    Args:
        meshes: Conversion of meshes to convex shapes; the default policy when None.
    """
    return scene_of(read_document(path), robot, meshes=meshes)


def scene_of(document: Node, robot: Robot, *, meshes: MeshPolicy | None = None) -> SceneFile:
    """Return the content of a planning scene message; see `read_scene`."""
    document.only(field_names(PlanningScene))
    notes: list[str] = []
    robot = placed_robot(document["robot_state"]["multi_dof_joint_state"], robot, notes)
    state = read_joint_positions(document["robot_state"], robot, notes)
    names = world_names(robot) | _planning_frame(document, robot)
    reading = Reading(names, layered_positions(robot, state), meshes, notes)
    model = document["robot_model_name"].text("")
    if model not in ("", robot.name):
        notes.append(f"robot_model_name: made for {model!r}, read for {robot.name!r}")
    if document["is_diff"].flag():
        notes.append("is_diff: read as a whole scene, starting from an empty world")
    scene = _edited(document, Scene(robot), reading, again=False)
    return SceneFile(Path(document.path), scene, state, names, tuple(notes))


def _planning_frame(document: Node, robot: Robot) -> frozenset[str]:
    names = {frame_id(document["robot_state"]["multi_dof_joint_state"]["header"])}
    for node in document["fixed_frame_transforms"].elements():
        child = node["child_frame_id"].text("").removeprefix("/")
        if frame_id(node["header"]) in ("", child):
            names.add(child)
    return frozenset(names - set(robot.frame_names))


def with_fixed_frame(node: Node, scene: Scene, reading: Reading, *, again: bool) -> Scene:
    """Return the scene with a frame fixed in the world or on the robot; `again` moves an existing one."""
    # MoveIt writes the world into child_frame_id and the frame's name into the header; tf the
    # other way round. In both cases the transform is the pose of the frame in the world.
    node.only(field_names(TransformStamped))
    where = read_placement(node["transform"], reading.notes)
    frames = {frame_id(node["header"]), node["child_frame_id"].text("").removeprefix("/")}
    others = sorted(frames - reading.world_names)
    known = [frame for frame in others if frame in scene.frame_names]
    if len(others) == 2 and len(known) == 1:
        return _with_tool(node, scene, where, *known, *(frame for frame in others if frame not in known))
    if not others:
        if where != Placement():
            raise node.error("displaces the world from itself")
        return scene
    if len(others) == len(frames):
        raise node.error(f"neither of {', '.join(others)} is the world")
    name = others[0]
    if name in scene.robot.frame_names:
        reading.notes.append(f"{node.place}: {name!r} is a frame of the robot, which comes first")
        return scene
    if name in scene.objects:
        if again and not scene.object(name).parts:
            return scene.move(name, where, frame=WORLD)
        raise node.error(f"the frame {name!r} is given twice")
    return scene.add(name, (), where)


def _with_tool(node: Node, scene: Scene, where: Placement, on: str, name: str) -> Scene:
    try:
        return scene.with_tool(name, on, where)
    except ModelError as error:
        raise node.error(str(error)) from error


def refuse_octomap(node: Node) -> None:
    octomap = node.only(field_names(OctomapWithPose))["octomap"]
    if octomap.has("data") and octomap["data"].value:
        raise octomap.error("octomaps are not supported; use boxes, and leave no obstacle out")


def with_padding(document: Node, scene: Scene, notes: list[str]) -> Scene:
    """Return the scene with a message's link padding and link scale.

    A padding is the clearance of the link and its attached objects from world objects, as in MoveIt. A scale
    applies to the link's collision shapes: primitives about their origin, meshes about the mean of their
    vertices.
    """
    robot, scales = scene.robot, dict[str, float]()
    for node in document["link_scale"].elements():
        link, scale = _of_link(node, scene, "scale", 1.0)
        if scale <= 0.0:
            raise node["scale"].error(f"must be positive, is {scale:g}")
        scales[link] = scale
        if scale != 1.0:
            notes.append(
                f"{node.place}: {link} is scaled by {scale:g}, unlike in MoveIt also against the robot's "
                "other links; attached objects keep their size"
            )
    if any(scales.get(body.owner, body.scale) != body.scale for body in robot.bodies):
        try:
            bodies = tuple(body.scaled(scales.get(body.owner, body.scale)) for body in robot.bodies)
        except ShapeError as error:
            raise document["link_scale"].error(str(error)) from error
        scene = replace(scene, robot=replace(robot, bodies=bodies))
    paddings = dict(scene.clearances.links)
    for node in document["link_padding"].elements():
        link, padding = _of_link(node, scene, "padding", 0.0)
        if padding < 0.0:
            raise node["padding"].error(f"is negative: {padding:g} m")
        paddings[link] = padding
    paddings = {link: padding for link, padding in paddings.items() if padding > 0.0}
    return replace(scene, clearances=replace(scene.clearances, links=paddings))


def _of_link(node: Node, scene: Scene, key: str, default: float) -> tuple[str, float]:
    value = node.only(("link_name", key))[key].number(default)
    link = node["link_name"].text()
    require(node["link_name"], FrameNotFound, "link", link, scene.robot.links)
    return link, value


def edit_object(node: Node, scene: Scene, reading: Reading) -> Scene:
    """Return the scene after a collision object message."""
    return apply_object(read_object(node, reading), scene, reading)


def edit_scene(node: Node, scene: Scene, reading: Reading) -> Scene:
    """Return the scene after a planning scene message: changed if it `is_diff`, else replaced.

    The robot and its base pose are unchanged.
    """
    node.only(field_names(PlanningScene))
    if not node["is_diff"].flag():
        everywhere = Clearances(scene.clearances.everywhere, kinds=scene.clearances.kinds)
        robot = scene.robot
        if any(body.scale != 1.0 for body in robot.bodies):
            robot = replace(robot, bodies=tuple(body.scaled(1.0) for body in robot.bodies))
        scene = Scene(
            robot,
            margin=scene.margin,
            kind_margins=scene.kind_margins,
            clearances=everywhere,
            tools=scene.tools_on_links,
            model_error=scene.model_error,
        )
    elif _says_all(node["robot_state"]):
        scene = _let_go(scene)
    return _edited(node, scene, reading, again=True)


def _edited(node: Node, scene: Scene, reading: Reading, *, again: bool) -> Scene:
    for element in node["fixed_frame_transforms"].elements():
        scene = with_fixed_frame(element, scene, reading, again=again)
    world = node["world"].only(field_names(PlanningSceneWorld))
    refuse_octomap(world["octomap"])
    for element in world["collision_objects"].elements():
        scene = edit_object(element, scene, reading)
    for element in node["robot_state"]["attached_collision_objects"].elements():
        scene = apply_attached(element, scene, reading)
    scene = apply_matrix(node["allowed_collision_matrix"], scene, reading.notes)
    return with_padding(node, scene, reading.notes)


def _says_all(state: Node) -> bool:
    """Return whether the message has a complete robot state, which then lists all attached objects."""
    told = (
        state["joint_state"]["name"],
        state["multi_dof_joint_state"]["transforms"],
        state["attached_collision_objects"],
    )
    return not state["is_diff"].flag() and any(each.elements() for each in told)


def _let_go(scene: Scene) -> Scene:
    for name in attached_messages(scene):
        scene = without(scene, name)
    return scene


def without_collisions(scene: Scene) -> Scene:
    """Return the scene with every contact allowed."""
    everything = dict.fromkeys((*scene.robot.links, *scene.objects), True)
    return replace(scene, allowed=AllowedCollisions({}, everything))


FIELDS = (
    "object",
    "carried_by",
    "times",
    "positions",
    "orientations",
    "error",
    "until",
    "appears",
    "expires",
)
ERROR_FIELDS = ("radius", "velocity", "acceleration")


@checked
def read_motions(path: Path | str, scene: Scene) -> Scene:
    """Read the motions of a scene's objects, and their times of appearing and expiring.

    Raises:
        FileFormatError: If the file is incomplete or malformed, names an unknown object or names one twice,
            or the times do not increase.
    """
    return apply_motions(read_list(path), scene)


def apply_motions(document: Node, scene: Scene) -> Scene:
    """Return the scene with the object motions of a list; see `read_motions`."""
    done: set[str] = set()
    entries = list(document.elements())
    for entry in entries:
        name = entry.only(FIELDS)["object"].text()
        if name in done:
            raise entry["object"].error(f"{name!r} has two entries")
        done.add(name)
        try:
            scene = scene.with_motion(
                name,
                _motion(entry, scene.object(name).placement),
                appears=None if entry["appears"].missing else entry["appears"].number(infinite=True),
                expires=None if entry["expires"].missing else entry["expires"].number(infinite=True),
            )
        except ObjectNotFound as error:
            raise entry["object"].error(str(error)) from error
        except ModelError as error:
            raise entry.error(str(error)) from error
    for entry in entries:
        if not entry["carried_by"].missing:
            scene = _carried(entry, scene)
    return scene


def _carried(entry: Node, scene: Scene) -> Scene:
    name, carrier = entry["object"].text(), entry["carried_by"].text()
    if not entry["times"].missing:
        raise entry["carried_by"].error(f"{name!r} has times of its own, so nothing carries it")
    if carrier not in scene.objects:
        raise entry["carried_by"].error(str(ObjectNotFound("object", carrier, scene.objects)))
    if scene.object(name).frame != WORLD:
        raise entry["carried_by"].error(f"{name!r} is carried by {scene.object(name).frame!r} already")
    where = scene.holder(carrier).placement.inverse() * scene.object(name).placement
    try:
        return scene.move(name, where, frame=carrier)
    except ModelError as error:
        raise entry["carried_by"].error(str(error)) from error


def _motion(entry: Node, here: Placement) -> Prediction | None:
    if entry["times"].missing and entry["positions"].missing:
        for name in ("orientations", "error", "until"):
            if not entry[name].missing:
                raise entry[name].error("requires times and positions")
        return None
    positions = [node.numbers() for node in entry["positions"].elements()]
    given = [node.numbers() for node in entry["orientations"].elements()]
    turns = given or [tuple(here.quaternion.tolist())] * len(positions)
    if len(turns) != len(positions):
        raise entry["orientations"].error(f"are {len(turns)}, the positions are {len(positions)}")
    places = [placement(xyz, quaternion=turn) for xyz, turn in zip(positions, turns, strict=True)]
    error = entry["error"].only(ERROR_FIELDS)
    sizes = [error[name].number(0.0) for name in ERROR_FIELDS]
    until = entry["until"].number(float("inf"), infinite=True)
    return Prediction(Track.through(entry["times"].numbers(), places), (sizes[0], sizes[1], sizes[2]), until)
