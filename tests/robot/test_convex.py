"""Covers of meshes: nothing of the surface is left out, and what is open stays open."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import coal
import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull

from tests.values.test_mesh_file import box, joined
from trajopt.robot import bodies
from trajopt.robot.bodies import FARTHEST, THICKNESS, ConvexCover, CoverMethod, convex_pieces
from trajopt.values.errors import ShapeError
from trajopt.values.shapes.mesh import Mesh

TOLERANCE = 0.01
SEEN = 0.004
"""How much farther than the tolerance pieces may reach between the points that are looked at [m]."""


def revolved(profile: ArrayLike, steps: int) -> Mesh:
    """Turn a closed profile of points (radius, height), counter-clockwise, around z."""
    radius, height = np.array(profile).T
    angle = 2.0 * np.pi * np.arange(steps)[:, None] / steps
    ring = np.stack(np.broadcast_arrays(radius * np.cos(angle), radius * np.sin(angle), height), axis=-1)
    here = np.arange(ring[..., 0].size).reshape(steps, -1)
    there, above, both = np.roll(here, -1, 0), np.roll(here, -1, 1), np.roll(here, (-1, -1), (0, 1))
    faces = np.stack([here, there, above, above, there, both], axis=-1).reshape(-1, 3)
    return Mesh(ring.reshape(-1, 3), faces.astype(np.int32))


def l_shape() -> Mesh:
    corners = np.array([(0, 0), (0.3, 0), (0.3, 0.1), (0.1, 0.1), (0.1, 0.4), (0, 0.4)])
    low, high = np.column_stack([corners, np.zeros(6)]), np.column_stack([corners, np.full(6, 0.08)])
    cap = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)])
    here, there = np.arange(6), np.roll(np.arange(6), -1)
    walls = np.stack([here, there, there + 6, here, there + 6, here + 6], axis=1).reshape(-1, 3)
    return Mesh(np.concatenate([low, high]), np.concatenate([cap[:, ::-1], cap + 6, walls]).astype(np.int32))


def torus() -> Mesh:
    angle = 2.0 * np.pi * np.arange(8) / 8
    return revolved(np.column_stack([0.1 + 0.03 * np.cos(angle), 0.03 * np.sin(angle)]), 16)


def tube() -> Mesh:
    return revolved([(0.04, 0), (0.05, 0), (0.05, 0.2), (0.04, 0.2)], 16)


def sheet_bin() -> Mesh:
    """Five sides of a box, without thickness and without a lid."""
    whole = box(0.4, 0.3, 0.2)
    return Mesh(whole.vertices, np.delete(whole.faces, (2, 3), axis=0))


def walled_bin() -> Mesh:
    """A bin of walls 3 mm thick, one closed surface."""
    wall = 0.003
    outer, inner = box(0.4, 0.3, 0.2), box(0.4 - 2 * wall, 0.3 - 2 * wall, 0.2 - wall, at=(wall,) * 3)
    sides = np.delete(outer.faces, (2, 3), axis=0)
    loop = np.array([4, 5, 7, 6])
    after = np.roll(loop, -1)
    rim = np.stack([loop, after, after + 8, loop, after + 8, loop + 8], axis=1).reshape(-1, 3)
    faces = np.concatenate([sides, sides[:, ::-1] + 8, rim]).astype(np.int32)
    return Mesh(np.concatenate([outer.vertices, inner.vertices]), faces)


def shelf() -> Mesh:
    boards = [box(0.8, 0.3, 0.02, at=(0.0, 0.0, z)) for z in (0.0, 0.4, 0.8)]
    sides = [box(0.02, 0.3, 0.82, at=(x, 0.0, 0.0)) for x in (-0.02, 0.8)]
    return joined(*boards, *sides)


MESHES = {make.__name__: make for make in (l_shape, torus, tube, sheet_bin, walled_bin, shelf)}


@dataclass(frozen=True)
class Case:
    mesh: Mesh
    cover: ConvexCover


@pytest.fixture(autouse=True, scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("covers")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TRAJOPT_CACHE_DIR", str(folder))
        yield folder


def case(name: str) -> Case:
    """Make a mesh and its cover, from the module's cache after the first time."""
    mesh = MESHES[name]()
    return Case(mesh, convex_pieces(mesh, tolerance=TOLERANCE))


