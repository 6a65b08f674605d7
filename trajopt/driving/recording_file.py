"""Recordings as files: JSON with a format and a version.

    {
     "format": "trajopt recording",
     "version": 1,
     "robot": {"name": "panda", "joints": ["panda_joint1", ...], "source": {...}},
     "sightings": [{"since": 0.0, "stamp": 0.0, "scene": {"objects": {...}, "margin": 0.01, ...}}, ...],
     "group": "panda_arm", "times": {"array": [...], "type": "float64"}, "committed": [...], ...
    }

The fields are those of `trajopt.driving.Recording`, of its motions, events and scenes, and of the objects of
the scenes, with their names and units; `trajopt.values.documents.codec` describes the JSON of values. The
robot is not included: a reader has it, or loads it from its source, which is null or as `trajopt plan` writes
it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import cast

from trajopt.driving.events import Event, EventKind
from trajopt.driving.recording import RecordedMotion, Recording, Sighting
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.problem.kinds import model_kinds
from trajopt.problem.read_checks import check_fields, check_value
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Value
from trajopt.values.documents.codec import Kinds, Reader, Writer
from trajopt.values.documents.document import Node, read_document
from trajopt.values.documents.json_files import write_json
from trajopt.values.errors import TrajoptError, shown
from trajopt.values.errors.arguments import checked

FORMAT, VERSION = "trajopt recording", 1

PARTS = tuple(name for name in (item.name for item in fields(Recording)) if name != "sightings")
WORLD = tuple(name for name in (item.name for item in fields(Scene)) if name != "robot")


@cache
def recording_kinds() -> Kinds:
    """Return the classes of values in a file, by name; files before version 0.2 have two other names."""
    own = {kind.__name__: kind for kind in (RecordedMotion, Event, EventKind)}
    return {**model_kinds(), **own, "TimedMotion": RecordedMotion, "Kind": EventKind}


@dataclass(frozen=True, eq=False)
class RecordingFile(Value):
    """A recording on disk, which needs its robot to be read.

    Attributes:
        robot_name: The name of the robot.
        source: How to load it, as given to `write_recording`; None if nothing was given.
        document: Contents of the file.
    """

    robot_name: str
    source: Mapping[str, object] | None
    document: Node

    @staticmethod
    def is_one(path: Path | str) -> bool:
        """Return whether a file is a recording in JSON.

        Raises:
            FileFormatError: If it cannot be read.
        """
        return Path(path).suffix == ".json" and read_document(path).has("format")

    @staticmethod
    def open(path: Path | str) -> "RecordingFile":
        """Open a file.

        Raises:
            FileFormatError: If it is not a recording, or has another version.
        """
        document = read_document(path)
        if document["format"].text("") != FORMAT:
            raise document.error(f"is not a recording: its format is not {FORMAT!r}")
        document.only(("format", "version", "robot", "sightings", *PARTS))
        if document["version"].number() != VERSION:
            raise document["version"].error(f"is {document['version'].number():g}, must be {VERSION}")
        robot = document["robot"].only(("name", "joints", "source"))
        source = robot["source"].value
        if source is not None and not isinstance(source, dict):
            raise robot["source"].error("must be a mapping")
        return RecordingFile(robot["name"].text(), cast("dict[str, object] | None", source), document)

    def read(self, robot: Robot) -> Recording:
        """Read the recording.

        Args:
            robot: The recorded robot.

        Raises:
            FileFormatError: If the robot is another one, or the file does not have the format.
        """
        document = self.document
        joints = tuple(each.text() for each in document["robot"]["joints"].elements())
        if joints != robot.joint_names:
            raise document["robot"].error(
                f"is {shown(self.robot_name)}, whose joints differ from those of {shown(robot.name)}"
            )
        reader = Reader(recording_kinds(), check_fields, check_value)
        parts = {name: reader.value(document[name]) for name in PARTS}
        sightings = [_sighting(reader, each, robot) for each in document["sightings"].elements()]
        try:
            return Recording(**parts, sightings=sightings)
        except TrajoptError as error:
            raise document.error(str(error)) from error


@checked
def read_recording(path: Path | str, robot: Robot) -> Recording:
    """Read a recording from a file in the format of this module.

    Args:
        path: The file.
        robot: The recorded robot.

    Raises:
        FileFormatError: If the robot is another one, or the file does not have the format.
    """
    return RecordingFile.open(path).read(robot)


@checked
def write_recording(
    path: Path | str, recording: Recording, source: Mapping[str, object] | None = None
) -> None:
    """Write a recording in the format of this module.

    Args:
        path: The file, JSON.
        recording: The recording.
        source: Plain data by which a reader finds the robot; the commands write theirs.

    Raises:
        FileFormatError: If it cannot be written.
    """
    robot = recording.robot
    about = {"name": robot.name, "joints": list(robot.joint_names), "source": source}
    writer = Writer(recording_kinds())
    sightings = [
        {
            "since": writer.document(each.since, "since"),
            "stamp": each.world.stamp,
            "scene": {name: writer.document(getattr(each.world.scene, name), name) for name in WORLD},
        }
        for each in recording.sightings
    ]
    parts = {name: writer.document(getattr(recording, name), name) for name in PARTS}
    document = {"format": FORMAT, "version": VERSION, "robot": about, "sightings": sightings, **parts}
    write_json(path, document, indent=None)


def _sighting(reader: Reader, node: Node, robot: Robot) -> Sighting:
    node.only(("since", "stamp", "scene"))
    parts = {name: reader.value(node["scene"].only(WORLD)[name]) for name in WORLD}
    try:
        world = WorldSnapshot(Scene(robot=robot, **parts), node["stamp"].number())
        return Sighting(since=reader.value(node["since"]), world=world)
    except (TrajoptError, TypeError) as error:
        raise node.error(str(error)) from error
