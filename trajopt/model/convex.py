"""PLACEHOLDER until the real module lands: overwrite this file."""
from dataclasses import dataclass
from enum import Enum
from scipy.spatial import ConvexHull
from trajopt.arrays import Floats
from trajopt.model.mesh_file import Mesh


class CoverMethod(Enum):
    HULL = "hull"
    DECOMPOSITION = "decomposition"


@dataclass(frozen=True, eq=False)
class ConvexCover:
    pieces: tuple[Floats, ...]
    method: CoverMethod
    excess: float


def convex_pieces(mesh: Mesh, *, hull_excess: float = 0.05) -> ConvexCover:
    return ConvexCover((mesh.vertices[ConvexHull(mesh.vertices).vertices],), CoverMethod.HULL, 0.0)
