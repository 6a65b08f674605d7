"""Recipes of problems: shared documents and a small row of a table."""

import json
from base64 import b64decode, b64encode
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any, Protocol, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from trajopt.files.bundle.bundle import named_members
from trajopt.files.bundle.codec import ArrayOf, BundleReader, BundleWriter, FileOf
from trajopt.files.bundle.containers import LARGEST, Archive, Members, array_bytes, write_archive
from trajopt.files.moveit.motion_plan_request import request_of
from trajopt.files.moveit.planning_scene import apply_motions, scene_of
from trajopt.lab.suite import installed_definitions
from trajopt.optimise.kinematics import random_configurations
from trajopt.problem.problem import Problem
from trajopt.robot.loading.pinocchio_model import placed_model, root_placement
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import one_of
from trajopt.values.cached import LruCache
from trajopt.values.documents.document import Node, parse_document, parse_list
from trajopt.values.errors import CampaignError, FileFormatError, ProblemError, shown
from trajopt.values.placement import WORLD, Placement, placement

DOCUMENT = "document.json"
SUFFIX, MESHES = ".zip", "meshes/"
VALUES_KEPT = 16
"""Robots, scenes and problems that a process keeps: campaigns process scenes in sequence."""
SHARED = (Robot, Scene)
"""Kinds that other documents refer to by key."""
NO_MATTER = frozenset({"visuals", "mesh_notes", "notes", "left_out", "urdf_path"})
"""Fields of a robot that planning does not use; left out of the hash."""

Kind = TypeVar("Kind")
Documents: TypeAlias = Path | Mapping[str, Mapping[str, bytes]]
"""Documents: their folder, or the members of each by its key."""


class Packer:
    """Turns values into documents, each once; `members` has the files of each by its key."""

    def __init__(self) -> None:
        self.members: dict[str, Mapping[str, bytes]] = {}
        self._known: dict[int, tuple[object, str]] = {}

    def key(self, value: Robot | Scene | Problem) -> str:
        known = self._known.get(id(value))
        if known is not None:
            return known[1]
        writer = self._writer(value)
        document = writer.document(value, type(value).__name__.lower())
        members = {DOCUMENT: _json(document), **named_members(writer)}
        key = _key(document, members)
        self.members.setdefault(key, members)
        self._known[id(value)] = value, key
        return key

    def statement(self, problem: Problem) -> dict[str, object]:
        writer = self._writer(problem)
        document = writer.document(problem, "problem")
        arrays = {name: b64encode(array_bytes(each)).decode() for name, each in writer.arrays.items()}
        return {"document": document, "arrays": arrays}

    def write(self, folder: Path) -> None:
        for key, members in self.members.items():
            write_archive(folder / f"{key}{SUFFIX}", members)

    def _writer(self, whole: object) -> BundleWriter:
        return BundleWriter(
            reference=lambda value, _: (
                {"stored": self.key(value)} if isinstance(value, SHARED) and value is not whole else None
            )
        )


class Library:
    """Makes values of documents, each once as long as it is kept."""

    def __init__(self, documents: Documents, *, meshes: Path | None = None) -> None:
        self._documents, self._meshes = documents, meshes
        self._made: LruCache[str, object] = LruCache(VALUES_KEPT)

    def robot(self, key: str) -> Robot:
        return self._one(key, Robot)

    def scene(self, key: str) -> Scene:
        return self._one(key, Scene)

    def problem(self, key: str) -> Problem:
        return self._one(key, Problem)

    def stated(self, statement: Mapping[str, Any]) -> Problem:
        arrays = cast("Mapping[str, str]", statement["arrays"])
        reader = self._reader(lambda name: _array(b64decode(arrays[name])), Path)
        return one_of("problem", reader.value(Node(statement["document"], "problem")), Problem)

    def _one(self, key: str, kind: type[Kind]) -> Kind:
        return one_of(key, self._made.get(key, lambda: self._read(key)), kind)

    def _read(self, key: str) -> object:
        known = self._documents
        members = Archive(known / f"{key}{SUFFIX}") if isinstance(known, Path) else Sent(key, known)
        try:
            document: object = json.loads(members.read(DOCUMENT))
        except ValueError as error:
            raise FileFormatError(str(members.path), f"{DOCUMENT} cannot be parsed: {error}") from error
        reader = self._reader(members.array, lambda name: self._file(members, name))
        return reader.value(Node(document, f"{members.path}: {DOCUMENT}"))

    def _reader(self, array_of: ArrayOf, file_of: FileOf) -> BundleReader:
        def stored(node: Node) -> object:
            return self._one(node.only(("stored",))["stored"].text(), object)

        return BundleReader(array_of, file_of, references={"stored": stored})

    def _file(self, members: Members, name: str) -> Path:
        if self._meshes is None or name not in members.names:
            return Path(Path(name).name)
        target = self._meshes / f"{members.path.stem[:12]}_{Path(name).name}"
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(members.read(name))
        return target


