"""The panel of the objects: put up, chosen, moved, resized, grasped, removed; scenes kept in files."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from trajopt.files.moveit import read_scene, write_scene
from trajopt.scene.scene import Scene
from trajopt.values.placement import Placement, placement
from trajopt.viewer.live import objects
from trajopt.viewer.live.desk import Lever
from trajopt.viewer.live.workbench import Workbench

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

NONE: str = "none"
SIZES = 3
"""No shape has more sizes."""
FILE = "scene.yaml"
Change = Callable[[Callable[[], None]], None]


class ObjectsPanel:
    """Controls of the objects.

    Attributes:
        chosen: Name of the chosen object; empty for none.
    """

    def __init__(
        self,
        server: "ViserServer",
        bench: Workbench,
        ask: Callable[[str, Callable[[], None]], None],
        choose: Callable[[str], None],
    ) -> None:
        """Add the controls.

        Args:
            server: Serves the page.
            bench: The state of the page.
            ask: Requests a change of the state: its name, and the change.
            choose: Called when an object is chosen, or none.
        """
        self._server, self._bench, self._ask, self._choose = server, bench, ask, choose
        self.chosen = ""
        gui = server.gui
        self._add: GuiButtonGroupHandle = gui.add_button_group(
            "add", tuple(each.value for each in objects.Kind), hint="Put up an object beside the robot."
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
            self._put = Lever(server, "Put down here", "It stays where the hand has it.", self._press_put)
            self._remove = Lever(server, "Remove", "Take it away.", self._press_remove, colour="red")
        self._save = Lever(
            server, "Save the scene ...", "What is around the robot, as MoveIt's PlanningScene.",
            self._press_save, colour="gray",
        )  # fmt: skip
        self._load: GuiUploadButtonHandle = gui.add_upload_button(
            "Load a scene ...", hint="A MoveIt PlanningScene in YAML or JSON, in place of this.", color="gray"
        )
        self._load.on_upload(self._upload)
        self.show()

    def show(self) -> None:
        """Show the objects as they are."""
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
        """Choose an object, or none."""
        self.chosen = name
        self.show()
        self._choose(name)

    def move(self, where: Placement) -> None:
        """Have the chosen object placed in the world."""
        name = self.chosen
        if name:
            self._change("object", lambda scene: objects.moved(scene, name, where))

    def _show_chosen(self, scene: Scene) -> None:
        name, sizes = self.chosen, objects.sizes_of(scene, self.chosen)
        carried = objects.is_carried(scene, name)
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
                field = list(objects.sizes_of(scene, name))[place]
                return objects.resized(scene, name, {field: value})

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
        kind = objects.Kind(self._add.value)

        def add() -> None:
            scene, name = objects.added(self._bench.reduced, kind)
            self._bench.change(scene)
            self.chosen = name

        self._ask("add", add)

    def _press_grasp(self, _: object) -> None:
        name = self.chosen
        self._ask(
            "object",
            lambda: self._bench.change(objects.grasped(self._bench.reduced, name, self._bench.hand)),
        )

    def _press_put(self, _: object) -> None:
        name = self.chosen
        self._ask("object", lambda: self._bench.change(objects.put_down(self._bench.reduced, name)))

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
