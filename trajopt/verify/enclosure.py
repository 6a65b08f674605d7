"""Whether a body is enclosed by an exact mesh, whose surface it need not touch.

Distances to a mesh are distances to its triangles, so deep inside they are positive.
"""

import numpy as np

from trajopt.arrays import Bools, Floats, Ints
from trajopt.model.shapes import Convex, Mesh, Shape


def representatives(shape: Shape) -> Floats:
    """Return one point of each connected part of a shape's surface or inside, (p, 3) [m]."""
    match shape:
        case Mesh():
            from scipy.sparse import coo_array
            from scipy.sparse.csgraph import connected_components

            corners, merged = np.unique(shape.vertices, axis=0, return_inverse=True)
            faces = merged.reshape(-1)[shape.faces]
            links = coo_array(
                (
                    np.ones(2 * len(faces)),
                    (np.tile(faces[:, 0], 2), faces[:, 1:].T.reshape(-1)),
                ),
                shape=(len(corners), len(corners)),
            )
            part: Ints = np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)
            used = np.unique(faces)
            first = np.unique(part[used], return_index=True)[1]
            return corners[used[first]]
        case Convex():
            return shape.vertices.mean(axis=0)[None]
        case _:
            return np.zeros((1, 3))


def inside(points: Floats, mesh: Mesh) -> Bools:
    """Say which points a mesh winds around, by the solid angle that its triangles fill.

    Args:
        points: In the mesh's frame, shape (p, 3) [m].
        mesh: The mesh; small gaps in it do no harm.

    Returns:
        Shape (p,).

    Source: van Oosterom and Strackee, IEEE Trans. Biomedical Engineering, 1983.
    """
    angle = np.zeros(len(points))
    for row, point in enumerate(points):
        a, b, c = np.moveaxis(mesh.vertices[mesh.faces] - point, 1, 0)
        la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        triple = np.einsum("ti,ti->t", a, np.cross(b, c))
        rest = (
            la * lb * lc
            + np.einsum("ti,ti->t", a, b) * lc
            + np.einsum("ti,ti->t", b, c) * la
            + np.einsum("ti,ti->t", c, a) * lb
        )
        angle[row] = 2.0 * np.arctan2(triple, rest).sum()
    return np.abs(angle) > 2.0 * np.pi