class Sent(Members):
    """The members of a document that were sent from elsewhere."""

    def __init__(self, key: str, documents: Mapping[str, Mapping[str, bytes]]) -> None:
        super().__init__(Path(key))
        self._held = documents.get(key, {})

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self._held)

    def read(self, name: str, *, most: int = LARGEST) -> bytes:
        if name not in self._held:
            raise self.error(f"has no member {name}")
        return self._held[name]


def sent_from(folder: Path) -> Mapping[str, Mapping[str, bytes]]:
    found = [Archive(path) for path in sorted(folder.glob(f"*{SUFFIX}"))]
    return {
        each.path.stem: {name: each.read(name) for name in each.names if not name.startswith(MESHES)}
        for each in found
    }


def digest(*parts: object) -> str:
    """Return the hash of plain data: 32 hexadecimal digits, the same on every machine."""
    return sha256(_json(parts)).hexdigest()[:32]


def _key(document: object, members: Mapping[str, bytes]) -> str:
    seen = sha256(_json(_essence(document)))
    for name in sorted(_named(_essence(document)) & members.keys()):
        seen.update(members[name])
    return seen.hexdigest()[:32]


def _essence(document: object) -> object:
    if isinstance(document, dict):
        stated = cast("dict[str, object]", document)
        left_out = NO_MATTER if stated.get("kind") == Robot.__name__ else frozenset[str]()
        return {name: each for name, each in stated.items() if name not in left_out}
    return document


def _named(item: object) -> set[str]:
    if isinstance(item, dict):
        stated = cast("dict[str, object]", item)
        here = {name for key in ("array", "file") if isinstance(name := stated.get(key), str)}
        return here.union(*map(_named, stated.values()))
    if isinstance(item, list):
        return set[str]().union(*map(_named, cast("list[object]", item)))
    return set()


def _array(data: bytes) -> NDArray[np.generic]:
    return cast("NDArray[np.generic]", np.load(BytesIO(data), allow_pickle=False))


def _json(document: object) -> bytes:
    return json.dumps(document, allow_nan=False, separators=(",", ":")).encode()


KEPT = 4
"""Derived scenes and models that a process keeps."""


class Workshop:
    """The library, with a cache of recent scenes and models."""

    def __init__(self, library: Library) -> None:
        self.library = library
        self._placed: LruCache[tuple[Scene, tuple[float, ...]], Scene] = LruCache(KEPT)
        self._reduced: LruCache[tuple[Scene, str], ReducedModel] = LruCache(KEPT)

    def reduced(self, scene: Scene, group: str) -> ReducedModel:
        return self._reduced.get(
            (scene, group), lambda: reduce_model(scene, group, scene.robot.positions(None))
        )

    def placed(self, scene: Scene, where: tuple[float, ...]) -> Scene:
        """Return a scene with the base of its robot elsewhere: x, y, z [m] and the turn about z [rad]."""
        return self._placed.get((scene, where), lambda: _with_base_at(scene, where))


class Recipe(Protocol):
    """Recipe of one problem: plain data that identifies the problem."""

    def problem(self, shop: Workshop, /) -> Problem:
        """Make the problem."""
        ...


@dataclass(frozen=True)
class Stated:
    """A problem as it was stated in Python."""

    statement: Mapping[str, Any]

    def problem(self, shop: Workshop, /) -> Problem:
        return shop.library.stated(self.statement)


@dataclass(frozen=True)
class FromMessages:
    """A problem of MoveIt's messages, as texts in YAML; the motions may be empty."""

    robot: str
    name: str
    scene: str
    request: str
    motions: str = ""

    def problem(self, shop: Workshop, /) -> Problem:
        robot = shop.library.robot(self.robot)
        around = scene_of(parse_document(self.scene, f"scene of {self.name}"), robot)
        scene = around.scene
        if self.motions:
            scene = apply_motions(parse_list(self.motions, f"motions of {self.name}"), scene)
        asked = request_of(
            parse_document(self.request, f"request of {self.name}"), scene, around.state, around.world_names
        ).problem()
        return replace(asked, name=self.name)


