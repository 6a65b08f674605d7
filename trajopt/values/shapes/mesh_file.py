"""Reading of mesh files.

Coal's own loader (assimp) reads the files, so a mesh has exactly the coordinates that Pinocchio
reads from the same file: DAE, STL (binary, ASCII), OBJ and the other formats of assimp. It runs in a child
process, since some files crash it. In a DAE file the transforms of nodes count, `unit` and `up_axis` do not:
a file in other units is scaled in the URDF.
"""

import io
import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trajopt.values.array_cache import Arrays, cached_arrays
from trajopt.values.arrays import Floats
from trajopt.values.arrays import path as path_of
from trajopt.values.documents.bounded_process import ProcessRefused, answer_of
from trajopt.values.documents.files import is_file
from trajopt.values.errors import MeshFileError, ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.shapes.mesh import Mesh

ALONE = frozenset((".stl", ".dae", ".obj", ".ply", ".off"))
"""Suffixes of self-contained files; others, such as .gltf, may refer to more files."""
_CHILD, _KEPT = Path(__file__).with_name("mesh_child.py"), ("vertices", "faces")


@checked
def load_mesh(path: Path | str, scale: float | tuple[float, float, float] = 1.0) -> Mesh:
    """Read a mesh file.

    Args:
        path: A file whose suffix assimp knows: .dae, .stl, .obj, ...
        scale: One factor, such as 0.001 for a file in millimetres, or factors along x, y, z, as in a URDF. If
            they mirror, faces are turned to point outward.

    Returns:
        All nodes of the file in one frame; in metres if file and scale are consistent.

    Raises:
        MeshFileError: If the file is missing or unreadable, has no triangle, or takes more than 30 s of CPU
            time or 4 GB to read.
    """
    path = path_of("path", path)
    factors = np.array(np.broadcast_to(np.asarray(scale, dtype=np.float64), 3))
    if not is_file(path):
        raise MeshFileError(str(path), "no such file")
    vertices, faces = _triangles(path, factors)
    if np.prod(np.sign(factors)) < 0:
        faces = faces[:, ::-1]
    if not np.isfinite(vertices).all():
        raise MeshFileError(str(path), "it has vertices that are not finite")
    try:
        mesh = Mesh(vertices, faces)
    except ShapeError as error:
        raise MeshFileError(str(path), str(error)) from error
    if not len(mesh.faces):
        raise MeshFileError(str(path), "it holds no triangle")
    return mesh


def _triangles(path: Path, factors: Floats) -> tuple[Floats, NDArray[np.int32]]:
    """Return assimp's vertices and faces; cached for files that refer to no other."""

    def read() -> Arrays:
        request = json.dumps({"file": str(path.absolute()), "scale": factors.tolist()})
        try:
            answer = answer_of(_CHILD, request.encode())
        except ProcessRefused as error:
            raise MeshFileError(str(path), str(error)) from error
        with np.load(io.BytesIO(answer), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in _KEPT}

    if path.suffix.lower() in ALONE:
        key = (path.suffix.lower().encode(), factors.tobytes(), path.read_bytes())
        arrays = cached_arrays("mesh", key, _KEPT, read)
    else:
        arrays = read()
    return arrays["vertices"], arrays["faces"]
