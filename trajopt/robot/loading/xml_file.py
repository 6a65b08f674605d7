"""XML files of a robot's description, read with bounds; errors name the file."""

import json
import os
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from math import isfinite
from pathlib import Path
from xml.etree import ElementTree

from trajopt.values.documents.files import DEEPEST, read_bytes
from trajopt.values.errors import FileFormatError, MissingExtra, shown
from trajopt.values.processes import ProcessRefused, answer_of

_BLOCK = 65536  # bytes handed to the parser at once


class _Bounded(ElementTree.TreeBuilder):
    depth = 0

    def start(self, tag: str, attrs: dict[str, str]) -> ElementTree.Element:  # pyright: ignore
        self.depth += 1
        if self.depth > DEEPEST:
            raise ValueError(f"is nested more than {DEEPEST} levels deep")
        return super().start(tag, attrs)  # pyright: ignore

    def end(self, tag: str) -> ElementTree.Element:
        self.depth -= 1
        return super().end(tag)


def read_xml(path: Path, kind: str, *, root: str = "robot") -> ElementTree.Element:
    return parse_xml(read_bytes(path), path, kind, root=root)


def parse_xml(data: bytes, path: Path, kind: str, *, root: str = "robot") -> ElementTree.Element:
    """Return the root of the text of an XML file; as `read_xml`."""
    parser = ElementTree.XMLParser(target=_Bounded())
    try:
        for start in range(0, len(data), _BLOCK):
            parser.feed(data[start : start + _BLOCK])
        found: ElementTree.Element = parser.close()
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise FileFormatError(str(path), f"is not a readable {kind}: {error}") from error
    if found.tag != root:
        reason = f"is not a readable {kind}: its root is <{found.tag[:80]}>, not <{root}>"
        raise FileFormatError(str(path), reason)
    return found


def numbers(
    path: Path, element: ElementTree.Element, key: str, default: str, *, count: int | None = None
) -> list[float]:
    """Return the finite numbers of an attribute."""
    text = element.get(key, default)
    where = f"<{element.tag} {key}={shown(text)}>"
    try:
        found = [float(word) for word in text.split()]
    except ValueError as error:
        raise FileFormatError(str(path), f"{where} is not a list of numbers") from error
    if not all(isfinite(value) for value in found):
        raise FileFormatError(str(path), f"{where} holds a number that is not finite")
    if count is not None and len(found) != count:
        raise FileFormatError(str(path), f"{where} needs {count} numbers, has {len(found)}")
    return found


PACKAGE_FILE = "package.xml"
"""Manifest of a ROS package, with its name."""
SUFFIX = ".xacro"
_PACKAGE = "xacrodoc"
_CHILD = Path(__file__).with_name("xacro_child.py")
_ROS = ("AMENT_", "COLCON_", "ROS_")
"""Prefixes of ROS's environment variables, the only ones passed to the process."""


def expanded(path: Path, arguments: Mapping[str, str], package_dirs: Sequence[Path]) -> bytes:
    """Return the URDF of a xacro file.

    `$(find NAME)` is a package directory, or a folder in one, of this name without a manifest; the package of
    the file; a package in a package directory or next to the file's package; or one that ROS knows. A child
    process that can only read these folders expands the file.

    Args:
        package_dirs: Folders of packages, or with packages in them.
    """
    if find_spec(_PACKAGE) is None:
        raise MissingExtra(_PACKAGE, "xacro")
    linked = (path.absolute(), path.resolve())  # workspaces of ROS may hold links to the sources
    own = [file.parent for file in linked]
    beside = [str(folder) for file in linked for folder in file.parents[1:3]]
    environment = {name: value for name, value in os.environ.items() if name.startswith(_ROS)}
    known = [folder for value in environment.values() for folder in value.split(os.pathsep)]
    request = {
        "file": str(path.absolute()),
        "arguments": dict(arguments),
        "packages": [*map(str, package_dirs), *beside],
        "named": _folders(package_dirs),
        "folders": [os.path.realpath(folder) for folder in (*own, *package_dirs)],
        "searched": [os.path.realpath(folder) for folder in (*beside, *filter(os.path.isabs, known))],
    }
    try:
        return answer_of(_CHILD, json.dumps(request).encode(), environment=environment)
    except ProcessRefused as error:
        raise FileFormatError(str(path), f"cannot be expanded by xacro: {error}") from error


def _folders(package_dirs: Sequence[Path]) -> dict[str, str]:
    """Return the folders without a `package.xml`, which are found by their names, as those of meshes are."""
    folders = [folder for each in package_dirs for folder in (each, *each.glob("*")) if folder.is_dir()]
    return {folder.name: str(folder) for folder in folders if not (folder / PACKAGE_FILE).is_file()}
