"""Poses read from a file, CSV or YAML: what a curve passes through."""

import csv
from pathlib import Path

from numpy.typing import ArrayLike

from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import FileFormatError, ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angles
from trajopt.values.placement import Placement, placement

POINT = ("x", "y", "z")
QUATERNION = ("qx", "qy", "qz", "qw")
RPY = ("roll", "pitch", "yaw")


@checked
def read_poses(
    path: Path | str, *, rpy: ArrayLike = (0.0, 0.0, 0.0), degrees: bool = False
) -> tuple[Placement, ...]:
    """Read poses, in order, from a file.

    CSV has a header with the columns x, y, z [m], and for orientations qx, qy, qz, qw, or roll, pitch, yaw
    [rad], or neither. YAML has a list `poses` of mappings; each has a `position` of three numbers and
    may have a `quaternion` (x, y, z, w) or `rpy`.

    Args:
        path: The file; what does not end in ".csv" is read as YAML.
        rpy: Orientation of poses that have none in the file: roll, pitch, yaw [rad].
        degrees: Whether roll, pitch and yaw are in degrees, here and in the file.

    Raises:
        FileFormatError: If the file is missing or does not say what it must.
    """
    turned = stated_angles("rpy", rpy, (3,), degrees=degrees)
    fixed = placement(rpy=turned).rotation
    if str(path).lower().endswith(".csv"):
        poses = _read_csv(Path(path), fixed, degrees=degrees)
    else:
        listed = read_document(path).only(("poses",))["poses"]
        poses = [_pose(node, fixed, degrees=degrees) for node in listed.elements()]
    if len(poses) < 2:
        raise FileFormatError(str(path), f"has {len(poses)} poses; a curve needs at least two")
    return tuple(poses)


def _read_csv(path: Path, fixed: Floats, *, degrees: bool) -> list[Placement]:
    try:
        with path.open(newline="") as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            names, rows = tuple(reader.fieldnames or ()), list(reader)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FileFormatError(str(path), str(error)) from error
    turned = next((columns for columns in (QUATERNION, RPY) if columns[0] in names), ())
    if set(names) != {*POINT, *turned}:
        raise FileFormatError(
            str(path),
            f"has the columns {', '.join(names) or 'none'}; needs x, y, z, and for orientations "
            f"{', '.join(QUATERNION)} or {', '.join(RPY)}",
        )
    poses: list[Placement] = []
    for line, row in enumerate(rows, start=2):
        try:
            point = [float(row[name]) for name in POINT]
            numbers = [float(row[name]) for name in turned]
            poses.append(_placed(point, turned, numbers, fixed, degrees=degrees))
        except (TypeError, ValueError) as error:
            raise FileFormatError(str(path), f"line {line}: {error}") from error
    return poses


def _pose(node: Node, fixed: Floats, *, degrees: bool) -> Placement:
    node.only(("position", "quaternion", "rpy"))
    turned = QUATERNION if node.has("quaternion") else RPY if node.has("rpy") else ()
    numbers = node["quaternion" if node.has("quaternion") else "rpy"].numbers()
    try:
        return _placed(list(node["position"].numbers()), turned, list(numbers), fixed, degrees=degrees)
    except ShapeError as error:
        raise node.error(str(error)) from error


def _placed(
    point: list[float],
    turned: tuple[str, ...],
    numbers: list[float],
    fixed: Floats,
    *,
    degrees: bool,
) -> Placement:
    if turned == QUATERNION:
        return placement(point, quaternion=numbers)
    if turned == RPY:
        return placement(point, rpy=numbers, degrees=degrees)
    return placement(point, rotation=fixed)
