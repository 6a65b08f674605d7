"""Objects edited by hand; each edit is a function from a scene to a scene."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, replace
from enum import Enum
from itertools import count
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, TypeAlias, get_args

import numpy as np

from trajopt.files.moveit import read_scene, write_scene
from trajopt.optimise.kinematics import validity
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import ModelError, shown
from trajopt.values.placement import WORLD, Placement, placement
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Cylinder, Plane, Shape, Sphere, placed_box
from trajopt.viewer.live.panels import Lever
from trajopt.viewer.live.workbench import Workbench, hand_at

if TYPE_CHECKING:
    from viser import (
        ClientHandle,
        GuiButtonGroupHandle,
        GuiDropdownHandle,
        GuiEvent,
        GuiNumberHandle,
        GuiUploadButtonHandle,
        GuiVector3Handle,
        ViserServer,
    )

Sized: TypeAlias = Box | Cylinder | Sphere | Cone | Capsule
"""Shapes whose sizes are a few numbers."""
SMALLEST = 1e-3
"""No size is smaller: a slider at its end makes no object without volume [m]."""
DIRECTIONS = (pi / 4, -pi / 4, pi / 2, -pi / 2, 3 * pi / 4, -3 * pi / 4, 0.0, pi)
"""Directions of new objects about the robot's base, relative to the hand; preferably to the side."""
TOUCH = 1e-3
"""Accepted overlap of an object with the bounds of its support [m]."""
NEAREST = 0.3
"""Least distance of a new object from the base [m]."""


class ObjectKind(Enum):
    """Kinds of objects that are put up: each a shape of a size that a hand could grasp."""

    BOX = "box"
    CYLINDER = "cylinder"
    SPHERE = "sphere"

    @property
    def shape(self) -> Sized:
        match self:
            case ObjectKind.BOX:
                return Box(0.1, 0.1, 0.1)
            case ObjectKind.CYLINDER:
                return Cylinder(0.05, 0.2)
            case ObjectKind.SPHERE:
                return Sphere(0.05)


def sizes_of(scene: Scene, name: str) -> Mapping[str, float]:
    """Return the sizes of an object that can be changed, by field [m]; empty for a mesh."""
    parts = scene.object(name).parts
    if len(parts) != 1 or not isinstance(parts[0][0], get_args(Sized)):
        return {}
    shape: Shape = parts[0][0]
    return {each.name: float(getattr(shape, each.name)) for each in fields(shape) if each.init}


def added(reduced: ReducedModel, kind: ObjectKind) -> tuple[Scene, str]:
    """Return the scene with an object on the ground near the robot, if possible clear; and its name."""
    name = next(each for each in _names(kind) if each not in reduced.scene.objects)
    scenes = [reduced.scene.add(name, kind.shape, where) for where in _places(reduced, kind)]
    free = (scene for scene in scenes if _touches_nothing(scene, reduced))
    return next(free, scenes[0]), name


def resized(scene: Scene, name: str, sizes: Mapping[str, float]) -> Scene:
    """Resize an object; its allowed contacts stay."""
    item = scene.object(name)
    if not sizes_of(scene, name):
        raise ModelError(f"{shown(name)} is not a single shape with sizes, so it cannot be resized")
    ((shape, where),) = item.parts
    larger = replace(shape, **{key: max(value, SMALLEST) for key, value in sizes.items()})
    return replace(scene, objects={**scene.objects, name: replace(item, parts=((larger, where),))})


def moved(scene: Scene, name: str, where: Placement) -> Scene:
    if is_carried(scene, name):
        raise ModelError(f"the robot carries {shown(name)}: put it down first")
    return scene.move(name, where, frame=WORLD)


def grasped(reduced: ReducedModel, name: str, hand: str) -> Scene:
    joint = reduced.attachment(hand)[0]
    gripper = [link for link in reduced.scene.robot.links if reduced.attachment(link)[0] == joint]
    at = reduced.all_positions(reduced.start_positions)
    return reduced.scene.attach(name, hand, at=at, touch_links=gripper)


