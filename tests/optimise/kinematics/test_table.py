"""Tables for training: rows are true, and both files read back the same."""

import sys
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.lab.reach import read_table, sample_table
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model


def test_rows_are_true(odd: ReducedModel) -> None:
    told: list[int] = []
    table = sample_table(
        odd, "ball", 60, rng=np.random.default_rng(0), only_clear=False, progress=told.append
    )
    assert len(table) == 60 and told[-1] == 60 and 0 < table.clear.sum() < 60
    for row, q in enumerate(table.positions):
        where = odd.scene.placement_of("ball", odd.all_positions(q))
        np.testing.assert_allclose(table.translation[row], where.translation, atol=1e-12)
        np.testing.assert_allclose(table.quaternion[row], where.quaternion, atol=1e-9)
        assert table.clear[row] == (not to.examine(odd, q).collisions)


def test_only_clear_rows(odd: ReducedModel) -> None:
    table = sample_table(odd, "tip", 6000, rng=np.random.default_rng(0), reference="block")
    assert len(table) == 6000 and table.clear.all() and table.reference == "block"


@pytest.mark.parametrize("name", ["table.npz", "table.parquet"])
def test_written_and_read_back(odd: ReducedModel, tmp_path: Path, name: str) -> None:
    if name.endswith("parquet"):
        pytest.importorskip("pyarrow")
    table = sample_table(odd, "tip", 50, rng=np.random.default_rng(0), only_clear=False)
    table.write(tmp_path / name)
    again = read_table(tmp_path / name)
    for field, value in vars(table).items():
        np.testing.assert_array_equal(getattr(again, field), value)


def test_misuse_is_named(odd: ReducedModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    table = sample_table(odd, "tip", 3, rng=rng)
    with pytest.raises(to.TrajoptError, match=r"written as \.parquet or \.npz"):
        table.write(tmp_path / "table.csv")
    with pytest.raises(to.TrajoptError, match="holds no table"):
        read_table(tmp_path / "missing.npz")
    walls = odd.scene.add("solid", to.Box(5, 5, 5), to.placement((0, 0, 0.4)))
    with pytest.raises(to.TrajoptError, match="free of collision"):
        sample_table(reduce_model(walls, "all", odd.start), "tip", 3, rng=rng)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(to.MissingExtra, match=r"trajopt-planner\[parquet\]"):
        table.write(tmp_path / "table.parquet")
