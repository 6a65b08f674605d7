import struct
from collections.abc import Callable
from pathlib import Path

import coal
import numpy as np
import pytest
from numpy.typing import NDArray

import trajopt as to
from trajopt.values.errors import MeshFileError, ShapeError
from trajopt.values.shapes.mesh import Mesh, load_mesh

CORNERS_OF_SIDES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
BOX_FACES = np.array([f for a, b, c, d in CORNERS_OF_SIDES for f in ((a, b, c), (a, c, d))], dtype=np.int32)
"""Triangles, two a side: bottom, top, front, back, left, right. Corner i is at the upper end of x, y, z
where bit 0, 1, 2 of i is set."""


def box(*size: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]) * size + np.array(at)
    return Mesh(corners, BOX_FACES)


def joined(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces).astype(np.int32))


def write_binary_stl(path: Path, triangles: NDArray[np.float64]) -> None:
    records = [struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in triangles]
    path.write_bytes(b"\0" * 80 + struct.pack("<I", len(triangles)) + b"".join(records))


def write_ascii_stl(path: Path, triangles: NDArray[np.float64]) -> None:
    lines = ["solid box"]
    for triangle in triangles:
        corners = [f"vertex {x:.9g} {y:.9g} {z:.9g}" for x, y, z in triangle]
        lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid box", ""]))


def write_obj(path: Path, triangles: NDArray[np.float64]) -> None:
    vertices = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in triangles.reshape(-1, 3)]
    faces = [f"f {i + 1} {i + 2} {i + 3}" for i in range(0, 3 * len(triangles), 3)]
    path.write_text("\n".join([*vertices, *faces, ""]))


DAE = """<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="millimeter" meter="0.001"/><up_axis>Y_UP</up_axis></asset>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="a" count="12">0 0 0 1 0 0 0 2 0 0 0 3</float_array>
      <technique_common><accessor source="#a" count="4" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>
      <p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s">
    <node id="outer"><translate>10 20 30</translate>
      <node id="inner"><rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node></node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
"""


@pytest.mark.parametrize(
    ("name", "write"),
    [("box.STL", write_binary_stl), ("box.stl", write_ascii_stl), ("box.obj", write_obj)],
)
def test_formats_give_the_same_box(
    tmp_path: Path, name: str, write: Callable[[Path, NDArray[np.float64]], None]
) -> None:
    write(tmp_path / name, box(0.5, 0.25, 2.0).triangles)
    mesh = load_mesh(tmp_path / name)
    assert mesh.vertices.shape == (8, 3)
    assert mesh.faces.shape == (12, 3)
    assert mesh.faces.dtype == np.int32
    assert mesh.is_closed
    assert mesh.volume == pytest.approx(0.25)
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), (0.5, 0.25, 2.0))


def test_polygons_of_obj_become_triangles(tmp_path: Path) -> None:
    (tmp_path / "square.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nf 1 2 3 4\n")
    mesh = load_mesh(tmp_path / "square.obj")
    assert len(mesh.faces) == 2
    assert mesh.vertices.max() == 1.0


def test_dae_applies_nodes_and_neither_unit_nor_up_axis(tmp_path: Path) -> None:
    path = tmp_path / "tetrahedron.dae"
    path.write_text(DAE)
    mesh = load_mesh(path, (2.0, 1.0, 1.0))
    expected = np.array([(10, 20, 30), (10, 21, 30), (8, 20, 30), (10, 20, 33)]) * (2.0, 1.0, 1.0)
    np.testing.assert_allclose(sorted(mesh.vertices.tolist()), sorted(expected.tolist()), atol=1e-6)
    same = np.array(coal.MeshLoader().load(str(path), np.array((2.0, 1.0, 1.0))).vertices())
    assert {*map(tuple, mesh.vertices)} == {*map(tuple, same)}


