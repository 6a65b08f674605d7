"""Rows over a face: spacing, edges, holes, normals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from trajopt.tasks.cartesian import raster
from trajopt.values.errors import ProblemError


def plate(length: float = 0.4, width: float = 0.2) -> to.Mesh:
    """A box whose first two triangles are its top."""
    x, y, z = length / 2.0, width / 2.0, 0.01
    corners = [(i * x, j * y, k * z) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    top = [(1, 5, 7), (1, 7, 3)]
    rest = [
        (0, 2, 6),
        (0, 6, 4),
        (0, 4, 5),
        (0, 5, 1),
        (2, 3, 7),
        (2, 7, 6),
        (0, 1, 3),
        (0, 3, 2),
        (4, 6, 7),
        (4, 7, 5),
    ]
    return to.Mesh(np.array(corners), np.array(top + rest, dtype=np.int32))


def frame() -> to.Mesh:
    """A square plane of 0.3 m with a square hole of 0.1 m in its middle."""
    steps = np.linspace(-0.15, 0.15, 4)
    corners = np.array([(x, y, 0.0) for x in steps for y in steps])
    faces: list[tuple[int, int, int]] = []
    for i in range(3):
        for j in range(3):
            if (i, j) != (1, 1):
                a, b, c, d = 4 * i + j, 4 * (i + 1) + j, 4 * (i + 1) + j + 1, 4 * i + j + 1
                faces += [(a, b, c), (a, c, d)]
    return to.Mesh(corners, np.array(faces, dtype=np.int32))


def tube(sides: int = 48, radius: float = 0.2) -> to.Mesh:
    """A half tube along y, outside up."""
    angles = np.linspace(0.0, np.pi, sides + 1)
    ring = [(radius * np.cos(a), radius * np.sin(a)) for a in angles]
    corners = np.array([(x, y, z) for x, z in ring for y in (-0.3, 0.3)])
    faces = [
        f for k in range(sides) for f in ((2 * k, 2 * k + 2, 2 * k + 1), (2 * k + 1, 2 * k + 2, 2 * k + 3))
    ]
    return to.Mesh(corners, np.array([(a, c, b) for a, b, c in faces], dtype=np.int32))


@settings(deadline=None, max_examples=40)
@given(st.floats(0.1, 0.6), st.floats(0.05, 0.3), st.floats(0.005, 0.04), st.floats(0.0, 0.01))
def test_rows_cover_a_rectangle(length: float, width: float, spacing: float, margin: float) -> None:
    curves = raster(plate(length, width), 0, spacing, along=(1, 0, 0), margin=margin)
    assert len(curves) == int(np.floor((width - 2.0 * margin) / spacing + 1e-9)) + 1
    ends = [curve(np.array((0.0, curve.length))).translation for curve in curves]
    across = np.array([end[0, 1] for end in ends])
    np.testing.assert_allclose(np.abs(np.diff(across)), spacing, atol=1e-9)
    np.testing.assert_allclose(across.min() + across.max(), 0.0, atol=1e-9)
    for number, (end, curve) in enumerate(zip(ends, curves, strict=True)):
        assert curve.length == pytest.approx(length - 2.0 * margin)
        assert (end[1, 0] > end[0, 0]) == (number % 2 == 0 or (ends[0][1, 0] < ends[0][0, 0]))
        np.testing.assert_allclose(end[:, 2], 0.01, atol=1e-12)
        np.testing.assert_allclose(curve(np.zeros(1)).rotation[0, :, 2], (0.0, 0.0, -1.0), atol=1e-12)


def test_the_longest_extent_is_the_default_direction() -> None:
    curve = raster(plate(0.1, 0.4), 1, 0.02)[0]
    assert curve.length == pytest.approx(0.4)


def test_a_hole_splits_rows() -> None:
    curves = raster(frame(), 0, 0.02, along=(1, 0, 0), margin=0.01)
    lengths = sorted({round(curve.length, 9) for curve in curves})
    assert lengths == [0.08, 0.28]
    short = [curve for curve in curves if curve.length < 0.1]
    for curve in short:
        points = curve(np.linspace(0.0, curve.length, 50)).translation
        assert (np.abs(points[:, 0]) > 0.05 + 0.0099).all()


def test_on_a_bent_face_the_tool_keeps_its_normal() -> None:
    mesh = tube()
    for curve in raster(mesh, 20, 0.05, along=(1, 0, 0)):
        at = curve(np.linspace(0.0, curve.length, 200))
        away = np.hypot(at.translation[:, 0], at.translation[:, 2])
        assert (np.abs(away - 0.2) < 0.2 * (1.0 - np.cos(np.pi / 96)) + 1e-9).all(), "on the chords"
        outward = np.column_stack((at.translation[:, 0], 0.0 * away, at.translation[:, 2])) / away[:, None]
        angle = np.arccos(np.clip(-(outward * at.rotation[:, :, 2]).sum(axis=1), -1.0, 1.0))
        assert angle.max() < np.pi / 48


def test_a_placed_mesh_moves_its_rows() -> None:
    where = to.placement((0.5, 0.1, 0.3), rpy=(0.3, -0.2, 1.0))
    still, moved = (raster(plate(), 0, 0.05, at=at) for at in (to.placement((0, 0, 0)), where))
    for a, b in zip(still, moved, strict=True):
        np.testing.assert_allclose(
            b(np.zeros(1)).translation[0], where * a(np.zeros(1)).translation[0], atol=1e-12
        )


def test_mistakes_are_named() -> None:
    for words, arguments in (
        ("one of 12 triangles, is 12", {"face": 12}),
        ("no room for a row", {"margin": 0.2}),
        ("spacing must be positive", {"spacing": 0.0}),
        ("not be the normal", {"along": (0, 0, 1)}),
    ):
        with pytest.raises(ProblemError, match=words):
            raster(**{"mesh": plate(), "face": 0, "spacing": 0.01, **arguments})  # pyright: ignore
