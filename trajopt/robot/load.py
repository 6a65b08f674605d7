"""Loading robots by name or from their files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from os.path import isdir, isfile
from pathlib import Path
from pkgutil import iter_modules
from typing import Any, cast
from xml.etree import ElementTree

from trajopt.robot.bases import MovingBase
from trajopt.robot.bodies import MeshPolicy
from trajopt.robot.loading.mesh_names import MeshNames
from trajopt.robot.robot import Robot
from trajopt.values.arrays import one_of, path
from trajopt.values.errors import (
    FileFormatError,
    MeshFileError,
    MissingExtra,
    ModelError,
    RobotNotFound,
    listed,
    shown,
)
from trajopt.values.errors.arguments import checked

_PACKAGE = "robot_descriptions"
_SUFFIX = "_description"
_FROM_SDF = (
    "take the URDF that it was made of, or make MJCF of it: conda install -c conda-forge sdformat-mjcf; "
    "sdf2mjcf {sdf} {mjcf}"
)


@checked
def load(
    robot: str | Path,
    *,
    srdf: Path | str | None = None,
    limits: Path | str | None = None,
    package_dirs: Sequence[Path | str] = (),
    xacro: Mapping[str, str] | None = None,
    meshes: MeshPolicy | None = None,
    base: MovingBase | None = None,
    torque_scaling: float = 1.0,
    limit_jerk: bool = False,
) -> Robot:
    """Load an installed robot by name ("panda"), or any robot from its URDF, xacro or MJCF file.

    Packages add names by the entry-point group `trajopt.robots`. Other names that end in "_description" are
    downloaded by `robot_descriptions`.

    Args:
        robot: A name, or the path of a URDF, xacro or MJCF file, or of the folder of a MoveIt configuration
            with URDF, SRDF and joint limits.
        srdf: For a path or a description: MoveIt's semantic description.
        package_dirs: For a path or a description: folders with the packages of `package://` meshes.
        xacro: For a xacro file: its arguments by name.
        meshes: For a path or a description: how collision meshes become convex.
        base: For a path or a description: a moving base, made by `trajopt.bases`; a fixed base if None.
        torque_scaling: Factor on the torque limits, see `Robot.with_torque_scaling`; inf turns them off.
        limit_jerk: Whether joints without a jerk limit get one, see `Robot.with_jerk_limits`.

    Raises:
        RobotNotFound: If it is neither an installed name nor a file.
        FileFormatError: If it is a folder without exactly one URDF, or a file cannot be read.
        MissingExtra: If it is a description or a xacro file, and its reader is not installed.
        ModelError: If options for a path are given with a name, or a description has no URDF.
    """
    from importlib.metadata import entry_points

    installed = {entry.name: entry for entry in entry_points(group="trajopt.robots")}
    if str(robot) in installed:
        if srdf or limits or package_dirs or xacro or meshes or base:
            raise ModelError(f"robot {shown(robot)} is installed by name and brings its own files")
        return _limited(installed[str(robot)].load()(), torque_scaling, limit_jerk)
    file = path("robot", robot)
    if str(robot).isidentifier() and str(robot).endswith(_SUFFIX) and not (isfile(file) or isdir(file)):
        urdf, folders = _description(str(robot), installed)
        dirs = (*package_dirs, *folders)
        described = Robot.from_urdf(
            urdf, srdf=srdf, limits=limits, package_dirs=dirs, meshes=meshes, base=base
        )
        return _limited(described, torque_scaling, limit_jerk)
    if isdir(file):
        found = read_config_folder(file, [Path(folder) for folder in package_dirs])
        dirs = (*package_dirs, file.parent)
        configured = Robot.from_urdf(
            found.urdf,
            srdf=srdf or found.srdf,
            limits=limits or found.limits,
            package_dirs=dirs,
            xacro=xacro,
            meshes=meshes,
            base=base,
        )
        return _limited(configured, torque_scaling, limit_jerk)
    if not isfile(file):  # never raises, as `Path.is_file` does on what cannot be a path
        raise RobotNotFound("installed robot or URDF file", str(robot), installed)
    if _root(file) == "mujoco":
        if package_dirs or xacro:
            raise ModelError(f"{shown(robot)} is MJCF: it finds its meshes itself, and holds no xacro")
        mjcf = Robot.from_mjcf(file, srdf=srdf, limits=limits, meshes=meshes, base=base)
        return _limited(mjcf, torque_scaling, limit_jerk)
    loaded = Robot.from_urdf(
        robot, srdf=srdf, limits=limits, package_dirs=package_dirs, xacro=xacro, meshes=meshes, base=base
    )
    return _limited(loaded, torque_scaling, limit_jerk)


def _root(file: Path) -> str:
    try:
        with file.open("rb") as opened:
            tag = str(next(ElementTree.iterparse(opened, events=("start",)))[1].tag)
    except (ElementTree.ParseError, LookupError, OSError, StopIteration, ValueError):
        return ""
    if tag == "sdf":
        way = _FROM_SDF.format(sdf=file.name, mjcf=file.with_suffix(".xml").name)
        raise FileFormatError(str(file), f"is SDF, which is not read; {way}")
    return tag


def _limited(robot: Robot, scaling: float, limit_jerk: bool) -> Robot:
    scaled = robot if scaling == 1.0 else robot.with_torque_scaling(scaling)
    return scaled.with_jerk_limits() if one_of("limit_jerk", limit_jerk, bool) else scaled


def _description(name: str, installed: Iterable[str]) -> tuple[Path, tuple[Path, ...]]:
    package = find_spec(_PACKAGE)
    if package is None:
        raise MissingExtra(_PACKAGE, "descriptions")
    modules = {module.name for module in iter_modules(package.submodule_search_locations)}
    known = {module for module in modules if module.endswith(_SUFFIX)}
    if name not in known:
        raise RobotNotFound("installed robot or URDF file", name, {*known, *installed})
    module = import_module(f"{_PACKAGE}.{name}")
    urdf: object = getattr(module, "URDF_PATH", None)
    if urdf is None:
        raise ModelError(f"{shown(name)} of {_PACKAGE} has no URDF; only robots with one can be loaded")
    folder = Path(str(getattr(module, "PACKAGE_PATH", Path(str(urdf)).parent)))
    return Path(str(urdf)), (folder, folder.parent)


ASSISTANT = ".setup_assistant"
"""File of MoveIt's setup assistant with the package and path of the URDF."""
_CONFIG = "moveit_setup_assistant_config"
_URDF_FOLDERS = ("", "urdf", "robots", "config")
_CONFIG_FOLDERS = ("config", "srdf", "")


