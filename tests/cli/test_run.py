"""`trajopt run`: driven in the simulated world, with what happened in words or as JSON."""

import json
from pathlib import Path

import pytest

from tests.cli.test_commands import common, folder, trajopt
from tests.files.log.read_mcap import read
from tests.viewer.test_viewer import free_port

__all__ = ["folder"]


def test_a_run_prints_its_events(folder: Path, tmp_path: Path) -> None:
    out, picture = tmp_path / "run.json", tmp_path / "run.png"
    done = trajopt("run", *common(folder), "--out", out, "--picture", picture, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["reached"] and told["contacts_at_fault"] == [] and told["missed_deadlines"] == 0
    assert json.loads(out.read_text())["measured"]["joint_names"]
    assert picture.stat().st_size > 1000


def test_a_random_surprise_is_drawn_by_its_seed(folder: Path) -> None:
    done = trajopt("run", *common(folder), "--surprises", "random:3")
    assert "world changed" in done.stdout and "clearance" in done.stdout, done.stderr


def test_a_seed_that_is_none_is_refused(folder: Path) -> None:
    done = trajopt("run", *common(folder), "--surprises", "random:x")
    assert done.returncode == 2 and "takes a whole number" in done.stderr


def test_a_run_is_shown_recorded_and_replayed(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    record, port = tmp_path / "run.json", str(free_port())
    shown = ("--view", "--port", port, "--seconds", "0.1")
    done = trajopt("run", *common(folder), "--record", record, *shown)
    assert done.returncode == 0, done.stderr
    assert f"open http://127.0.0.1:{port}" in done.stdout and "reached the goal" in done.stdout
    assert json.loads(record.read_text())["format"] == "trajopt recording"
    seen = trajopt("view", record, "--port", port, "--seconds", "0.1", "--json")
    assert seen.returncode == 0 and json.loads(seen.stdout)["url"].startswith("http"), seen.stderr


def test_a_run_is_recorded_as_a_log(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("mcap", reason="the extra `mcap` is not installed")
    done = trajopt("run", *common(folder), "--record", tmp_path / "run.mcap", "--surprises", "random:3")
    assert done.returncode in {0, 1}, done.stderr
    topics = read(tmp_path / "run.mcap")
    assert {"/joint_states", "/tf", "/scene", "/events", "/plan", "/committed"} == set(topics)
    events = [message["message"] for _, message in topics["/events"]]
    assert any("world changed" in words for words in events) and len(topics["/scene"]) > 1


def test_a_recording_that_names_no_robot_needs_one(folder: Path, tmp_path: Path) -> None:
    record = tmp_path / "run.json"
    trajopt("run", *common(folder), "--record", record)
    record.write_text(json.dumps({**json.loads(record.read_text()), "robot": {"name": "planar2"}}))
    seen = trajopt("view", record, "--seconds", "0.1")
    assert seen.returncode == 2 and "give --robot" in seen.stderr


def test_a_published_run_prints_the_mirror_command(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    record, port = tmp_path / "run.json", free_port()
    done = trajopt("run", *common(folder), "--publish", port, "--record", record)
    assert done.returncode == 0, done.stderr
    assert f"trajopt view --mirror http://127.0.0.1:{port}" in done.stdout and record.is_file()


def test_a_tolerance_is_stated_with_the_room_that_it_takes(folder: Path) -> None:
    done = trajopt("run", *common(folder), "--tolerance", "0.5")
    assert done.returncode == 1 and "CLEARANCE_IMPOSSIBLE" in done.stdout, done.stdout + done.stderr


def test_a_run_is_recorded_for_rerun(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="the extra `rerun` is not installed")
    done = trajopt("run", *common(folder), "--record", tmp_path / "run.rrd")
    assert done.returncode == 0 and (tmp_path / "run.rrd").read_bytes()[:3] == b"RRF"
