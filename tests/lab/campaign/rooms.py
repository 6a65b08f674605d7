"""What the tests of campaigns share: messages of MoveIt, and problems that do harm."""

from typing import Any

from trajopt.lab.campaign import CampaignFolder
from trajopt.lab.campaign.columns import TIMES

SCENE = """
world:
  collision_objects:
  - id: ball
    header: {frame_id: world}
    primitives: [{type: 2, dimensions: [0.1]}]
    primitive_poses: [{position: [0.65, 0.65, 0.1], orientation: [0, 0, 0, 1]}]
"""
REQUEST = """
group_name: arm
start_state: {joint_state: {name: [joint1, joint2], position: [0.0, 0.4]}}
goal_constraints:
- joint_constraints:
  - {joint_name: joint1, position: 1.4}
  - {joint_name: joint2, position: 0.4}
"""
PROBLEMS = ("good", "ends", "ends_once", "hangs", "raises", "malformed", "ends_planning")
FAULTY = """
import os, sys, time
from pathlib import Path
import trajopt as to
from trajopt.values.errors import ProblemError

def good():
    return to.Problem(scene=to.Scene(to.load("planar2")), start=[0.0, 0.4], goal={"joint1": 0.9})

def ends():
    os._exit(3)

def ends_once():
    mark = Path(os.environ["FAULTY"]) / "mark"
    if mark.exists():
        return good()
    mark.touch()
    os._exit(3)

def ends_planning():
    if "pytest" in sys.modules:
        return good()
    os._exit(3)

def hangs():
    time.sleep(1000.0)

def raises():
    raise RuntimeError("a fault of the code")

def malformed():
    raise ProblemError("a goal is missing")
"""


def rows_of(folder: CampaignFolder) -> dict[str, dict[str, Any]]:
    """Return the rows of a campaign by id, without what differs from run to run."""
    return {
        row["id"]: {name: item for name, item in row.items() if name not in TIMES} for row in folder.rows()
    }
