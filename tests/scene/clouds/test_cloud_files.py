"""Clouds and octrees read from files, sound and damaged."""

import struct
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.values.errors import FileFormatError

POINTS = np.round(np.random.default_rng(3).uniform(-1.0, 1.0, (120, 3)), 4).astype(np.float32)


def ply(form: str) -> bytes:
    header = (
        f"ply\nformat {form} 1.0\ncomment by hand\nelement camera 1\nproperty int id\nelement vertex 120\n"
        "property float x\nproperty uchar red\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    if form == "ascii":
        rows = "".join(f"{x} 7 {y} {z}\n" for x, y, z in POINTS.tolist())
        return (header + "5\n" + rows + "3 0 1 2\n").encode()
    order = "<" if form == "binary_little_endian" else ">"
    rows = b"".join(struct.pack(order + "fBff", x, 7, y, z) for x, y, z in POINTS.tolist())
    return header.encode() + struct.pack(order + "i", 5) + rows + struct.pack(order + "Biii", 3, 0, 1, 2)


def literal(data: bytes) -> bytes:
    """Fold bytes as LZF does where nothing repeats."""
    runs = [data[begin : begin + 32] for begin in range(0, len(data), 32)]
    return b"".join(bytes((len(run) - 1,)) + run for run in runs)


def pcd(form: str) -> bytes:
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS intensity x y z\nSIZE 1 4 4 4\n"
        f"TYPE U F F F\nCOUNT 2 1 1 1\nWIDTH 9\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 120\nDATA {form}\n"
    ).encode()
    if form == "ascii":
        return header + "".join(f"7 8 {x} {y} {z}\n" for x, y, z in POINTS.tolist()).encode()
    if form == "binary":
        return header + b"".join(struct.pack("<BBfff", 7, 8, x, y, z) for x, y, z in POINTS.tolist())
    columns = bytes((7, 8)) * 120 + b"".join(POINTS[:, axis].tobytes() for axis in range(3))
    # The repeated pair is a copy that runs into what it writes, the rest as it is.
    folded = bytes((1, 7, 8)) + bytes((7 << 5, 238 - 9, 1)) + literal(columns[240:])
    return header + struct.pack("<II", len(folded), len(columns)) + folded


FILES = {
    **{f"{form}.ply": ply(form) for form in ("ascii", "binary_little_endian", "binary_big_endian")},
    **{f"{form}.pcd": pcd(form) for form in ("ascii", "binary", "binary_compressed")},
}


