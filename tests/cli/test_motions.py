"""`trajopt plan` and `trajopt check` among things that move."""

import json
from pathlib import Path

import pytest

from tests.cli.test_commands import common, folder, plan_file, trajopt

__all__ = ["folder", "plan_file"]
MOTIONS = """
- object: pillar
  times: [0.0, 0.6]
  positions: [[{x}, 0.0, 0.3], [{x}, 0.0, 2.3]]
"""


@pytest.mark.parametrize(("x", "status"), [(0.72, 0), (3.0, 0)])
def test_a_plan_among_things_that_move_is_checked_among_them(folder: Path, x: float, status: int) -> None:
    motions, plan = folder / f"motions{x}.yaml", folder / f"moving{x}.json"
    motions.write_text(MOTIONS.format(x=x))
    done = trajopt("plan", *common(folder), "--motions", motions, "--out", plan)
    assert done.returncode == status, done.stderr + done.stdout
    assert json.loads(plan.read_text())["source"]["motions"] == str(motions)
    checked = trajopt("check", *common(folder), "--motions", motions, plan)
    assert checked.returncode == 0 and "proven given that pillar is on its track" in checked.stdout
    refused = trajopt("view", plan, "--seconds", 1)
    assert refused.returncode == 2 and "the scene changes with time" in refused.stderr


def test_a_plan_that_stood_the_test_alone_may_fail_among_them(folder: Path, plan_file: Path) -> None:
    motions = folder / "down.yaml"
    motions.write_text(MOTIONS.format(x=0.4).replace("2.3", "0.3"))
    checked = trajopt("check", *common(folder), "--motions", motions, plan_file)
    assert checked.returncode == 1 and "pillar" in checked.stdout
