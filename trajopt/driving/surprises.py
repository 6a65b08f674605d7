"""Surprises: what happens in the world while a robot is driven, and nobody said so before.

A file, YAML or JSON, lists them:

    objects:
      - object: crate                                    # new, with a shape; or one of the scene, which moves
        at: 0.4                                          # [s]
        position: [0.4, 0.1, 0.2]                        # in the world [m]
        orientation: [0, 0, 0, 1]                        # (x, y, z, w); upright where left out
        shape: {type: box, dimensions: [0.1, 0.1, 0.1]}  # as in MoveIt's files
        leaves: 2.5                                      # is gone from then on; stays where left out
    sensors: {delay: 0.01, noise: 0.0002}                # [s], [rad | m]
    faults:
      - {kind: stuck, joint: panda_joint4, begin: 0.3, end: 9.0}
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf
from pathlib import Path

from trajopt.driving.faults import Fault, FaultKind
from trajopt.driving.simulated import EXACT, Sensors
from trajopt.files.moveit.shapes import read_primitive
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.values.arrays import Value
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement, placement
from trajopt.values.shapes.shapes import Shape

FIELDS = ("objects", "sensors", "faults")
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
OBJECT_FIELDS = ("object", "at", "position", "orientation", "shape", "leaves")


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Surprise(Value):
    """An object that appears, or moves at once.

    Attributes:
        name: Of a new object, which has a shape, or of one of the scene, which is moved.
        at: When [s].
        placement: Where it is from then on, in the world.
        shape: Of a new object; None where it is one of the scene.
        leaves: When it is gone [s].
    """

    name: str
    at: float
    placement: Placement
    shape: Shape | None = None
    leaves: float = inf


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Surprises(Value):
    """Everything that happens unannounced.

    Attributes:
        objects: What appears or moves.
        sensors: How late and how exactly the robot is measured; objects are seen as late.
        faults: What goes wrong with the robot.
    """

    objects: Sequence[Surprise] = ()
    sensors: Sensors = field(default_factory=lambda: EXACT)
    faults: Sequence[Fault] = ()

    @property
    def times(self) -> tuple[float, ...]:
        """When the world changes, in order [s]."""
        both = {time for each in self.objects for time in (each.at, each.leaves) if time < inf}
        return tuple(sorted(both))

    @checked
    def world(self, scene: Scene) -> Scene:
        """Return the world as it really is: by the clock, which shows 0 when the robot begins.

        Args:
            scene: What is known before.

        Raises:
            ModelError: If what moves is not in the scene, or what appears is there already.
        """
        for each in self.objects:
            if each.shape is not None:
                scene = scene.add(each.name, each.shape, each.placement, appears=each.at, expires=each.leaves)
                continue
            item = scene.object(each.name)
            moved = SceneObject(f"{each.name} moved", item.parts, each.placement, WORLD, item.touch_links)
            scene = scene.with_motion(each.name, expires=each.at)
            scene = replace(scene, objects={**scene.objects, moved.name: moved})
            scene = scene.with_motion(moved.name, appears=each.at, expires=each.leaves)
        return scene

    @checked
    def seen(self, scene: Scene, time: float) -> Scene:
        """Return the world as somebody sees it who looks at it at a time [s].

        Args:
            scene: What is known before.
            time: On the clock [s].
        """
        for each in self.objects:
            if each.leaves <= time:
                scene = scene if each.shape is not None else scene.remove(each.name)
            elif each.at <= time and each.shape is not None:
                scene = scene.add(each.name, each.shape, each.placement)
            elif each.at <= time:
                scene = scene.move(each.name, each.placement)
        return scene


NONE = Surprises()


@checked
def read_surprises(path: Path | str) -> Surprises:
    """Read surprises from a file; the module says what it holds.

    Raises:
        FileFormatError: If the file does not say what it must.
    """
    document = read_document(path).only(FIELDS)
    sensors = document["sensors"].only(("delay", "noise"))
    return Surprises(
        objects=[_surprise(entry.only(OBJECT_FIELDS)) for entry in document["objects"].elements()],
        sensors=Sensors(delay=sensors["delay"].number(0.0), noise=sensors["noise"].number(0.0)),
        faults=[_fault(entry) for entry in document["faults"].elements()],
    )


def _surprise(entry: Node) -> Surprise:
    shape, orientation = entry["shape"], entry["orientation"]
    turned = UPRIGHT if orientation.missing else orientation.numbers()
    try:
        where = placement(entry["position"].numbers(), quaternion=turned)
    except ShapeError as error:
        raise entry.error(str(error)) from error
    return Surprise(
        name=entry["object"].text(),
        at=entry["at"].number(),
        placement=where,
        shape=None if shape.missing else read_primitive(shape),
        leaves=entry["leaves"].number(inf, infinite=True),
    )


def _fault(entry: Node) -> Fault:
    fields = entry.only(("kind", "joint", "begin", "end", "size"))
    kinds = {kind.value: kind for kind in FaultKind}
    name = fields["kind"].text()
    if name not in kinds:
        raise fields["kind"].error(f"is {name!r}, must be one of {', '.join(kinds)}")
    try:
        return Fault(
            kind=kinds[name],
            begin=fields["begin"].number(),
            end=fields["end"].number(),
            joint=fields["joint"].text(""),
            size=fields["size"].number(0.0),
        )
    except ProblemError as error:
        raise entry.error(str(error)) from error
