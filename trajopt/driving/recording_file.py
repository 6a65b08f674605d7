"""Recordings as files: JSON with a format and a version.

    {
     "format": "trajopt recording",
     "version": 1,
     "robot": {"name": "panda", "joints": ["panda_joint1", ...], "source": {...}},
     "sightings": [{"since": 0.0, "stamp": 0.0, "scene": {"objects": {...}, "margin": 0.01, ...}}, ...],
     "group": "panda_arm", "times": {"array": [...], "type": "float64"}, "committed": [...], ...
    }

What is there are the fields of `trajopt.driving.Recording`, of its motions, events and scenes, and of the
scenes' objects, by their names and in their units; `trajopt.values.documents.values` says how values
become JSON. Only the robot
is not in it: whoever reads a recording has it, or loads it from its source, which is null, or what
`trajopt plan` writes.
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
from trajopt.values.documents.document import Node, read_document
from trajopt.values.documents.json_files import write_json
from trajopt.values.documents.read_values import Reader
from trajopt.values.documents.values import Kinds, Writer
from trajopt.values.errors import TrajoptError, shown
from trajopt.values.errors.arguments import checked

FORMAT, VERSION = "trajopt recording", 1

PARTS = tuple(name for name in (item.name for item in fields(Recording)) if name != "sightings")
WORLD = tuple(name for name in (item.name for item in fields(Scene)) if name != "robot")


@cache
def recording_kinds() -> Kinds:
    """Return the classes of what a file may hold, by name; files before 0.2 have two other names."""
    own = {kind.__name__: kind for kind in (RecordedMotion, Event, EventKind)}
    return {**model_kinds(), **own, "TimedMotion": RecordedMotion, "Kind": EventKind}


@dataclass(frozen=True, eq=False)
class RecordingFile(Value):
    """A recording on disk, which needs its robot to be read.

    Attributes:
        robot_name: The name of the robot.
        source: What loads it, as `write_recording` was told; None if it was told nothing.
        document: What is in the file.
    """

    robot_name: str
    source: Mapping[str, object] | None
    document: Node

    @staticmethod
    def is_one(path: Path | str) -> bool:
        """Say whether a file's JSON is that of a recording.

        Raises:
            FileFormatError: If it cannot be read.
        """
        return Path(path).suffix == ".json" and read_document(path).has("format")

    @staticmethod
    def open(path: Path | str) -> "RecordingFile":
        """Look at a file.

        Raises:
            FileFormatError: If it is no recording, or of another version.
        """
        document = read_document(path)
        if document["format"].text("") != FORMAT:
            raise document.error(f"is no recording: its format is not {FORMAT!r}")
        document.only(("format", "version", "robot", "sightings", *PARTS))
        if document["version"].number() != VERSION:
            raise document["version"].error(f"is {document['version'].number():g}; this reads {VERSION}")
        robot = document["robot"].only(("name", "joints", "source"))
        source = robot["source"].value
        if source is not None and not isinstance(source, dict):
            raise robot["source"].error("must be a mapping")
        return RecordingFile(robot["name"].text(), cast("dict[str, object] | None", source), document)

    def read(self, robot: Robot) -> Recording:
        """Read it.

        Args:
            robot: The robot that moved.

        Raises:
            FileFormatError: If it is another robot, or the file does not say what it must.
        """
        document = self.document
        joints = tuple(each.text() for each in document["robot"]["joints"].elements())
        if joints != robot.joint_names:
            raise document["robot"].error(
                f"is of {shown(self.robot_name)}, whose joints are not those of {shown(robot.name)}"
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
    """Read a recording from a file; the module says what it holds.

    Args:
        path: The file.
        robot: The robot that moved.

    Raises:
        FileFormatError: If the file does not say what it must, or it is another robot.
    """
    return RecordingFile.open(path).read(robot)


@checked
def write_recording(
    path: Path | str, recording: Recording, source: Mapping[str, object] | None = None
) -> None:
    """Write a recording; the module says how.

    Args:
        path: The file, JSON.
        recording: What happened.
        source: Plain data by which whoever reads it finds the robot; the commands write theirs.

    Raises:
        FileFormatError: If it cannot be written.
    """
    robot = recording.robot
    about = {"name": robot.name, "joints": list(robot.joint_names), "source": source}
    writer = Writer(recording_kinds())
    sightings = [
        {
            "since": writer.document(each.since, "since"),
            "stamp": each.seen.stamp,
            "scene": {name: writer.document(getattr(each.seen.scene, name), name) for name in WORLD},
        }
        for each in recording.sightings
    ]
    parts = {name: writer.document(getattr(recording, name), name) for name in PARTS}
    told = {"format": FORMAT, "version": VERSION, "robot": about, "sightings": sightings, **parts}
    write_json(path, told, indent=None)


def _sighting(reader: Reader, node: Node, robot: Robot) -> Sighting:
    node.only(("since", "stamp", "scene"))
    parts = {name: reader.value(node["scene"].only(WORLD)[name]) for name in WORLD}
    try:
        seen = WorldSnapshot(Scene(robot=robot, **parts), node["stamp"].number())
        return Sighting(since=reader.value(node["since"]), seen=seen)
    except (TrajoptError, TypeError) as error:
        raise node.error(str(error)) from error