def put_down(reduced: ReducedModel, name: str) -> Scene:
    """Detach an object at its present place."""
    return reduced.scene.detach(name, at=reduced.all_positions(reduced.start_positions))


def is_carried(scene: Scene, name: str) -> bool:
    return scene.holder(name).link != WORLD


def _names(kind: ObjectKind) -> Iterator[str]:
    yield kind.value
    yield from (f"{kind.value} {number}" for number in count(2))


def _places(reduced: ReducedModel, kind: ObjectKind) -> Iterator[Placement]:
    robot = reduced.scene.robot
    base = reduced.scene.placement_of(robot.links[0], reduced.start).translation
    hand = hand_at(reduced, robot.links[-1], reduced.start_positions).translation - base
    far, ahead = max(float(np.linalg.norm(hand[:2])), NEAREST), float(np.arctan2(hand[1], hand[0]))
    low = min(float(base[2]), 0.0) + _height(kind.shape) / 2.0
    for turn in DIRECTIONS:
        x, y = base[:2] + far * np.array((np.cos(ahead + turn), np.sin(ahead + turn)))
        yield placement((float(x), float(y), low))


def _height(shape: Sized) -> float:
    match shape:
        case Box():
            return shape.z
        case Sphere():
            return 2.0 * shape.radius
        case Cylinder() | Cone():
            return shape.length
        case Capsule():
            return shape.length + 2.0 * shape.radius


def _touches_nothing(scene: Scene, reduced: ReducedModel) -> bool:
    there = reduce_model(scene, reduced.group, reduced.start)
    *others, last = (name for name in scene.objects if not is_carried(scene, name))
    mine = _bounds(scene, last)[0]
    every = np.array([each for other in others for each in _bounds(scene, other)]).reshape(-1, 2, 3)
    apart = (every[:, 0] > mine[1] - TOUCH) | (every[:, 1] < mine[0] + TOUCH)
    return bool(apart.any(axis=1).all()) and validity(there, there.start_positions).valid


def _bounds(scene: Scene, name: str) -> list[Floats]:
    at, parts = scene.holder(name).placement, scene.object(name).parts
    return [placed_box(shape, at * inner) for shape, inner in parts if not isinstance(shape, Plane)]


NONE: str = "none"
SIZES = 3
"""No shape has more sizes."""
FILE = "scene.yaml"
Change = Callable[[Callable[[], None]], None]


