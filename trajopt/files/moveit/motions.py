"""Motions of a scene's objects, in a file next to the scene: a list with one entry for each changing object.

    - object: box
      times: [0.0, 1.5]                                # increasing [s]
      positions: [[0.5, 1.0, 0.2], [0.5, -1.0, 0.2]]   # of its frame in the world [m]
      orientations: [[0, 0, 0, 1], [0, 0, 0.7, 0.7]]   # (x, y, z, w); as in the scene if omitted
      error: {radius: 0.01, velocity: 0.02, acceleration: 0.0}
      until: 4.0
      appears: 0.0
      expires: 3.0
    - object: lid
      carried_by: box                                  # keeps its pose on the box and moves with it

Between its times an object moves in a straight line and rotates at a constant rate; before the first and
after the last time it is at rest.
"""

from pathlib import Path

from trajopt.scene.scene import Scene
from trajopt.scene.track import Prediction, Track
from trajopt.values.documents.document import Node, read_list
from trajopt.values.errors import ModelError, ObjectNotFound
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement, placement

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

    Args:
        path: The file, YAML or JSON, in the format of this module.
        scene: The scene with the objects.

    Returns:
        The scene with moving objects.

    Raises:
        FileFormatError: If the file is incomplete or malformed, names an unknown object or names one twice,
            or the times do not increase.
    """
    return apply_motions(read_list(path), scene)


def apply_motions(document: Node, scene: Scene) -> Scene:
    """Return the scene with the object motions of a list; see `read_motions`.

    Raises:
        FileFormatError: If the list is incomplete or malformed.
    """
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
    """Return the scene with an object attached to another at their poses at time 0."""
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
                raise entry[name].error("says nothing without times and positions")
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
