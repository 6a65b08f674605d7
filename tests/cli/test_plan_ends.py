"""`trajopt plan --start --goal`: a motion without a file in YAML."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.process import trajopt

PANDA = ("plan", "--robot", "panda", "--group", "panda_arm", "--start", "ready")


@pytest.mark.parametrize(
    "goal",
    [
        "0.4 0.1 0.5 3.14159 0 0",
        "extended",
        "0.1 -0.7 0 -2.3 0 1.5 0.7",
        "panda_joint1=0.4 panda_joint2=-0.5",
    ],
    ids=["placement", "state", "numbers", "joints by name"],
)
def test_plans_to_each_form_of_a_goal(goal: str) -> None:
    done = trajopt(*PANDA, "--goal", goal)
    assert done.returncode == 0, done.stdout
    assert ("panda_hand_tcp" in done.stdout) == goal.startswith("0.4")


def test_a_plan_without_files_is_checked_again_from_its_json(tmp_path: Path) -> None:
    out = tmp_path / "plan.json"
    assert trajopt(*PANDA, "--goal", "0.4 0.1 0.5 180 0 0", "--degrees", "--out", out).returncode == 0
    assert json.loads(out.read_text())["source"]["goal"] == "0.4 0.1 0.5 180 0 0"
    assert trajopt("check", out).returncode == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--goal", "redy"), "did you mean 'ready'"),
        (("--goal", "panda_joint1=much"), "is not joint=position"),
        (("--goal", "a b"), "--goal must be the name of a state"),
        (("--goal", "panda_joint1=0.1 panda_joint1=0.2"), "--goal has two positions of one joint"),
        ((), "give --start and --goal"),
    ],
)
def test_names_the_fault_of_a_goal(words: tuple[str, ...], said: str) -> None:
    done = trajopt(*PANDA, *words)
    assert done.returncode == 2
    assert said in " ".join(done.stderr.split())


def test_warns_of_degrees_in_one_line() -> None:
    command = [sys.executable, "-m", "trajopt", *PANDA, "--goal", "0.4 0.1 0.5 180 0 0"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stderr.startswith("trajopt: warning: rpy is (180, 0, 0) rad")
    assert done.stderr.count("\n") == 1
