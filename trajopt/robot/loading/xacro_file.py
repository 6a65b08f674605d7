"""xacro, the macros that most URDFs are written with: expanded by the package `xacrodoc`, without ROS."""

import json
import os
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from trajopt.values.documents.bounded_process import ProcessRefused, answer_of
from trajopt.values.errors import FileFormatError, MissingExtra

SUFFIX = ".xacro"
"""Ending of the names of xacro files."""
_PACKAGE = "xacrodoc"
_CHILD = Path(__file__).with_name("xacro_child.py")
_ROS = ("AMENT_", "COLCON_", "ROS_")
"""What the names of ROS's environment variables begin with; of others the process is told none."""


def expanded(path: Path, arguments: Mapping[str, str], package_dirs: Sequence[Path]) -> bytes:
    """Return the URDF that a xacro file makes.

    `$(find NAME)` is a package that holds the file, one in a package directory or beside the package that
    holds the file, or one that ROS knows. Expressions are Python, so the file is expanded in a process of its
    own, which reads the file's folder, its packages and the package directories, and does nothing else.

    Args:
        path: The file.
        arguments: Values of its `<xacro:arg>` by name; others have their defaults.
        package_dirs: Folders of packages, or that hold packages.

    Raises:
        MissingExtra: If `xacrodoc` is not installed.
        FileFormatError: If it cannot be expanded, or takes more than 30 s of CPU time or 4 GB.
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
        "folders": [os.path.realpath(folder) for folder in (*own, *package_dirs)],
        "searched": [os.path.realpath(folder) for folder in (*beside, *filter(os.path.isabs, known))],
    }
    try:
        return answer_of(_CHILD, json.dumps(request).encode(), environment=environment)
    except ProcessRefused as error:
        raise FileFormatError(str(path), f"cannot be expanded by xacro: {error}") from error