def spread(triangles: NDArray[np.float64], count: int, seed: int) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    a, b, c = np.moveaxis(triangles, 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    which = rng.choice(len(area), count, p=area / area.sum())
    return np.einsum("kc,kcx->kx", rng.dirichlet((1, 1, 1), count), triangles[which])


def outside_of(pieces: tuple[NDArray[np.float64], ...], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far each point is outside of the union, measured across the nearest piece's planes."""
    planes = [ConvexHull(piece).equations for piece in pieces]
    return np.min([(points @ p[:, :3].T + p[:, 3]).max(axis=1) for p in planes], axis=0)


def clearance(cover: ConvexCover, point: tuple[float, float, float]) -> float:
    where, dot = coal.Transform3s(np.eye(3), np.array(point)), coal.Sphere(1e-9)
    distances: list[float] = []
    for piece in cover.pieces:
        points = coal.StdVec_Vec3s()
        points.extend(list(piece))
        hull = coal.Convex.convexHull(points, False, "Qt")
        result = coal.DistanceResult()
        distances.append(coal.distance(hull, coal.Transform3s(), dot, where, coal.DistanceRequest(), result))
    return min(distances)


@pytest.mark.parametrize("name", MESHES)
def test_pieces_contain_the_surface(name: str) -> None:
    tested = case(name)
    points = np.concatenate([tested.mesh.vertices, spread(tested.mesh.triangles, 20_000, seed=1)])
    assert outside_of(tested.cover.pieces, points).max() <= 1e-9


@pytest.mark.parametrize("name", MESHES)
def test_pieces_reach_no_farther_than_the_tolerance(name: str) -> None:
    tested = case(name)
    assert tested.cover.method is CoverMethod.DECOMPOSITION
    assert tested.cover.reach <= FARTHEST * TOLERANCE
    for piece in tested.cover.pieces:
        points = spread(piece[ConvexHull(piece).simplices], 1000, seed=2)
        points = points[~tested.mesh.contains(points)]
        assert tested.mesh.distance(points).max(initial=0.0) <= TOLERANCE + SEEN


@pytest.mark.parametrize(
    ("name", "most"),
    [("l_shape", 2), ("torus", 9), ("tube", 6), ("sheet_bin", 5), ("walled_bin", 5), ("shelf", 5)],
)
def test_pieces_are_few(name: str, most: int) -> None:
    assert len(case(name).cover.pieces) <= most


@pytest.mark.parametrize(
    ("name", "point", "true"),
    [
        ("sheet_bin", (0.2, 0.15, 0.12), 0.12),
        ("walled_bin", (0.2, 0.15, 0.12), 0.117),
        ("shelf", (0.4, 0.15, 0.22), 0.18),
        ("tube", (0.0, 0.0, 0.1), 0.04 * np.cos(np.pi / 16)),
        ("torus", (0.0, 0.0, 0.0), 0.07 * np.cos(np.pi / 16)),
    ],
)
def test_open_meshes_stay_open(name: str, point: tuple[float, float, float], true: float) -> None:
    distance = clearance(case(name).cover, point)
    assert true - TOLERANCE - SEEN <= distance <= true + 1e-6


@pytest.mark.parametrize("name", MESHES)
def test_only_extreme_points(name: str) -> None:
    for piece in case(name).cover.pieces:
        assert len(ConvexHull(piece).vertices) == len(piece)
        assert not piece.flags.writeable


def test_a_box_is_its_hull() -> None:
    cover = convex_pieces(box(0.1, 0.2, 0.3))
    assert cover.method is CoverMethod.HULL
    assert [piece.shape for piece in cover.pieces] == [(8, 3)]
    assert cover.excess is None, "nobody has to ask for the volume of what is its own hull"
    assert cover.reach <= TOLERANCE


def test_overlapping_parts_that_make_a_box_are_its_hull() -> None:
    cover = convex_pieces(joined(box(0.3, 0.2, 0.2), box(0.3, 0.2, 0.2, at=(0.1, 0.0, 0.0))))
    assert cover.method is CoverMethod.HULL


def test_volume_counts_overlaps_once() -> None:
    cross = joined(box(0.6, 0.1, 0.1, at=(-0.3, -0.05, -0.05)), box(0.1, 0.6, 0.1, at=(-0.05, -0.3, -0.05)))
    cover = convex_pieces(cross)
    volume = 0.1 * (2 * 0.06 - 0.01)
    assert cover.excess == pytest.approx(ConvexHull(cross.vertices).volume / volume - 1.0, rel=0.02)
    assert len(cover.pieces) == 2


def test_a_hull_that_adds_little_volume_is_taken_up_to_twice_the_tolerance() -> None:
    notched = joined(
        box(0.3, 0.3, 0.1), box(0.3, 0.1, 0.015, at=(0.0, 0.0, 0.1)), box(0.3, 0.1, 0.015, at=(0.0, 0.2, 0.1))
    )
    share = convex_pieces(notched).excess
    assert share is not None
    assert 0.0 < share <= 0.05
    assert convex_pieces(notched).method is CoverMethod.HULL
    assert convex_pieces(notched, hull_excess=0.5 * share).method is CoverMethod.DECOMPOSITION
    assert convex_pieces(notched, tolerance=0.006).method is CoverMethod.DECOMPOSITION


def test_a_shut_hollow_is_filled() -> None:
    walls = joined(walled_bin(), box(0.4, 0.3, 0.003, at=(0.0, 0.0, 0.2)))
    cover = convex_pieces(walls)
    assert cover.method is CoverMethod.HULL
    knobbed = joined(walls, box(0.02, 0.02, 0.05, at=(0.19, 0.14, 0.203)))
    volume = 0.4 * 0.3 * 0.203 + 0.02 * 0.02 * 0.05  # the hollow is 0.95 of the box
    expected = ConvexHull(knobbed.vertices).volume / volume - 1.0
    assert convex_pieces(knobbed).excess == pytest.approx(expected, abs=0.05)


def test_tiny_and_flat_meshes_have_a_volume() -> None:
    square = Mesh(np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]), np.array([(0, 1, 2), (0, 2, 3)]))
    cover = convex_pieces(square)
    assert cover.method is CoverMethod.HULL
    np.testing.assert_allclose(np.ptp(cover.pieces[0], axis=0), (1.0, 1.0, THICKNESS), atol=1e-12)
    dust = convex_pieces(box(1e-6, 1e-6, 1e-6))
    assert ConvexHull(dust.pieces[0]).volume >= 0.9 * THICKNESS**3


