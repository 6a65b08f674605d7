"""Covers of mesh files: the same from the cache as made anew, and made anew when the file changes."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from tests.robot.test_robot import tetrahedron
from trajopt.robot import bodies
from trajopt.robot.bodies import ConvexCover, Cover, MeshPolicy, convex_pieces, cover_file, cover_mesh
from trajopt.robot.robot import Robot
from trajopt.values.errors import MeshFileError
from trajopt.values.shapes.mesh import Mesh, load_mesh
from trajopt.values.shapes.shapes import Convex

SCALE = (0.1, 0.2, 0.3)


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TRAJOPT_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Two tetrahedra far apart, which become two pieces."""
    path = tmp_path / "two.stl"
    far = tetrahedron().replace("vertex 0 ", "vertex 9 ").replace("vertex 1 ", "vertex 10 ")
    path.write_text(f"{tetrahedron()}\n{far}\n")
    return path


def same(a: Cover, b: Cover) -> bool:
    return a.note == b.note and all(
        isinstance(one, Convex)
        and isinstance(other, Convex)
        and np.array_equal(one.vertices, other.vertices)
        and np.array_equal(one.faces, other.faces)
        for one, other in zip(a.shapes, b.shapes, strict=True)
    )


def test_a_kept_cover_is_the_one_made(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = cover_mesh(load_mesh(file, SCALE), MeshPolicy())
    assert len(expected.shapes) == 2
    assert same(cover_file(file, SCALE, MeshPolicy()), expected)
    monkeypatch.setattr(bodies, "load_mesh", None)
    kept = cover_file(file, SCALE, MeshPolicy())
    assert same(kept, expected)
    assert not any(array.flags.writeable for shape in kept.shapes for array in (shape.vertices, shape.faces))  # pyright: ignore
    for scale, policy in (((0.1, 0.2, 0.4), MeshPolicy()), (SCALE, MeshPolicy(tolerance=0.02))):
        with pytest.raises(TypeError):
            cover_file(file, scale, policy)


def test_a_changed_file_is_covered_again(file: Path) -> None:
    before = cover_file(file, SCALE, MeshPolicy())
    file.write_text(tetrahedron())
    after = cover_file(file, SCALE, MeshPolicy())
    assert (len(before.shapes), len(after.shapes)) == (2, 1)


def test_an_exact_mesh_is_read(file: Path) -> None:
    (shape,) = cover_file(file, SCALE, MeshPolicy(exact=True)).shapes
    assert isinstance(shape, Mesh)


def test_a_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(MeshFileError, match="gone"):
        cover_file(tmp_path / "gone.stl", SCALE, MeshPolicy())


def test_cutting_ends_at_its_bound_and_reports_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("TRAJOPT_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr("trajopt.robot.bodies._MOST_WORK", 1)
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(24)], axis=1)
    low, high = np.array((0.0, 0.0, -0.05)), np.array((0.0, 0.0, 0.05))
    corners = np.concatenate([0.3 * ring + low, 0.3 * ring + high, 0.25 * ring + high, 0.25 * ring + low])
    first, after = np.arange(24), (np.arange(24) + 1) % 24
    faces = [
        quad
        for side in range(4)
        for a, b in (((24 * side) % 96, (24 * side + 24) % 96),)
        for quad in (
            *np.stack([a + first, a + after, b + after], axis=1),
            *np.stack([a + first, b + after, b + first], axis=1),
        )
    ]
    mesh = Mesh(corners, np.array(faces, dtype=np.int32))
    assert mesh.is_closed
    covers = [cover_mesh(mesh, MeshPolicy()) for _ in range(2)]
    assert "protrude by up to" in covers[0].note and "MeshPolicy(exact=True)" in covers[0].note
    assert covers[0].note == covers[1].note, "work is counted, not timed"
    for corner in mesh.vertices:
        assert any(
            np.all(hull.equations[:, :3] @ corner + hull.equations[:, 3] <= 1e-9)
            for hull in (ConvexHull(shape.vertices) for shape in covers[0].shapes)
        ), "the surface stays covered"
    monkeypatch.setattr("trajopt.robot.bodies._MOST_WORK", 10**10)
    monkeypatch.setenv("TRAJOPT_CACHE_DIR", str(tmp_path / "anew"))
    assert "stand out" not in cover_mesh(mesh, MeshPolicy()).note


CRANE = """<robot name="crane"><link name="base"/>
<link name="boom"><collision><geometry>
<mesh filename="two.stl" scale="{0} {0} {0}"/></geometry></collision></link>
<link name="jib"><collision><geometry>
<mesh filename="two.stl" scale="0.01 0.01 0.01"/></geometry></collision></link>
<joint name="slew" type="revolute"><parent link="base"/><child link="boom"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
<joint name="luff" type="revolute"><parent link="boom"/><child link="jib"/><axis xyz="0 1 0"/>
<origin xyz="{1} 0 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


@pytest.mark.parametrize(
    ("reach", "given", "boom"), [(1.5, None, 0.01), (10.0, None, 0.05), (10.0, 0.02, 0.02)]
)
def test_only_large_meshes_of_large_robots_are_covered_less_finely(
    file: Path, monkeypatch: pytest.MonkeyPatch, reach: float, given: float | None, boom: float
) -> None:
    (file.parent / "crane.urdf").write_text(CRANE.format(0.5, reach))
    used: list[float] = []

    def recorded(mesh: Mesh, *, hull_excess: float, tolerance: float) -> ConvexCover:
        used.append(tolerance)
        return convex_pieces(mesh, hull_excess=hull_excess, tolerance=tolerance)

    monkeypatch.setattr(bodies, "convex_pieces", recorded)
    policy = None if given is None else MeshPolicy(tolerance=given)
    Robot.from_urdf(file.parent / "crane.urdf", meshes=policy)
    jib = 0.01 if given is None else given
    assert used == pytest.approx([boom, jib])
