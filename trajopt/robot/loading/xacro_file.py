"""xacro, the macros that most URDFs are written with: expanded by the package `xacrodoc`, without ROS."""

from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from trajopt.values.errors import FileFormatError, MissingExtra

SUFFIX = ".xacro"
"""Ending of the names of xacro files."""
_PACKAGE = "xacrodoc"


def expanded(path: Path, arguments: Mapping[str, str], package_dirs: Sequence[Path]) -> bytes:
    """Return the URDF that a xacro file makes.

    `$(find NAME)` is a package that holds the file, one in a package directory or beside the package that
    holds the file, or one that ROS knows.

    Args:
        path: The file.
        arguments: Values of its `<xacro:arg>` by name; others have their defaults.
        package_dirs: Folders of packages, or that hold packages.

    Raises:
        MissingExtra: If `xacrodoc` is not installed.
        FileFormatError: If it cannot be expanded.
    """
    if find_spec(_PACKAGE) is None:
        raise MissingExtra(_PACKAGE, "xacro")
    packages: Any = import_module(f"{_PACKAGE}.packages")
    xacro: Any = import_module("xacro")  # in which xacrodoc has put its own way to find packages
    beside = [str(folder) for folder in path.absolute().parents[1:3]]
    try:
        packages.reset()
        packages.look_in([*map(str, package_dirs), *beside])
        packages.walk_up_from(path)
        return str(xacro.process_file(str(path), mappings=dict(arguments)).toxml()).encode()
    except Exception as error:  # whatever the expressions in it raise, and their parser
        raise FileFormatError(str(path), f"cannot be expanded by xacro: {error}") from error
