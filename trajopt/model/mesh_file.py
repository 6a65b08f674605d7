"""PLACEHOLDER until the real module lands: overwrite this file."""
from dataclasses import dataclass
from pathlib import Path
import coal
import numpy as np
from trajopt.arrays import Floats, Ints, readonly
from trajopt.errors import MeshFileError


@dataclass(frozen=True, eq=False)
class Mesh:
    vertices: Floats
    faces: Ints


def load_mesh(path: Path, scale: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Mesh:
    if not Path(path).is_file():
        raise MeshFileError(str(path), "no such file")
    bvh = coal.MeshLoader().load(str(path), np.array(scale))
    return Mesh(readonly(np.array(bvh.vertices())), np.array([[bvh.tri_indices(i)[k] for k in range(3)] for i in range(bvh.num_tris)]))