@dataclass(frozen=True)
class ConfigFolder:
    """The files of a robot."""

    urdf: Path
    srdf: Path | None
    limits: Path | None


def read_config_folder(folder: Path, package_dirs: Sequence[Path] = ()) -> ConfigFolder:
    """Find the files of a robot in the folder of its MoveIt configuration, or of its description.

    The URDF is the one named by `.setup_assistant`, in its package; without that file it is the only one in
    the folder or in its `urdf`, `robots` or `config`.
    """
    noted = folder / ASSISTANT
    stated = _stated(noted) if noted.is_file() else {}
    urdf = _named_urdf(noted, stated, package_dirs) if "urdf" in stated else _only_urdf(folder)
    inner = stated.get("srdf", {}).get("relative_path", "")
    srdf = (
        folder / inner if inner and (folder / inner).is_file() else _only(folder, _CONFIG_FOLDERS, (".srdf",))
    )
    limits = folder / "config" / "joint_limits.yaml"
    return ConfigFolder(urdf, srdf, limits if limits.is_file() else None)


def _stated(noted: Path) -> dict[str, dict[str, Any]]:
    from trajopt.values.documents.yaml_files import read_yaml  # slow to import

    content = next(iter(read_yaml(noted)), None)
    inner = cast("dict[str, Any]", content).get(_CONFIG) if isinstance(content, dict) else None
    if not isinstance(inner, dict):
        raise FileFormatError(str(noted), f"has no {_CONFIG}")
    parts = cast("dict[Any, Any]", inner)
    return {str(key).lower(): part for key, part in parts.items() if isinstance(part, dict)}


def _named_urdf(noted: Path, stated: dict[str, dict[str, Any]], package_dirs: Sequence[Path]) -> Path:
    part = stated["urdf"]
    name = f"package://{part.get('package', '')}/{part.get('relative_path', '')}"
    try:
        return MeshNames(noted, tuple(package_dirs)).find(name)
    except MeshFileError as error:
        raise FileFormatError(str(noted), f"names the URDF {error}") from error


def _only_urdf(folder: Path) -> Path:
    found = _only(folder, _URDF_FOLDERS, (".urdf", ".urdf.xacro"))
    if found is None:
        raise FileFormatError(str(folder), f"is a folder without a URDF or {ASSISTANT}: give the URDF file")
    return found


def _only(folder: Path, inside: Sequence[str], endings: tuple[str, ...]) -> Path | None:
    for name in inside:
        files = sorted(each for each in (folder / name).glob("*") if each.name.endswith(endings))
        if len(files) > 1:
            names = listed([each.relative_to(folder).as_posix() for each in files])
            raise FileFormatError(str(folder), f"has several files ({names}): give one by its path")
        if files:
            return files[0]
    return None
