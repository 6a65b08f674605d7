"""Folders of MoveIt configurations: which files describe the robot."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from trajopt.robot.loading.mesh_names import MeshNames
from trajopt.values.documents.yaml_files import read_yaml
from trajopt.values.errors import FileFormatError, MeshFileError, listed

ASSISTANT = ".setup_assistant"
"""File of MoveIt's setup assistant with the package and path of the URDF."""
_CONFIG = "moveit_setup_assistant_config"
_URDF_FOLDERS = ("", "urdf", "robots", "config")
_CONFIG_FOLDERS = ("config", "srdf", "")


@dataclass(frozen=True)
class ConfigFolder:
    """The files of a robot.

    Attributes:
        urdf: The URDF or xacro file.
        srdf: MoveIt's semantic description; None if there is none.
        limits: `joint_limits.yaml`; None if there is none.
    """

    urdf: Path
    srdf: Path | None
    limits: Path | None


def read_config_folder(folder: Path, package_dirs: Sequence[Path] = ()) -> ConfigFolder:
    """Find the files of a robot in the folder of its MoveIt configuration, or of its description.

    The URDF is the one named by `.setup_assistant`, which MoveIt's setup assistant writes, in its package;
    packages are found as for meshes. Without that file it is the only one in the folder or in its `urdf`,
    `robots` or `config`.

    Args:
        folder: The folder, such as `fanuc_moveit_config`.
        package_dirs: Folders of packages, or with packages in them.

    Raises:
        FileFormatError: If the URDF or SRDF is missing or ambiguous; the message lists the candidates.
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
    """Return the content of `.setup_assistant` in lower case: its versions write URDF and urdf."""
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
    """Return the only file with one of the suffixes in the first folder that has any, or None."""
    for name in inside:
        files = sorted(each for each in (folder / name).glob("*") if each.name.endswith(endings))
        if len(files) > 1:
            names = listed([each.relative_to(folder).as_posix() for each in files])
            raise FileFormatError(str(folder), f"has several files ({names}): give one by its path")
        if files:
            return files[0]
    return None
