"""Pictures of reach maps, of a frame and of a curve."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.lab import reach
from trajopt.lab.reach import CAUSES, CurveMap, CurveReach, curve_map, reach_map
from trajopt.optimise.kinematics import reduce_model
from trajopt.tasks.cartesian import FollowsCurve, line
from trajopt.values.errors import FrameNotFound, ProblemError, ShapeError
from trajopt.viewer import plot_curve_map, plot_reach


def test_cuts_show_reached_cells(tmp_path: Path) -> None:
    robot = odd_arm(tmp_path)
    reduced = reduce_model(to.Scene(robot), "all", robot.positions())
    few, many = (reach_map(reduced, "tip", n, rng=np.random.default_rng(0), cell=0.1) for n in (5, 5000))
    images = [
        np.asarray(Image.open(plot_reach(found, tmp_path / name)))
        for found, name in ((few, "few"), (many, "many"))
    ]
    coloured = [
        float((image[..., :3].max(axis=2) - image[..., :3].min(axis=2) > 30).mean()) for image in images
    ]
    assert coloured[1] > coloured[0] + 0.1
    with pytest.raises(to.TrajoptError, match=r"known: .*png"):
        plot_reach(few, tmp_path / "map.xlsx")


def mapped(required: FollowsCurve, **options: int) -> CurveMap:
    """Map a curve that begins free, passes through a block and leaves the reach of the arm."""
    block = to.placement((0.62, 0.0, 0.3))
    scene = to.Scene(to.load("panda")).add("block", to.Box(0.2, 0.6, 0.6), block)
    reduced = to.Problem(scene=scene, group="panda_arm", start="ready", goal="ready").reduced
    return curve_map(reduced, required, rng=np.random.default_rng(0), **options)


def outwards(frame: str = "panda_hand_tcp") -> FollowsCurve:
    ends = [to.placement((x, 0.0, 0.3), rpy=(np.pi, 0.0, 0.0)) for x in (0.4, 1.24)]
    return to.follows_curve(frame, line(*ends), spin=(0.0, 0.0, 1.0))


def test_stretches_that_no_spin_reaches_are_named_and_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = mapped(outwards(), points=5, spins=4)
    assert [CAUSES[place] for place in found.cells.min(axis=1)] == [
        CurveReach.REACHED,
        CurveReach.COLLISION,
        CurveReach.OUT_OF_REACH,
        CurveReach.OUT_OF_REACH,
        CurveReach.OUT_OF_REACH,
    ]
    assert found.stretches == (
        (pytest.approx(0.21), pytest.approx(0.21), CurveReach.COLLISION),
        (pytest.approx(0.42), pytest.approx(0.84), CurveReach.OUT_OF_REACH),
    )
    assert "from 0.42 m to 0.84 m: out of reach" in str(found)
    image = np.asarray(Image.open(plot_curve_map(found, tmp_path / "map")))[..., :3].reshape(-1, 3)
    for colour in ((0x4C, 0x9F, 0x70), (0xC8, 0x55, 0x3D), (0xC9, 0xCE, 0xD6)):
        assert (image == colour).all(axis=1).mean() > 0.05
    monkeypatch.setattr(reach, "NEARLY_SINGULAR", 10.0)
    singular = mapped(outwards(), points=1, spins=1)
    assert CAUSES[singular.cells[0, 0]] is CurveReach.SINGULAR


def test_small_and_large_arms_have_the_same_map(tmp_path: Path) -> None:
    """Arms of 4 cm, 1 m and 40 m on a rail."""
    found = [_map_of_size(tmp_path, size).cells.tolist() for size in (0.04, 1.0, 40.0)]
    assert {cell for row in found[1] for cell in row} > {CAUSES.index(CurveReach.REACHED)}
    assert found[0] == found[1] == found[2]


def _map_of_size(folder: Path, size: float) -> CurveMap:
    turns = '<limit lower="-3" upper="3" velocity="1" effort="1"/>'
    slides = f'<limit lower="{-0.5 * size}" upper="{0.5 * size}" velocity="1" effort="1"/>'
    joints = (
        ("rail", "prismatic", 0.0, "0 1 0", slides),
        ("lift", "revolute", 0.0, "0 1 0", turns),
        ("bend", "revolute", 0.5, "0 1 0", turns),
        ("roll", "revolute", 0.4, "1 0 0", turns),
        ("nod", "revolute", 0.1, "0 0 1", turns),
        ("spin", "revolute", 0.1, "1 0 0", turns),
    )
    parts = ['<link name="base"/>']
    before = "base"
    for name, kind, x, axis, limit in joints:
        parts.append(
            f'<link name="{name} link"/><joint name="{name}" type="{kind}"><parent link="{before}"/>'
            f'<child link="{name} link"/><origin xyz="{x * size} 0 0"/><axis xyz="{axis}"/>{limit}</joint>'
        )
        before = f"{name} link"
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="arm">{"".join(parts)}</robot>')
    robot = to.load(path)
    reduced = to.Problem(scene=to.Scene(robot), start=robot.positions(), goal=robot.positions()).reduced
    ends = [to.placement((x * size, 0.0, 0.1 * size), rpy=(0.0, 0.2, 0.0)) for x in (0.5, 1.09)]
    required = to.follows_curve(before, line(*ends), position_tolerance=1e-4 * size)
    return curve_map(reduced, required, rng=np.random.default_rng(0), points=6, spins=6)


def test_maps_of_wrong_curves_are_refused() -> None:
    with pytest.raises(FrameNotFound, match="no frame named 'tcp'"):
        mapped(outwards("tcp"))
    with pytest.raises(ShapeError, match="points"):
        mapped(outwards(), points=0)
    ends = [to.placement((x, 0.0, 0.3)) for x in (0.4, 0.5)]
    free = to.follows_curve("panda_hand_tcp", line(*ends), rotation_tolerance=np.inf)
    with pytest.raises(ProblemError, match="the rotation along the curve is free"):
        mapped(free)
