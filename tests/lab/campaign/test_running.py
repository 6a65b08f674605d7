"""Every problem gets one row, once, whatever ends in between; and the rows are the same."""

import errno
import json
import os
import time
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.lab.campaign.rooms import rows_of
from trajopt.lab.campaign import (
    Campaign,
    CampaignFolder,
    Local,
    Progress,
    from_problems,
    installed,
    random_motions,
    resume_campaign,
    run_campaign,
)
from trajopt.lab.campaign.columns import encoded
from trajopt.values.errors import CampaignError, MissingExtra, ProblemError

pytestmark = pytest.mark.timeout(200)


def test_every_problem_has_a_verified_row(planned: CampaignFolder, small: Campaign) -> None:
    rows = list(planned.rows())
    assert len(rows) == planned.total == len(small) == 12
    assert {row["status"] for row in rows} == {"SOLVED"} and all(row["verified"] for row in rows)
    for row in rows:
        points = len(row["times"])
        assert len(row["positions"]) == len(row["velocities"]) == points * len(row["joint_names"])
        assert row["duration"] == row["times"][-1] and row["cpu_seconds"]["total"] > 0.0


def test_a_row_equals_the_result_of_plan(planned: CampaignFolder, task: to.Problem, tmp_path: Path) -> None:
    (row,) = run_campaign(Campaign("own", [from_problems("own", [task])]), tmp_path / "own", Local(1)).rows()
    plan = to.plan(task).require()
    assert np.array_equal(row["times"], plan.trajectory.times)
    assert np.array_equal(row["positions"], plan.trajectory.positions.ravel())
    assert row["clearance"] == plan.certificate.clearance and row["path_length"] == plan.path.length


def test_two_workers_give_the_same_rows(planned: CampaignFolder, small: Campaign, tmp_path: Path) -> None:
    assert rows_of(run_campaign(small, tmp_path / "two", Local(2))) == rows_of(planned)


def test_only_missing_rows_are_planned(planned: CampaignFolder, small: Campaign, tmp_path: Path) -> None:
    begun = CampaignFolder.begin(small, tmp_path / "begun")
    some = list(planned.rows())[:7]
    begun.write(encoded(some[:5]))
    begun.write(encoded(some[3:]))  # two of them twice
    (tmp_path / "begun" / "results" / ".half.parquet.1").write_bytes(b"PAR1 torn off")
    said: list[Progress] = []
    again = resume_campaign(begun.path, Local(1), progress=said.append)
    assert said[-1].planned == 5 and said[-1].done == said[-1].total == 12
    assert rows_of(again) == rows_of(planned)
    assert len(list(again.rows())) == 12
    before = [path.stat().st_mtime_ns for path in again.shards]
    resume_campaign(begun.path, Local(1))
    assert [path.stat().st_mtime_ns for path in again.shards] == before


def test_equal_problems_are_one_row(scene: to.Scene, tmp_path: Path) -> None:
    twice = Campaign("twice", [random_motions(scene, 2), random_motions(scene, 3)])
    assert len(twice) == 5 and CampaignFolder.begin(twice, tmp_path).total == 3


def test_a_folder_that_is_taken_is_refused(planned: CampaignFolder, small: Campaign) -> None:
    with pytest.raises(CampaignError, match="holds a campaign already"):
        run_campaign(small, planned.path)


def test_a_folder_without_a_campaign_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CampaignError, match="holds no campaign"):
        resume_campaign(tmp_path)
    (tmp_path / "campaign.json").write_text('{"format": "another"}')
    with pytest.raises(CampaignError, match="reads version 1"):
        CampaignFolder.open(tmp_path)


def test_other_versions_do_not_go_on(small: Campaign, tmp_path: Path) -> None:
    begun = CampaignFolder.begin(small, tmp_path)
    file = begun.path / "campaign.json"
    about = json.loads(file.read_text())
    about["versions"]["numpy"] = "1.0"
    file.write_text(json.dumps(about))
    with pytest.raises(CampaignError, match=r"numpy 1\.0 then, .* now"):
        resume_campaign(tmp_path)


def test_without_pyarrow_the_extra_is_named(
    small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def without(name: str) -> ModuleSpec | None:
        return None if name == "pyarrow" else find_spec(name)

    monkeypatch.setattr("trajopt.lab.campaign.columns.find_spec", without)
    with pytest.raises(MissingExtra, match=r"trajopt-planner\[parquet\]"):
        run_campaign(small, tmp_path / "none")
    assert not (tmp_path / "none").exists()


def on_disk(full: bool) -> None:
    """Be a disk that may be full."""
    if full:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_shard_that_cannot_be_written_is_planned_again(
    planned: CampaignFolder, small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = iter((False, False, True, True))  # after the table of problems, which is written
    monkeypatch.setattr("trajopt.values.documents.files.os.fsync", lambda _: on_disk(next(full, False)))
    said: list[Progress] = []
    folder = run_campaign(small, tmp_path / "full", Local(1), progress=said.append)
    assert said[-1].unwritten == 2 and rows_of(folder) == rows_of(planned)


def test_a_disk_that_stays_full_ends_it_and_it_can_be_resumed(
    planned: CampaignFolder, small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The table of problems and the first shard, each with its folder, are written; then there is no room.
    room = iter((True, True, True, True, False, False, False))
    with monkeypatch.context() as patched:
        patched.setattr("trajopt.values.documents.files.os.fsync", lambda _: on_disk(not next(room)))
        with pytest.raises(CampaignError, match=r"No space left on device.*campaign resume"):
            run_campaign(small, tmp_path / "full", Local(1))
    assert 0 < len(CampaignFolder.open(tmp_path / "full").done()) < 12
    assert rows_of(resume_campaign(tmp_path / "full", Local(1))) == rows_of(planned)


def test_a_failed_problem_has_a_row_with_its_reason(faulty: Path, tmp_path: Path) -> None:
    names = ("good", "ends", "ends_once", "hangs", "raises", "malformed")
    harm = Campaign("harm", [installed(name) for name in names], most_seconds=6.0)
    folder = run_campaign(harm, tmp_path / "harm", Local(1))
    told = {row["family"]: (row["status"], row["message"]) for row in folder.rows()}
    assert {name: status for name, (status, _) in told.items()} == {
        "good": "SOLVED", "ends": "CRASHED", "ends_once": "SOLVED", "hangs": "RAN_OVER", "raises": "FAILED",
        "malformed": "INVALID",
    }  # fmt: skip
    assert "exit status 3" in told["ends"][1] and "6 s" in told["hangs"][1]
    assert "RuntimeError: 'a fault of the code'" in told["raises"][1]
    assert "ProblemError: a goal is missing" in told["malformed"][1]
    said: list[Progress] = []
    resume_campaign(folder.path, Local(1), progress=said.append)
    assert said == []  # what crashed is not tried for ever


@pytest.mark.parametrize("late", [0.0, 0.5])
def test_workers_that_cannot_start_are_an_error(
    small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, late: float
) -> None:
    begun = CampaignFolder.begin(small, tmp_path)
    send = Connection.send
    monkeypatch.setattr(Connection, "send", lambda *told: (time.sleep(late), send(*told)))
    monkeypatch.setattr("trajopt.values.processes.sys.executable", "/bin/false")
    with pytest.raises(CampaignError, match="ended before it was ready"):
        resume_campaign(begun.path, Local(1))


def test_a_negative_number_of_workers_is_refused() -> None:
    with pytest.raises(ProblemError, match="workers must not be negative"):
        Local(-1)
