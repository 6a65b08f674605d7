"""Shapes as plain numbers, for Coal, for a URDF and for a scene; and what is inside a closed surface."""

from dataclasses import dataclass
from functools import cached_property

import coal
import numpy as np

import trajopt as to
from trajopt.values.arrays import Floats
from trajopt.values.shapes.mesh import Mesh

PARTS = 64
"""Points at most that stand for the surface of a body where it is looked for inside a mesh."""


@dataclass(frozen=True, eq=False)
class Body:
    """A box, sphere, cylinder or mesh in its own frame.

    Attributes:
        kind: "box", "sphere", "cylinder" or "mesh".
        sizes: Edges of the box, the radius, or radius and length [m].
        vertices: Of a mesh, shape (n, 3) [m].
        faces: Of a mesh, shape (m, 3).
        closed: Whether a mesh bounds a solid.
    """

    kind: str
    sizes: tuple[float, ...] = ()
    vertices: Floats | None = None
    faces: Floats | None = None
    closed: bool = False

    @cached_property
    def geometry(self) -> coal.CollisionGeometry:
        """The same for Coal; a mesh as its triangles."""
        if self.kind == "mesh":
            model = coal.BVHModelOBBRSS()
            model.beginModel(len(self.faces), len(self.vertices))
            model.addVertices(np.asarray(self.vertices))
            model.addTriangles(np.asarray(self.faces, dtype=np.int64))
            model.endModel()
            return model
        return {"box": coal.Box, "sphere": coal.Sphere, "cylinder": coal.Cylinder}[self.kind](*self.sizes)

    @cached_property
    def asked(self) -> to.Box | to.Sphere | to.Cylinder | Mesh:
        """The same for a scene."""
        if self.kind == "mesh":
            return Mesh(self.vertices, self.faces)
        return {"box": to.Box, "sphere": to.Sphere, "cylinder": to.Cylinder}[self.kind](*self.sizes)

    @cached_property
    def urdf(self) -> str:
        """The same as an element of a URDF."""
        if self.kind == "box":
            return '<box size="{} {} {}"/>'.format(*self.sizes)
        if self.kind == "sphere":
            return f'<sphere radius="{self.sizes[0]}"/>'
        return '<cylinder radius="{}" length="{}"/>'.format(*self.sizes)

    @cached_property
    def radius(self) -> float:
        """How far its farthest point is from its origin [m]."""
        if self.kind == "mesh":
            return float(np.linalg.norm(self.vertices, axis=1).max())
        if self.kind == "box":
            return float(np.linalg.norm(self.sizes)) / 2.0
        return self.sizes[0] if self.kind == "sphere" else float(np.hypot(self.sizes[0], self.sizes[1] / 2.0))

    @cached_property
    def points(self) -> Floats:
        """Some of its points, shape (p, 3); of a solid one inside is the first."""
        if self.kind == "mesh":
            return np.asarray(self.vertices)[:: max(1, len(self.vertices) // PARTS)]
        origin = np.zeros((1, 3))
        if self.kind == "box":
            signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
            return np.concatenate((origin, signs * np.array(self.sizes) / 2.0))
        if self.kind == "sphere":
            return origin
        return np.array([(0, 0, 0), (0, 0, self.sizes[1] / 2), (0, 0, -self.sizes[1] / 2)])

    def inside(self, points: Floats) -> Floats:
        """Say which points are inside a closed mesh: the solid angle of its triangles is a whole turn.

        Args:
            points: In the mesh's frame, shape (p, 3) [m].

        Returns:
            Shape (p,), bool.
        """
        corners = self.vertices[np.asarray(self.faces, dtype=np.int64)]
        a, b, c = (corners[None, :, place] - points[:, None] for place in range(3))
        la, lb, lc = (np.linalg.norm(side, axis=2) for side in (a, b, c))
        volume = np.einsum("pmi,pmi->pm", a, np.cross(b, c))
        dots = (np.einsum("pmi,pmi->pm", one, other) for one, other in ((a, b), (b, c), (c, a)))
        ab, bc, ca = dots
        turned = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum(axis=1)
        return np.abs(turned) > 2.0 * np.pi


def box(x: float, y: float, z: float) -> Body:
    return Body("box", (float(x), float(y), float(z)))


def sphere(radius: float) -> Body:
    return Body("sphere", (float(radius),))


def cylinder(radius: float, length: float) -> Body:
    return Body("cylinder", (float(radius), float(length)))


def prism(outline: Floats, height: float, *, lids: bool) -> Body:
    """A prism over a star-shaped outline, with lids (then closed) or open at both ends."""
    count = len(outline)
    low = np.column_stack((outline, np.full(count, -height / 2.0)))
    high = np.column_stack((outline, np.full(count, height / 2.0)))
    ends = np.array([(0.0, 0.0, -height / 2.0), (0.0, 0.0, height / 2.0)])
    faces: list[tuple[int, int, int]] = []
    for here in range(count):
        there = (here + 1) % count
        faces += [(here, there, count + there), (here, count + there, count + here)]
        if lids:
            faces += [(there, here, 2 * count), (count + here, count + there, 2 * count + 1)]
    vertices = np.concatenate((low, high, ends)) if lids else np.concatenate((low, high))
    return Body("mesh", (), vertices, np.array(faces), lids)


def ball(radius: float, rings: int = 6, sides: int = 8) -> Body:
    """A closed ball of triangles."""
    turns = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    vertices = [(0.0, 0.0, -radius)]
    for tilt in np.linspace(-np.pi / 2, np.pi / 2, rings + 1)[1:-1]:
        vertices += [
            (
                radius * np.cos(tilt) * np.cos(turn),
                radius * np.cos(tilt) * np.sin(turn),
                radius * np.sin(tilt),
            )
            for turn in turns
        ]
    vertices.append((0.0, 0.0, radius))
    last, faces = len(vertices) - 1, list[tuple[int, int, int]]()
    for here in range(sides):
        there = (here + 1) % sides
        faces += [(0, 1 + there, 1 + here), (last, last - sides + here, last - sides + there)]
        for ring in range(rings - 2):
            base, over = 1 + ring * sides, 1 + (ring + 1) * sides
            faces += [
                (base + here, base + there, over + there),
                (base + here, over + there, over + here),
            ]
    return Body("mesh", (), np.array(vertices), np.array(faces), True)


def as_mesh(body: Body, rng: np.random.Generator) -> Body:
    """A closed mesh in place of a body: a ball of triangles, or a prism along x, a star at times."""
    if body.kind == "sphere":
        return ball(body.sizes[0])
    length, thick = (
        (body.sizes[0], body.sizes[1]) if body.kind == "box" else (body.sizes[1], 2 * body.sizes[0])
    )
    angles = np.linspace(0.0, 2.0 * np.pi, int(rng.integers(5, 12)), endpoint=False)
    far = thick * (rng.uniform(0.5, 1.0, len(angles)) if rng.random() < 0.3 else np.full(len(angles), 0.7))
    upright = prism(np.stack((far * np.cos(angles), far * np.sin(angles)), axis=1), length, lids=True)
    return Body("mesh", (), upright.vertices[:, [2, 0, 1]], upright.faces, True)


def mesh_file(body: Body, name: str, scale: float = 1.0) -> bytes:
    """A mesh as the bytes of a file, OBJ or binary STL, in a unit that is `1 / scale` metres."""
    vertices = scale * np.asarray(body.vertices)
    if name.endswith(".obj"):
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in np.asarray(body.faces).tolist()]
        return "\n".join([*lines, ""]).encode()
    corners = vertices.astype("<f4")[np.asarray(body.faces)].reshape(-1, 9)
    rows = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", 9), ("spare", "<u2")])
    rows["corners"] = corners
    return bytes(80) + np.uint32(len(rows)).tobytes() + rows.tobytes()
