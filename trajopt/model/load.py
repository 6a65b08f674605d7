"""Robots by name: those that installed packages bring, and any from its URDF file."""

from collections.abc import Sequence
from pathlib import Path

from trajopt.arrays import path
from trajopt.errors import ModelError, RobotNotFound
from trajopt.model.meshes.mesh_cover import MeshPolicy
from trajopt.model.robot import Robot


def load(
    robot: str | Path,
    *,
    srdf: Path | str | None = None,
    limits: Path | str | None = None,
    package_dirs: Sequence[Path | str] = (),
    meshes: MeshPolicy | None = None,
) -> Robot:
    """Load an installed robot by name ("panda"), or any robot from its URDF file.

    Names come from the entry-point group `trajopt.robots`, so any package can add some.

    Args:
        robot: A name, or the path of a URDF file.
        srdf: With a path: MoveIt's semantic description.
        limits: With a path: MoveIt's `joint_limits.yaml`.
        package_dirs: With a path: folders to look in for `package://` meshes.
        meshes: With a path: how collision meshes become convex.

    Raises:
        RobotNotFound: If it is neither an installed name nor a file.
        ModelError: If options for a path come with a name.
    """
    from importlib.metadata import entry_points

    installed = {entry.name: entry for entry in entry_points(group="trajopt.robots")}
    if str(robot) in installed:
        if srdf or limits or package_dirs or meshes:
            raise ModelError(f"robot {robot!r} is installed by name and brings its own files")
        return installed[str(robot)].load()()
    if not path("robot", robot).is_file():
        raise RobotNotFound("installed robot or URDF file", str(robot), installed)
    return Robot.from_urdf(robot, srdf=srdf, limits=limits, package_dirs=package_dirs, meshes=meshes)
