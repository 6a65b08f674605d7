"""What the tests of campaigns share."""

from typing import Any

from trajopt.campaign import CampaignFolder
from trajopt.campaign.columns import TIMES

PROBLEMS = ("good", "ends", "ends_once", "hangs", "raises", "malformed", "ends_planning")
FAULTY = """
import os, sys, time
from pathlib import Path
import trajopt as to
from trajopt.errors import ProblemError

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
