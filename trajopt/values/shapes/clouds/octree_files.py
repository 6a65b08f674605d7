"""Octree files of OctoMap, read by its own library."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from trajopt.values.arrays import Ints
from trajopt.values.arrays import path as path_of
from trajopt.values.documents.files import is_file, read_bytes
from trajopt.values.errors import FileFormatError, MissingExtra

MOST_CELLS = 8_000_000
"""Cells that a large one may be cut into, all together: a wall of 50 m by 10 m, a metre thick, in 4 cm."""
_HEADER = 4096  # bytes at the beginning in which the header is


def read_octree(path: Path | str) -> tuple[Ints, float]:
    """Return the keys of the occupied cells of the smallest size, shape (n, 3), and that size [m].

    Raises:
        MissingExtra: If octomap-python is not installed.
        FileFormatError: If the file is missing or malformed, or has no occupied cell, or too many.
    """
    path = path_of("path", path)
    if path.suffix not in (".bt", ".ot"):
        raise FileFormatError(str(path), "is no octree: .bt and .ot files are read")
    if not is_file(path):
        raise FileFormatError(str(path), "no such file")
    tree = _tree(path, read_bytes(path))
    size, depth = float(tree.getResolution()), int(tree.getTreeDepth())
    found: list[Ints] = []
    count = 0
    for leaf in tree.begin_leafs():
        if not tree.isNodeOccupied(leaf):
            continue
        edge = 1 << (depth - int(leaf.getDepth()))
        count += edge**3
        if count > MOST_CELLS:
            raise FileFormatError(str(path), f"has more than {MOST_CELLS} occupied cells")
        lowest = np.rint(np.asarray(leaf.getCoordinate()) / size - edge / 2.0).astype(np.int64)
        within = np.arange(edge)
        found.append(lowest + np.stack(np.meshgrid(within, within, within), axis=-1).reshape(-1, 3))
    if not found:
        raise FileFormatError(str(path), "has no occupied cell")
    return np.concatenate(found), size


def _tree(path: Path, data: bytes) -> Any:
    """Return the library's tree; a file that holds fewer nodes than its header says is refused."""
    try:
        import octomap
    except ImportError as error:
        raise MissingExtra("octomap-python", "octomap") from error
    stated = re.search(rb"^size (\d+)\s*$", data[:_HEADER], re.MULTILINE)
    name = str(path).encode()
    try:
        if path.suffix == ".bt":
            tree: Any = octomap.OcTree(0.1)
            read = bool(tree.readBinary(name))
        else:
            tree, read = octomap.OcTree.read(name), True
    except (OSError, ValueError, RuntimeError) as error:
        raise FileFormatError(str(path), f"cannot be read as an octree: {error}") from error
    if not read or stated is None or int(stated[1]) != tree.size():
        raise FileFormatError(str(path), "cannot be read as an octree: it is damaged, or of another kind")
    return tree