class ObjectsPanel:
    """Controls of the objects; the name of the chosen one is empty for none."""

    def __init__(
        self,
        server: "ViserServer",
        bench: Workbench,
        ask: Callable[[str, Callable[[], None]], None],
        choose: Callable[[str], None],
    ) -> None:
        self._server, self._bench, self._ask, self._choose = server, bench, ask, choose
        self.chosen = ""
        gui = server.gui
        self._add: GuiButtonGroupHandle = gui.add_button_group(
            "add", tuple(each.value for each in ObjectKind), hint="Put up an object beside the robot."
        )
        self._add.on_click(self._press_add)
        names: tuple[str, ...] = (NONE,)
        self._names: GuiDropdownHandle[str] = gui.add_dropdown(
            "object", names, hint="Choose one here, or click it in the picture."
        )
        self._names.on_update(self._pick)
        self._about = gui.add_folder("Chosen object", visible=False)
        with self._about:
            self._where: GuiVector3Handle = gui.add_vector3(
                "position [mm]", (0.0, 0.0, 0.0), step=5.0, hint="In the world; or drag its arrows and rings."
            )
            self._where.on_update(self._place)
            self._sizes: list[GuiNumberHandle[float]] = [self._size(place) for place in range(SIZES)]
            self._grasp = Lever(
                server, "Attach to the hand", "It moves along with the hand.", self._press_grasp
            )
            self._put = Lever(server, "Put down here", "It stays in its present place.", self._press_put)
            self._remove = Lever(server, "Remove", "Take it away.", self._press_remove, colour="red")
        self._save = Lever(
            server, "Save the scene ...", "The objects around the robot, as MoveIt's PlanningScene.",
            self._press_save, colour="gray",
        )  # fmt: skip
        self._load: GuiUploadButtonHandle = gui.add_upload_button(
            "Load a scene ...", hint="A MoveIt PlanningScene in YAML or JSON, in place of this.", color="gray"
        )
        self._load.on_upload(self._upload)
        self.show()

    def show(self) -> None:
        scene = self._bench.scene
        if self.chosen not in scene.objects:
            self.chosen = ""
        with self._server.atomic():
            self._names.options = (NONE, *scene.objects)
            self._names.value = self.chosen or NONE
            self._about.visible = bool(self.chosen)
            if self.chosen:
                self._show_chosen(scene)

    def choose(self, name: str) -> None:
        self.chosen = name
        self.show()
        self._choose(name)

    def move(self, where: Placement) -> None:
        name = self.chosen
        if name:
            self._change("object", lambda scene: moved(scene, name, where))

    def _show_chosen(self, scene: Scene) -> None:
        name, sizes = self.chosen, sizes_of(scene, self.chosen)
        carried = is_carried(scene, name)
        at = self._bench.placement_of(name).translation
        self._where.value = tuple(np.round(1000.0 * at, 1).tolist())
        self._where.disabled = carried
        for control, field in zip(self._sizes, [*sizes, *[""] * SIZES][:SIZES], strict=True):
            control.visible = bool(field)
            if field:
                control.label, control.value = f"{field} [mm]", round(1000.0 * sizes[field], 1)
        self._grasp.offer(not carried)
        self._put.offer(carried)
        self._remove.allow()

    def _change(self, kind: str, edit: Callable[[Scene], Scene]) -> None:
        self._ask(kind, lambda: self._bench.change(edit(self._bench.scene)))

    def _size(self, place: int) -> "GuiNumberHandle[float]":
        control = self._server.gui.add_number("size [mm]", 1.0, min=1.0, step=5.0, visible=False)

        @control.on_update
        def _(event: "GuiEvent[GuiNumberHandle[float]]") -> None:
            name, value = self.chosen, control.value / 1000.0
            if event.client is None or not name:
                return

            def edit(scene: Scene) -> Scene:
                field = list(sizes_of(scene, name))[place]
                return resized(scene, name, {field: value})

            self._change(f"size {place}", edit)

        return control

    def _place(self, event: "GuiEvent[GuiVector3Handle]") -> None:
        if event.client is not None and self.chosen:
            x, y, z = (each / 1000.0 for each in self._where.value)
            self.move(placement((x, y, z), quaternion=self._bench.placement_of(self.chosen).quaternion))

    def _pick(self, event: "GuiEvent[GuiDropdownHandle[str]]") -> None:
        if event.client is not None:
            value = self._names.value
            self._ask("choose", lambda: self.choose("" if value == NONE else value))

    def _press_add(self, _: object) -> None:
        kind = ObjectKind(self._add.value)

        def add() -> None:
            scene, name = added(self._bench.reduced, kind)
            self._bench.change(scene)
            self.chosen = name

        self._ask("add", add)

    def _press_grasp(self, _: object) -> None:
        name = self.chosen
        self._ask(
            "object",
            lambda: self._bench.change(grasped(self._bench.reduced, name, self._bench.hand)),
        )

    def _press_put(self, _: object) -> None:
        name = self.chosen
        self._ask("object", lambda: self._bench.change(put_down(self._bench.reduced, name)))

    def _press_remove(self, _: object) -> None:
        name = self.chosen
        self._change("object", lambda scene: scene.remove(name))

    def _press_save(self, client: "ClientHandle | None") -> None:
        if client is not None:
            bench = self._bench
            with TemporaryDirectory() as folder:
                file = Path(folder) / FILE
                write_scene(file, bench.scene, bench.reduced.start)
                client.send_file_download(FILE, file.read_bytes())

    def _upload(self, _: object) -> None:
        uploaded = self._load.value
        suffix = Path(uploaded.name).suffix or ".yaml"

        def load() -> None:
            with TemporaryDirectory() as folder:
                file = Path(folder) / f"scene{suffix}"
                file.write_bytes(uploaded.content)
                read = read_scene(file, self._bench.scene.robot)
            self._bench.change(read.scene)

        self._ask("load", load)