@dataclass(frozen=True)
class JointToJoint:
    """A motion between two configurations in a shared scene [rad | m]."""

    scene: str
    group: str
    start: tuple[float, ...]
    goal: tuple[float, ...]

    def problem(self, shop: Workshop, /) -> Problem:
        scene = shop.library.scene(self.scene)
        return _between(scene, self.group, self.start, self.goal, "joint to joint")


@dataclass(frozen=True)
class RandomMotion:
    """A motion between two random free configurations."""

    scene: str
    group: str
    seed: int
    number: int

    def problem(self, shop: Workshop, /) -> Problem:
        scene = shop.library.scene(self.scene)
        rng = np.random.default_rng((self.seed, self.number))
        found = random_configurations(shop.reduced(scene, self.group), 2, rng=rng)
        if len(found.positions) < 2:
            raise ProblemError(f"fewer than two of {found.drawn} random configurations are free")
        start, goal = found.positions.tolist()
        return _between(scene, self.group, start, goal, f"random motion {self.number}")


@dataclass(frozen=True)
class Perturbed:
    """A problem with objects displaced by up to `shift` [m] and turned about the vertical by `turn` [rad]."""

    base: str
    seed: int
    number: int
    shift: float
    turn: float

    def problem(self, shop: Workshop, /) -> Problem:
        base = shop.library.problem(self.base)
        rng, scene = np.random.default_rng((self.seed, self.number)), base.scene
        for name, item in base.scene.objects.items():
            change = rng.uniform(-1.0, 1.0, 4)  # drawn for every object, so that one more changes no other
            if item.frame != WORLD or item.timing.motion is not None:
                continue
            turned = placement(rpy=(0.0, 0.0, self.turn * float(change[3]))).rotation
            here = item.placement
            moved = Placement(turned @ here.rotation, here.translation + self.shift * change[:3])
            scene = scene.move(name, moved)
        return replace(base, scene=scene, name=f"{base.name}, perturbed {self.number}")


@dataclass(frozen=True)
class BasePlaced:
    """A problem with the robot's root at x, y, z [m] and a turn about z [rad]; goals in the world stay."""

    base: str
    where: tuple[float, float, float, float]

    def problem(self, shop: Workshop, /) -> Problem:
        base = shop.library.problem(self.base)
        return replace(base, scene=shop.placed(base.scene, tuple(self.where)))


@dataclass(frozen=True)
class Installed:
    """An instance of an installed problem."""

    name: str
    draw: int

    def problem(self, shop: Workshop, /) -> Problem:
        return installed_definitions((self.name,))[0].instance(self.draw).make()


RECIPES: Mapping[str, Callable[..., Recipe]] = {
    kind.__name__: kind
    for kind in (Stated, FromMessages, JointToJoint, RandomMotion, Perturbed, BasePlaced, Installed)
}


def written(recipe: Recipe) -> str:
    stated = asdict(cast("Any", recipe))
    return json.dumps({"recipe": type(recipe).__name__, **stated}, allow_nan=False, separators=(",", ":"))


def read(text: str) -> Recipe:
    """Return the recipe that `written` wrote."""
    stated = cast("dict[str, Any]", json.loads(text))
    kind = RECIPES.get(str(stated.pop("recipe", "")))
    if kind is None:
        raise CampaignError(f"no recipe of a problem: {shown(text)}")
    return kind(**stated)


def _between(scene: Scene, group: str, start: Any, goal: Any, name: str) -> Problem:
    joints = scene.robot.group(group).joints
    if len(start) != len(joints) or len(goal) != len(joints):
        raise ProblemError(f"start and goal must have a position of each of {len(joints)} joints of {group}")
    at, to = (dict(zip(joints, map(float, each), strict=True)) for each in (start, goal))
    return Problem(scene=scene, start=at, goal=to, group=group, name=name)


def _with_base_at(scene: Scene, where: tuple[float, ...]) -> Scene:
    robot = scene.robot
    if robot.base.joints:
        raise ProblemError(f"the base of {robot.name} moves by itself: state its joints at the start")
    x, y, z, yaw = where
    change = placement((x, y, z), rpy=(0.0, 0.0, yaw)) * root_placement(robot.model).inverse()
    return replace(scene, robot=replace(robot, model=placed_model(robot.model, change)))
