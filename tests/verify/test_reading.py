"""What the judge reads: little, and nothing of planning, of loading robots and of editing scenes."""

import subprocess
import sys

import pytest

from benchmarks.house_targets import closure
from tests.architecture.import_graph import ROOT

MOST_FILES, MOST_LINES = 70, 10_000
NEVER = (
    "trajopt.planning",
    "trajopt.optimise",
    "trajopt.geometry",
    "trajopt.robot.robot",
    "trajopt.scene.scene",
)
FIRST_MET = """
import numpy as np
import trajopt as to
from trajopt.verify import Judge, Specification

arm = to.load("planar2")
rest = {"joint1": 0.0, "joint2": 0.3}
problem = to.Problem(scene=to.Scene(arm), start=rest, goal=rest)
positions = problem.reduced.start_positions
motion = to.Trajectory(problem.reduced.joint_names, np.array([0.0, 1.0]), np.stack((positions, positions)))
here = problem.scene.placement_of("tool", problem.reduced.all_positions(positions))
placed = to.frame_placement("tool", here)
"""
WAYPOINT = "asked = Specification(goals=(), waypoints={'here': (placed,)})"
GOAL = "asked = Specification(goals=(placed,))"
JUDGED = """
certificate = Judge(problem.reduced).certify(motion, asked)
names = [check.name for check in certificate.checks]
assert certificate.verified and {"waypoint here: position", "goal: position"} & {*names}, names
"""


def test_the_judge_reads_few_files_and_no_planner() -> None:
    read = dict(closure(ROOT))
    assert len(read) <= MOST_FILES and sum(read.values()) <= MOST_LINES
    assert not [name for name in read if name.startswith(NEVER)]


@pytest.mark.parametrize("asked", [WAYPOINT, GOAL], ids=["waypoint", "goal"])
def test_the_check_of_a_kind_is_read_when_the_kind_is_met_first(asked: str) -> None:
    subprocess.run([sys.executable, "-c", "\n".join((FIRST_MET, asked, JUDGED))], check=True, cwd=ROOT)
