"""Whether a body is enclosed by an exact mesh, whose surface it need not touch.

Distances to a mesh are distances to its triangles, so deep inside they are positive. While they are, a
body stays on the side of the surface on which it is: whether it is inside need be asked but once.
"""

import numpy as np

from trajopt.arrays import Bools, Floats
from trajopt.model.meshes.closed_surface import closed_surface
from trajopt.model.meshes.mesh_file import Mesh


def inside(points: Floats, mesh: Mesh) -> Bools:
    """Say which points a mesh winds around, by the solid angle that its closed surface fills.

    Args:
        points: In the mesh's frame, shape (p, 3) [m].
        mesh: The mesh; small gaps in it do no harm, and its open sheets have no inside.

    Returns:
        Shape (p,).

    Source: van Oosterom and Strackee, IEEE Trans. Biomedical Engineering, 1983.
    """
    triangles = closed_surface(mesh).triangles
    within = ((points >= mesh.vertices.min(axis=0)) & (points <= mesh.vertices.max(axis=0))).all(axis=1)
    angle = np.zeros(len(points))
    for row in np.flatnonzero(within).tolist():
        a, b, c = np.moveaxis(triangles - points[row], 1, 0)
        la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        triple = np.einsum("ti,ti->t", a, np.cross(b, c))
        rest = (
            la * lb * lc
            + np.einsum("ti,ti->t", a, b) * lc
            + np.einsum("ti,ti->t", b, c) * la
            + np.einsum("ti,ti->t", c, a) * lb
        )
        angle[row] = 2.0 * np.arctan2(triple, rest).sum()
    return angle > 2.0 * np.pi
