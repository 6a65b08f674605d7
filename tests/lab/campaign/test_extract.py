"""Rows taken out of a campaign: as bundles, as motions, as arrays to train on."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.files.bundle import read_bundle
from trajopt.lab.campaign import (
    Campaign,
    CampaignFolder,
    Local,
    dataset,
    extract,
    installed,
    motion_of,
    problem_of,
    read_dataset,
    run_campaign,
)
from trajopt.values.errors import CampaignError, FileFormatError, ShapeError


def first(folder: CampaignFolder) -> str:
    return next(iter(folder.tasks())).id


def test_a_row_becomes_a_bundle_with_its_motion(planned: CampaignFolder, tmp_path: Path) -> None:
    found = extract(planned, first(planned)[:10], tmp_path / "row.trajopt")
    assert found.same is True and found.row == first(planned)
    kept = read_bundle(found.path)
    assert kept.judged().verified and kept.problem.name == "random motion 0"


def test_a_motion_is_judged_again_from_its_row_alone(planned: CampaignFolder) -> None:
    row = next(iter(planned.rows()))
    motion = motion_of(row)
    assert motion is not None
    assert to.judge(problem_of(planned, row["id"]), motion).verified
    with pytest.raises(CampaignError, match="without its columns"):
        motion_of({"id": row["id"]})


def test_a_motion_seeds_planning(planned: CampaignFolder) -> None:
    row = next(iter(planned.rows()))
    motion = motion_of(row)
    assert motion is not None
    result = to.plan(problem_of(planned, row["id"]), seeds=[motion.positions])
    assert result.verified and result.won is not None and result.won.number == 1


def test_rows_that_are_not_there_are_named(planned: CampaignFolder, tmp_path: Path) -> None:
    with pytest.raises(CampaignError, match=r"no rows of .* begins with 'x'"):
        extract(planned, "x", tmp_path / "none.trajopt")
    with pytest.raises(CampaignError, match="12 rows of"):
        problem_of(planned, "")


@pytest.mark.timeout(200)
def test_a_crashed_problem_is_kept(faulty: Path, tmp_path: Path) -> None:
    folder = run_campaign(Campaign("harm", [installed("ends_planning")]), tmp_path / "harm", Local(1))
    (row,) = folder.rows()
    assert row["status"] == "CRASHED"
    found = extract(folder, row["id"], tmp_path / "crashed.trajopt")
    assert found.same is None and read_bundle(found.path).status == ""


def test_motions_are_arrays_of_one_shape(planned: CampaignFolder, tmp_path: Path) -> None:
    found = dataset(planned, 16)
    assert found.positions.shape == found.velocities.shape == (12, 16, 2) and len(found) == 12
    rows = {row["id"]: row for row in planned.rows()}
    for place, key in enumerate(found.ids.tolist()):
        motion = motion_of(rows[key])
        assert motion is not None and found.durations[place] == motion.duration
        assert np.array_equal(found.positions[place, 0], motion.positions[0])
        assert np.allclose(found.positions[place, -1], motion.positions[-1])
        assert found.clearances[place] == rows[key]["clearance"]
    found.write(tmp_path / "set.npz")
    again = read_dataset(tmp_path / "set.npz")
    for name in vars(found):
        assert np.array_equal(getattr(again, name), getattr(found, name))


def test_shares_are_apart_and_batches_are_whole(planned: CampaignFolder) -> None:
    found = dataset(planned, 2)
    train, test = found.chosen(0.0, 0.7), found.chosen(0.7, 1.0)
    assert len(train) + len(test) == 12 and not set(train.ids.tolist()) & set(test.ids.tolist())
    batches = list(found.batches(5, rng=np.random.default_rng(0)))
    assert [len(batch) for batch in batches] == [5, 5, 2]
    assert sorted(key for batch in batches for key in batch.ids.tolist()) == sorted(found.ids.tolist())


def test_files_of_other_formats_are_refused_as_data_sets(planned: CampaignFolder, tmp_path: Path) -> None:
    found = dataset(planned, 2)
    with pytest.raises(FileFormatError, match=r"written as \.npz"):
        found.write(tmp_path / "set.csv")
    with pytest.raises(FileFormatError, match="holds no data set"):
        read_dataset(tmp_path / "missing.npz")
    with pytest.raises(ShapeError, match="must be at least 2"):
        dataset(planned, 1)
    with pytest.raises(ShapeError, match="must increase within"):
        found.chosen(0.5, 0.2)
    with pytest.raises(ShapeError, match="size: must be positive"):
        found.batches(0, rng=np.random.default_rng(0))
