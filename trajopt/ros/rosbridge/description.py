"""Robot description for clients: original URDF and SRDF, and the files of the meshes."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from trajopt.lab.srdf.groups import ProposedGroup
from trajopt.lab.srdf.proposal import srdf_text
from trajopt.robot.loading.mesh_names import MeshNames
from trajopt.robot.loading.xml_file import expanded
from trajopt.robot.robot import Robot
from trajopt.values.arrays import Value
from trajopt.values.errors import FileFormatError, MeshFileError, ModelError, shown

PACKAGE_NAME = re.compile(r"package://([^\"'<>\s]+)")
KINDS = (
    ".stl",
    ".dae",
    ".obj",
    ".ply",
    ".glb",
    ".gltf",
    ".mtl",
    ".png",
    ".jpg",
    ".jpeg",
    ".tif",
    ".tiff",
    ".bmp",
)
"""Suffixes of mesh and texture files; other files of a package are not served."""


@dataclass(frozen=True, eq=False)
class RobotDescription(Value):
    """A robot's files."""

    urdf: str
    srdf: str = ""
    packages: Mapping[str, Path] = field(default_factory=dict[str, Path])

    @staticmethod
    def read(urdf: Path, srdf: Path | None = None, package_dirs: Sequence[Path] = ()) -> "RobotDescription":
        try:
            text = expanded(urdf, {}, package_dirs).decode() if urdf.suffix == ".xacro" else urdf.read_text()
            semantic = "" if srdf is None else srdf.read_text()
        except (OSError, UnicodeDecodeError) as error:
            raise FileFormatError(str(urdf), f"cannot be read: {error}") from error
        return RobotDescription(text, semantic, _packages(text, MeshNames(urdf, tuple(package_dirs))))

    @staticmethod
    def of(robot: Robot, srdf: Path | None = None, package_dirs: Sequence[Path] = ()) -> "RobotDescription":
        """Read the files of a robot loaded from a URDF; generate the SRDF if it has none."""
        if robot.urdf_path.suffix not in (".urdf", ".xacro"):
            raise ModelError(f"robot {shown(robot.name)} has no URDF for clients of ROS")
        found = RobotDescription.read(robot.urdf_path, srdf, package_dirs)
        return found if srdf is not None else replace(found, srdf=_semantics(robot))

    def file(self, name: str) -> Path | None:
        """Return a mesh or texture file by its name after `package://`; None for missing or other files."""
        package, _, inner = name.partition("/")
        folder = self.packages.get(package)
        if folder is None or "\0" in inner or Path(inner).suffix.lower() not in KINDS:
            return None
        try:
            found = (folder / inner).resolve()
            return found if found.is_relative_to(folder) and found.is_file() else None
        except (OSError, RuntimeError):  # a name that no file can have, or links in a circle
            return None


def _semantics(robot: Robot) -> str:
    chains = {name: group.links[0] if group.tip else "" for name, group in robot.groups.items()}
    groups = [
        ProposedGroup(
            name=name,
            base=chains[name],
            tip=group.tip or "",
            links=group.links,
            joints=group.joints,
            driven=group.joints,
        )
        for name, group in robot.groups.items()
    ]
    return srdf_text(
        robot.name,
        groups,
        states=robot.states,
        end_effectors=list(robot.end_effectors.values()),
        disabled={(min(pair), max(pair)): "Never" for pair in robot.disabled_pairs},
    )


def _packages(text: str, names: MeshNames) -> dict[str, Path]:
    folders: dict[str, Path] = {}
    for relative in dict.fromkeys(PACKAGE_NAME.findall(text)):
        package, _, inner = relative.partition("/")
        if package in folders or not inner or ".." in Path(inner).parts:
            continue
        try:
            found = names.find(f"package://{relative}")
        except MeshFileError:
            continue  # the robot was loaded without it
        folder = found.parents[len(Path(inner).parts) - 1]
        if found.relative_to(folder) == Path(inner):
            folders[package] = folder.resolve()
    return folders