def test_a_flat_mesh_is_cut_in_its_plane() -> None:
    corners = np.array(
        [(0.0, 0, 0), (0.4, 0, 0), (0.4, 0.05, 0), (0.05, 0.05, 0), (0.05, 0.4, 0), (0, 0.4, 0)]
    )
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    flat = Mesh(corners @ turn.T, np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]))
    cover = convex_pieces(flat)
    assert len(cover.pieces) == 2
    assert outside_of(cover.pieces, flat.vertices).max() <= 1e-9
    assert clearance(cover, tuple(turn @ (0.2, 0.2, 0.0))) >= 0.15 - TOLERANCE


def test_cutting_ends_at_the_number_of_pieces() -> None:
    mesh = torus()
    cover = convex_pieces(mesh, max_pieces=3)
    assert len(cover.pieces) <= 3
    assert cover.reach > TOLERANCE
    assert outside_of(cover.pieces, mesh.vertices).max() <= 1e-9


def same(a: ConvexCover, b: ConvexCover) -> bool:
    pieces = len(a.pieces) == len(b.pieces) and all(map(np.array_equal, a.pieces, b.pieces))
    return pieces and (a.method, a.excess, a.reach) == (b.method, b.excess, b.reach)


def test_covers_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TRAJOPT_CACHE_DIR", str(tmp_path / "new" / "folder"))
    first = convex_pieces(l_shape())
    (file,) = (tmp_path / "new" / "folder").iterdir()
    assert same(first, convex_pieces(l_shape(), tolerance=TOLERANCE))
    monkeypatch.setattr(bodies, "_cover", None)
    kept = convex_pieces(l_shape())
    assert same(first, kept)
    assert not kept.pieces[0].flags.writeable
    with pytest.raises(TypeError):
        convex_pieces(l_shape(), tolerance=0.02)
    with pytest.raises(TypeError):
        convex_pieces(box(0.1, 0.2, 0.3))
    assert [*file.parent.iterdir()] == [file]


def test_the_same_mesh_has_the_same_cover(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = convex_pieces(l_shape())
    monkeypatch.setenv("TRAJOPT_CACHE_DIR", str(tmp_path))
    assert same(first, convex_pieces(l_shape()))


@pytest.mark.parametrize("damage", ["empty", "words", "cut off", "another archive", "a byte"])
def test_a_damaged_file_is_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damage: str) -> None:
    monkeypatch.setenv("TRAJOPT_CACHE_DIR", str(tmp_path))
    first = convex_pieces(box(0.1, 0.2, 0.3))
    (file,) = tmp_path.iterdir()
    content = file.read_bytes()
    middle = len(content) // 3
    match damage:
        case "empty":
            file.write_bytes(b"")
        case "words":
            file.write_text("these are words")
        case "cut off":
            file.write_bytes(content[:middle])
        case "another archive":
            np.savez(file, something=np.zeros(3))
        case _:
            file.write_bytes(content[:middle] + bytes([content[middle] ^ 255]) + content[middle + 1 :])
    assert same(first, convex_pieces(box(0.1, 0.2, 0.3)))
    monkeypatch.setattr(bodies, "_cover", None)
    assert same(first, convex_pieces(box(0.1, 0.2, 0.3)))


def test_an_unwritable_cache_folder_is_not_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("TRAJOPT_CACHE_DIR", str(tmp_path / "file"))
    assert len(convex_pieces(box(0.1, 0.2, 0.3)).pieces) == 1


@pytest.mark.parametrize("bad", [{"tolerance": 0.0}, {"hull_excess": -0.1}, {"max_pieces": 0}])
def test_bad_options(bad: dict[str, float]) -> None:
    with pytest.raises(ShapeError, match=next(iter(bad))):
        convex_pieces(box(1.0, 1.0, 1.0), **bad)  # type: ignore[arg-type]


def test_a_mesh_without_faces() -> None:
    with pytest.raises(ShapeError, match="no face"):
        convex_pieces(Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32)))