def test_mirroring_keeps_faces_outward(tmp_path: Path) -> None:
    write_binary_stl(tmp_path / "box.stl", box(1.0, 1.0, 1.0).triangles)
    assert load_mesh(tmp_path / "box.stl", (1.0, -2.0, 1.0)).volume == pytest.approx(2.0)
    assert load_mesh(tmp_path / "box.stl", (-1.0, -2.0, 1.0)).volume == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("missing.stl", None, "no such file"),
        ("empty.stl", b"", "empty"),
        ("words.dae", b"these are words", "malformed"),
        ("no_faces.stl", b"solid x\nendsolid x\n", "invalid primitive"),
        ("points.obj", b"v 0 0 0\nv 1 0 0\n", "no meshes"),
        ("cut_off.stl", b"\0" * 80 + struct.pack("<I", 12) + b"\0" * 60, "storage"),
        ("sliver.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no triangle|no meshes"),
        ("not_a_number.obj", b"v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", "not finite"),
        ("box.xyz", b"", "no suitable reader"),
    ],
)
def test_bad_files(tmp_path: Path, name: str, content: bytes | None, reason: str) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshFileError, match=f"(?i){name}.*({reason})") as caught:
        load_mesh(tmp_path / name)
    assert caught.value.path == str(tmp_path / name)
    assert "Hint" not in caught.value.reason


def test_a_folder_is_not_a_mesh_file(tmp_path: Path) -> None:
    with pytest.raises(MeshFileError, match="no such file"):
        load_mesh(tmp_path)


def test_construction_merges_and_drops() -> None:
    soup = box(1.0, 1.0, 1.0).triangles.reshape(-1, 3)
    faces = np.arange(36, dtype=np.int32).reshape(-1, 3)
    extra = np.array([(0, 0, 1), (2, 2, 2)], dtype=np.int32)
    mesh = Mesh(np.vstack([soup, (9.0, 9.0, 9.0)]), np.vstack([faces, extra]))
    assert mesh.vertices.shape == (8, 3)
    assert mesh.faces.shape == (12, 3)
    assert mesh.is_closed
    np.testing.assert_array_equal(mesh.triangles.reshape(-1, 3), soup)


def test_a_face_without_area_is_dropped() -> None:
    flat = Mesh(np.array([(0.0, 0, 0), (1, 0, 0), (0.3, 0, 0), (0, 1, 0)]), np.array([(0, 1, 2), (0, 1, 3)]))
    assert len(flat.faces) == 1
    assert flat.distance(np.array([(0.2, 0.2, 0.5)])) == pytest.approx([0.5])


def test_arrays_are_read_only() -> None:
    mesh = box(1.0, 1.0, 1.0)
    for array in (mesh.vertices, mesh.faces):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@pytest.mark.parametrize(
    ("vertices", "faces", "name"),
    [
        (np.zeros((3, 2)), [[0, 1, 2]], "vertices"),
        (np.full((3, 3), np.nan), [[0, 1, 2]], "vertices"),
        (np.eye(3), [[0, 1]], "faces"),
        (np.eye(3), [[0, 1, 3]], "faces"),
        (np.eye(3), [[0, 1, -1]], "faces"),
    ],
)
def test_bad_arrays(vertices: NDArray[np.float64], faces: list[list[int]], name: str) -> None:
    with pytest.raises(ShapeError, match=name):
        Mesh(vertices, np.array(faces, dtype=np.int32))


def test_closed_and_open() -> None:
    closed = box(1.0, 2.0, 3.0)
    assert closed.is_closed
    assert not Mesh(closed.vertices, closed.faces[:-1]).is_closed
    assert not Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32)).is_closed
    assert Mesh(closed.vertices, closed.faces[:, ::-1]).volume == pytest.approx(-6.0)


