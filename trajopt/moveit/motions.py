"""Motions of a scene's objects, in a file beside it: a list with one entry for each object that changes.

    - object: box
      times: [0.0, 1.5]                                # increasing [s]
      positions: [[0.5, 1.0, 0.2], [0.5, -1.0, 0.2]]   # of its frame in the world [m]
      orientations: [[0, 0, 0, 1], [0, 0, 0.7, 0.7]]   # (x, y, z, w); as in the scene where left out
      error: {radius: 0.01, velocity: 0.02, acceleration: 0.0}
      until: 4.0
      appears: 0.0
      expires: 3.0

Between its times an object goes straight and turns evenly; before the first and after the last it rests.
"""

from pathlib import Path

from trajopt.errors import ModelError, ObjectNotFound
from trajopt.errors.arguments import checked
from trajopt.io.document import Node, read_list
from trajopt.model.placement import Placement, placement
from trajopt.model.scene import Scene
from trajopt.model.track import Prediction, Track

FIELDS = ("object", "times", "positions", "orientations", "error", "until", "appears", "expires")
ERROR_FIELDS = ("radius", "velocity", "acceleration")


@checked
def read_motions(path: Path | str, scene: Scene) -> Scene:
    """Read the motions of a scene's objects, and when they appear and expire.

    Args:
        path: The file, YAML or JSON; the module says what it holds.
        scene: The scene with the objects.

    Returns:
        The scene in which they move.

    Raises:
        FileFormatError: If the file does not say what it must, names an object that is not there, or twice,
            or the times do not increase.
    """
    done: set[str] = set()
    for entry in read_list(path).elements():
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
    return scene


def _motion(entry: Node, here: Placement) -> Prediction | None:
    """Return the motion of an entry; None where it states none."""
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
