"""The reach map: counted again one configuration at a time, and against areas known in closed form."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.lab.reach import ReachMap, even_directions, reach_map
from trajopt.robot.joints import draw_positions
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model


def test_cells_are_those_of_plain_counting(odd: ReducedModel) -> None:
    found = reach_map(odd, "ball", 400, rng=np.random.default_rng(7), cell=0.1, directions=12)
    hits: dict[tuple[int, int, int], int] = {}
    directions: dict[tuple[int, int, int], set[int]] = {}
    sphere = even_directions(12)
    for q in draw_positions(odd.limits, 400, rng=np.random.default_rng(7)):
        if not to.examine(odd, q).collisions:
            where = odd.scene.placement_of("ball", odd.all_positions(q))
            cell = found.cell_of(where.translation)
            assert cell is not None
            hits[cell] = hits.get(cell, 0) + 1
            directions.setdefault(cell, set()).add(int(np.argmax(sphere @ where.rotation[:, 2])))
    assert hits and sum(hits.values()) == found.valid == found.hits.sum() < found.drawn
    for cell, count in hits.items():
        assert found.hits[cell] == count and found.reached[cell] == len(directions[cell])
        assert found.manipulability[cell] >= 0.0
    assert (found.hits > 0).sum() == len(hits)
    assert (found.reachability_index <= 1.0).all() and found.cell_of((9.0, 0.0, 0.0)) is None


def test_volume_of_a_planar_arm(planar_arm: to.Robot) -> None:
    """Two links of 0.5 m reach a disc of radius 1 m but for a hole and a wedge: cells count its area."""
    reduced = reduce_model(to.Scene(planar_arm), "arm", planar_arm.positions("bent"))
    cell = 0.05
    found = reach_map(reduced, "hand", 60_000, rng=np.random.default_rng(0), cell=cell)
    rng = np.random.default_rng(1)
    shoulder, elbow = rng.uniform(-3, 3, 200_000), rng.uniform(-2.5, 2.5, 200_000)
    x = 0.5 * np.cos(shoulder) + 0.5 * np.cos(shoulder + elbow)
    y = 0.5 * np.sin(shoulder) + 0.5 * np.sin(shoulder + elbow)
    expected = len(np.unique(np.floor(np.stack((x, y)) / cell), axis=1).T)
    assert found.hits.shape[2] == 1
    assert (found.hits > 0).sum() == pytest.approx(expected, rel=0.02)
    assert found.reached.max() == 1  # the approach axis is upright always


def test_directions_are_even() -> None:
    directions = even_directions(200)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(directions.mean(axis=0), 0.0, atol=5e-3)
    rng = np.random.default_rng(0)
    random = rng.normal(size=(100_000, 3))
    counts = np.bincount(np.argmax(random @ directions.T, axis=1), minlength=200)
    assert counts.min() > 350 and counts.max() < 650


def test_written_and_read_back(odd: ReducedModel, tmp_path: Path) -> None:
    found = reach_map(odd, "tip", 200, rng=np.random.default_rng(0), reference="block", margin=None)
    path = found.save(tmp_path / "map")
    assert path.name == "map.npz"
    again = ReachMap.load(path)
    for name, value in vars(found).items():
        np.testing.assert_array_equal(getattr(again, name), value)
    assert str(again) == str(found) and "tip of odd reaches" in str(found)


def test_misuse_is_named(odd: ReducedModel, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(to.TrajoptError, match="no frame named 'tpi'"):
        reach_map(odd, "tpi", 10, rng=rng)
    with pytest.raises(to.TrajoptError, match="cell: must be positive"):
        reach_map(odd, "tip", 10, rng=rng, cell=0.0)
    with pytest.raises(to.TrajoptError, match="at least 1"):
        reach_map(odd, "tip", 0, rng=rng)
    with pytest.raises(to.TrajoptError, match=r"written as \.npz"):
        reach_map(odd, "tip", 100, rng=rng).save(tmp_path / "map.json")
    (tmp_path / "bad.npz").write_text("no map")
    with pytest.raises(to.TrajoptError, match="holds no reach map"):
        ReachMap.load(tmp_path / "bad.npz")