class TestContains:
    rng = np.random.default_rng(7)
    points = rng.uniform(-0.5, 2.5, (4000, 3))

    def inside(self, low: float, high: float) -> NDArray[np.bool_]:
        return ((self.points > low) & (self.points < high)).all(axis=1)

    def test_box(self) -> None:
        np.testing.assert_array_equal(box(2, 2, 2).contains(self.points), self.inside(0, 2))

    def test_overlapping_parts_are_a_union(self) -> None:
        both = joined(box(1.5, 1.5, 1.5), box(1.5, 1.5, 1.5, at=(0.5, 0.5, 0.5)))
        expected = self.inside(0, 1.5) | self.inside(0.5, 2)
        np.testing.assert_array_equal(both.contains(self.points), expected)

    def test_a_part_within_a_part_makes_no_cavity(self) -> None:
        both = joined(box(2, 2, 2), box(1, 1, 1, at=(0.5, 0.5, 0.5)))
        np.testing.assert_array_equal(both.contains(self.points), self.inside(0, 2))

    def test_orientation_does_not_matter(self) -> None:
        mesh = box(2, 2, 2)
        mixed = Mesh(
            mesh.vertices, np.where(np.arange(12)[:, None] % 3 == 0, mesh.faces[:, ::-1], mesh.faces)
        )
        np.testing.assert_array_equal(mixed.contains(self.points), self.inside(0, 2))

    def test_an_open_part_contains_nothing(self) -> None:
        mesh = box(2, 2, 2)
        lidless = Mesh(mesh.vertices, mesh.faces[2:])
        assert not lidless.contains(self.points).any()
        assert not lidless.contains(self.points, opening=1.0).any()

    def test_a_crack_leaves_a_part_closed(self) -> None:
        mesh = box(2, 2, 2)
        corners = np.vstack([mesh.vertices, (1.0, 1.0, 2.0), (1.001, 1.0, 2.0)])
        lid = np.array([(4, 5, 8), (5, 9, 8), (5, 7, 9), (7, 6, 9), (6, 8, 9), (6, 4, 8)])
        whole = np.vstack([mesh.faces[:2], mesh.faces[4:], lid])
        assert Mesh(corners, whole).is_closed
        without_narrow, without_wide = (
            Mesh(corners, whole[whole.sum(axis=1) != 23]),
            Mesh(corners, whole[:-1]),
        )
        assert not without_narrow.is_closed
        assert not without_narrow.contains(self.points).any()
        expected = self.inside(0, 2)
        np.testing.assert_array_equal(without_narrow.contains(self.points, opening=0.01), expected)
        assert not without_wide.contains(self.points, opening=0.01).any()

    def test_nothing_contains_no_points(self) -> None:
        assert box(1, 1, 1).contains(np.zeros((0, 3))).shape == (0,)


def test_distance_is_to_the_surface_on_both_sides() -> None:
    points = np.array([(0.5, 0.5, 0.1), (0.5, 0.5, 1.5), (2.0, 0.5, 0.5), (2.0, 2.0, 0.5), (0.0, 0.0, 0.0)])
    expected = [0.1, 0.5, 1.0, np.sqrt(2.0), 0.0]
    np.testing.assert_allclose(box(1, 1, 1).distance(points), expected, atol=1e-6)


CORNERS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
BAD_FACES: dict[str, object] = {
    "fractions": [(0, 1, 2.7)],
    "whole numbers as floats": np.array([(0.0, 1.0, 2.0)]),
    "text": [(0, 1, "2")],
    "truth values": [(0, 1, True)],
    "an array of truth values": np.array([(False, True, True)]),
    "ragged": [(0, 1, 2), (0, 1)],
    "infinite": [(0, 1, float("inf"))],
    "too large for any integer": [(0, 1, 10**30)],
    "negative": [(0, 1, -1)],
    "beyond the last vertex": [(0, 1, 4)],
    "pairs": [(0, 1)],
    "one face without its row": (0, 1, 2),
    "nothing": None,
    "a mapping": {"faces": 1},
}


@pytest.mark.parametrize("name", BAD_FACES)
def test_rejects_faces_that_are_not_indices(name: str) -> None:
    with pytest.raises(ShapeError, match=r"Mesh\.faces"):
        Mesh(np.array(CORNERS), BAD_FACES[name])  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.int32, np.uint64])
def test_accepts_faces_of_every_integer_type(kind: type) -> None:
    assert len(to.Mesh(CORNERS, np.array([(0, 1, 2)], dtype=kind)).faces) == 1  # type: ignore[arg-type]
    assert len(to.Mesh(CORNERS, [(0, 1, 2)]).faces) == 1  # type: ignore[arg-type]


@pytest.mark.parametrize("coordinate", [1e38, 1e7, np.inf, np.nan])
def test_rejects_coordinates_beyond_any_cell(coordinate: float, tmp_path: Path) -> None:
    with pytest.raises(ShapeError, match=r"Mesh\.vertices"):
        to.Mesh([*CORNERS[:3], (0.0, 0.0, coordinate)], [(0, 1, 3)])  # type: ignore[arg-type]
    corners = "".join(f"vertex {x} {y} {coordinate}\n" for x, y, _ in CORNERS[:3])
    file = tmp_path / "far.stl"
    file.write_text(f"solid far\nfacet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\nendsolid far\n")
    with pytest.raises(MeshFileError, match=r"far\.stl"):
        to.load_mesh(file)


@pytest.mark.parametrize("scale", [0.0, (0.001, 0.001, 0.0)])
def test_a_scale_that_flattens_a_mesh_is_refused(
    tmp_path: Path, scale: float | tuple[float, float, float]
) -> None:
    path = tmp_path / "corner.stl"
    path.write_bytes(b"")
    with pytest.raises(MeshFileError, match="its scale must not be 0"):
        load_mesh(path, scale)
