"""Loading robots by name or from their files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from os.path import isdir, isfile
from pathlib import Path
from pkgutil import iter_modules
from xml.etree import ElementTree

from trajopt.robot.bases import MovingBase
from trajopt.robot.mesh_cover import MeshPolicy
from trajopt.robot.robot import Robot
from trajopt.values.arrays import one_of, path
from trajopt.values.errors import FileFormatError, MissingExtra, ModelError, RobotNotFound, shown
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

    Names come from the entry-point group `trajopt.robots`, so any package can add some. Other names that
    end in "_description" belong to the package `robot_descriptions`, which downloads the files.

    Args:
        robot: A name, or the path of a URDF, xacro or MJCF file, or of the folder of a MoveIt configuration
            with URDF, SRDF and joint limits.
        srdf: For a path or a description: MoveIt's semantic description.
        limits: For a path or a description: MoveIt's `joint_limits.yaml`.
        package_dirs: For a path or a description: folders with the packages of `package://` meshes.
        xacro: For a xacro file: its arguments by name. The file is expanded in a child process that reads
            only its own folder, its packages and `package_dirs`.
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
        from trajopt.robot.loading.config_folder import read_config_folder  # which reads YAML

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
    """Return the root tag of an XML file; empty if it cannot be read.

    Raises:
        FileFormatError: If it is `<sdf>`, which is not supported.
    """
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
    """Return the URDF of a robot of `robot_descriptions`, and the folders of its meshes."""
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
