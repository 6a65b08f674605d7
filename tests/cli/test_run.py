"""`trajopt run`: driven in the simulated world, with what happened in words or as JSON."""

import json
from pathlib import Path

from tests.cli.test_commands import common, folder, trajopt

__all__ = ["folder"]


def test_a_run_tells_what_happened(folder: Path, tmp_path: Path) -> None:
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