@pytest.mark.parametrize("name", FILES)
def test_points_are_read(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(FILES[name])
    cloud = to.Points.from_file(tmp_path / name, radius=0.01)
    assert np.allclose(cloud.points, POINTS, atol=1e-7)
    assert cloud.radius == 0.01


@pytest.mark.parametrize("name", FILES)
def test_a_truncated_file_raises_a_typed_error_or_lacks_only_unread_bytes(tmp_path: Path, name: str) -> None:
    whole = FILES[name]
    for end in range(0, len(whole), max(1, len(whole) // 60)):
        (tmp_path / name).write_bytes(whole[:end])
        try:
            cloud = to.Points.from_file(str(tmp_path / name), radius=0.01)
        except FileFormatError as error:
            assert name in str(error)
        else:
            assert len(cloud) == 120


def test_arrays_are_read(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", POINTS)
    np.save(tmp_path / "picture.npy", np.column_stack((POINTS, POINTS)).reshape(10, 12, 6))
    np.savez(tmp_path / "one.npz", cloud=POINTS)
    np.savez(tmp_path / "named.npz", points=POINTS, colours=POINTS)
    for name in ("a.npy", "picture.npy", "one.npz", "named.npz"):
        assert np.allclose(to.Points.from_file(tmp_path / name, radius=0.01).points, POINTS)


def test_points_that_are_not_finite_are_left_out_of_files(tmp_path: Path) -> None:
    holed = POINTS.copy()
    holed[::2] = np.nan
    np.save(tmp_path / "a.npy", holed)
    assert len(to.Points.from_file(tmp_path / "a.npy", radius=0.01)) == 60
    np.save(tmp_path / "b.npy", np.full((4, 3), np.nan))
    with pytest.raises(FileFormatError, match="no point"):
        to.Points.from_file(tmp_path / "b.npy", radius=0.01)


@pytest.mark.parametrize(
    ("name", "data", "said"),
    (
        ("a.xyz", b"", "is not a cloud: .ply"),
        ("a.ply", b"solid", "no PLY header"),
        ("a.ply", b"ply\nformat ascii 1.0\nend_header\n", "vertex"),
        ("a.ply", ply("ascii").replace(b"property float z\n", b""), "cannot be read"),
        ("a.ply", ply("ascii").replace(b"vertex 120", b"vertex 1e9"), "cannot be read"),
        ("a.ply", ply("binary_big_endian").replace(b"vertex 120", b"vertex 999999999999"), "ends within"),
        ("a.pcd", pcd("binary").replace(b"POINTS 120", b"POINTS -2"), "negative"),
        ("a.pcd", pcd("binary").replace(b"x y z", b"u v w"), "cannot be read"),
        ("a.pcd", pcd("binary").replace(b"SIZE 1 4 4 4", b"SIZE 1 9 4 4"), "cannot be read"),
        ("a.npy", b"junk", "cannot be read"),
    ),
)
def test_files_without_a_cloud_are_named(tmp_path: Path, name: str, data: bytes, said: str) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(FileFormatError, match=said):
        to.Points.from_file(tmp_path / name, radius=0.01)


def test_pickled_arrays_are_not_unpickled(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.array([print], dtype=object), allow_pickle=True)
    with pytest.raises(FileFormatError, match="cannot be read"):
        to.Points.from_file(tmp_path / "a.npy", radius=0.01)
    with pytest.raises(FileFormatError, match="no such file"):
        to.Points.from_file(tmp_path / "none.npy", radius=0.01)


def test_octrees_are_read(tmp_path: Path) -> None:
    octomap = pytest.importorskip("octomap")
    tree = octomap.OcTree(0.05)
    eight = {(16 + i, 8 + j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)}
    keys = {(0, 0, 0), (3, -2, 7), (-9, 4, 1)} | eight
    for key in keys:
        for _ in range(9):  # up to the clamping, so that eight equal ones are pruned to one
            tree.updateNode((np.array(key) + 0.5) * 0.05, True)
    tree.updateNode(np.array((1.0, 1.0, 1.0)), False)
    tree.updateInnerOccupancy()
    tree.writeBinary(str(tmp_path / "map.bt").encode())
    tree.write(str(tmp_path / "map.ot").encode())
    for name in ("map.bt", "map.ot"):
        cells = to.Voxels.from_file(tmp_path / name)
        assert cells.size == pytest.approx(0.05)
        assert {(i, j, k) for i, j, k in cells.keys.tolist()} == keys
        cut = (tmp_path / name).read_bytes()[:-9]
        (tmp_path / f"cut{name}").write_bytes(cut)
        with pytest.raises(FileFormatError, match="damaged"):
            to.Voxels.from_file(tmp_path / f"cut{name}")


@pytest.mark.parametrize("name", ("a.bt", "a.ot", "a.tree"))
def test_files_without_an_octree_are_named(tmp_path: Path, name: str) -> None:
    with pytest.raises(FileFormatError, match=r"no such file|is not an octree"):
        to.Voxels.from_file(tmp_path / name)
    (tmp_path / name).write_bytes(b"# Octomap OcTree binary file\nid OcTree\nsize 3\nres 0.1\ndata\nxx")
    with pytest.raises(FileFormatError, match=name):
        to.Voxels.from_file(tmp_path / name)
