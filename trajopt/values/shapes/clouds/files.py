"""Files of points: numpy's, PLY and PCD."""

import io
from collections.abc import Callable, Mapping
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trajopt.values.arrays import Floats
from trajopt.values.arrays import path as path_of
from trajopt.values.documents.files import is_file, read_bytes
from trajopt.values.errors import FileFormatError
from trajopt.values.shapes.clouds.pcd import pcd_points
from trajopt.values.shapes.clouds.ply import ply_points

NAMED = "points"
"""Under what name an .npz file holds its points where it holds several arrays."""


def read_points(path: Path | str) -> Floats:
    """Return the points of a file that are finite, shape (n, 3) [m].

    Raises:
        FileFormatError: If the file is missing, malformed or of another kind, or holds no finite point.
    """
    path = path_of("path", path)
    read = _READERS.get(path.suffix.lower())
    if read is None:
        raise FileFormatError(str(path), f"is no cloud: {', '.join(_READERS)} files are read")
    if not is_file(path):
        raise FileFormatError(str(path), "no such file")
    try:
        points = read(read_bytes(path))
    except (
        ValueError,
        TypeError,
        SyntaxError,
        TokenError,
        RecursionError,
        KeyError,
        IndexError,
        OverflowError,
        EOFError,
        OSError,
        MemoryError,
    ) as error:
        raise FileFormatError(str(path), f"cannot be read as a cloud: {error}") from error
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        raise FileFormatError(str(path), "holds no point of which all coordinates are finite")
    return points


def _npy(data: bytes) -> Floats:
    return _columns(np.load(io.BytesIO(data), allow_pickle=False))


def _npz(data: bytes) -> Floats:
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        names = list(arrays.files)
        if NAMED not in names and len(names) != 1:
            raise ValueError(f"no array is named {NAMED!r}, and there are {len(names)}")
        return _columns(arrays[NAMED if NAMED in names else names[0]])


def _columns(array: NDArray[Any]) -> Floats:
    """Return the first three columns of an array; of a picture, (h, w, 3), its pixels in a row."""
    if array.ndim == 3:
        array = array.reshape(-1, array.shape[2])
    if array.ndim != 2 or array.shape[1] < 3 or array.dtype.kind not in "fiu":
        raise ValueError(f"needs numbers of shape (any, 3), has {array.dtype} of shape {array.shape}")
    return array[:, :3].astype(np.float64)


_READERS: Mapping[str, Callable[[bytes], Floats]] = {
    ".ply": ply_points,
    ".pcd": pcd_points,
    ".npy": _npy,
    ".npz": _npz,
}
