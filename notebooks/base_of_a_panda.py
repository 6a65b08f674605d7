"""The work that the base of a Panda has to be good for, and the campaign of it, for notebook 13.

python notebooks/base_of_a_panda.py OUT [--places NX NY TURNS]
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import trajopt as to
from trajopt.lab.campaign import (
    Campaign,
    CampaignFolder,
    Local,
    Options,
    base_placements,
    resume_campaign,
    run_campaign,
)

STORED = Path(__file__).with_name("base_of_a_panda.json")
AXES = ("x", "y", "z", "yaw")
"""Where the base stands [m, m, m, rad]."""
DOWN, FORWARD = (np.pi, 0.0, 0.0), (0.0, np.pi / 2, 0.0)
GOALS = {
    "table left": ((0.75, -0.40, 0.55), DOWN),
    "table right": ((0.75, 0.05, 0.58), DOWN),
    "above the crate": ((0.75, 0.35, 0.75), DOWN),
    "under the shelf": ((0.90, -0.30, 0.60), FORWARD),
    "on the shelf": ((0.85, 0.20, 0.90), FORWARD),
}
"""Where the hand has to go: position [m], roll, pitch and yaw [rad]."""


def tasks() -> list[to.Problem]:
    """Return one problem for each place that the hand has to go to, from the ready posture."""
    scene = to.Scene(to.load("panda"))
    scene = scene.add("table", to.Box(0.8, 1.2, 0.05), to.placement((0.9, 0.0, 0.375)))
    scene = scene.add("shelf", to.Box(0.3, 0.9, 0.02), to.placement((1.05, 0.0, 0.75)))
    scene = scene.add("crate", to.Box(0.2, 0.25, 0.2), to.placement((0.75, 0.35, 0.5)))
    scene = scene.add("post", to.Box(0.06, 0.06, 0.6), to.placement((0.62, -0.14, 0.7)))
    return [
        to.Problem(
            scene=scene, start="ready", goal=to.placement(at, rpy=turned), group="panda_arm", name=name
        )
        for name, (at, turned) in GOALS.items()
    ]


def campaign(x: Sequence[float], y: Sequence[float], yaw: Sequence[float]) -> Campaign:
    """Return the campaign of a grid: two attempts for each plan, the same answer everywhere."""
    return Campaign(
        "base of a Panda", [base_placements(tasks(), x=x, y=y, z=[0.3], yaw=yaw)], [Options(attempts=2)]
    )


def stored() -> list[dict[str, Any]]:
    """Return the rows that were stored: where the base stood, the task, and how planning ended."""
    found = json.loads(STORED.read_text())
    return [
        {
            "parameters": dict(zip(AXES, where, strict=True)),
            "family": task,
            "status": found["statuses"][status],
            "verified": found["statuses"][status] == "SOLVED",
        }
        for *where, ended in found["places"]
        for task, status in zip(found["tasks"], ended, strict=True)
    ]


def store(folder: CampaignFolder) -> None:
    """Store how planning ended, by place: a line of numbers for each, in the order of the tasks."""
    ended: dict[tuple[float, ...], dict[str, str]] = {}
    for row in folder.rows(("parameters", "family", "status")):
        where = tuple(row["parameters"][axis] for axis in AXES)
        ended.setdefault(where, {})[row["family"]] = row["status"]
    statuses = sorted({status for each in ended.values() for status in each.values()})
    places = [
        [*where, [statuses.index(each[task]) for task in GOALS]] for where, each in sorted(ended.items())
    ]
    lines = ",\n".join(json.dumps(place) for place in places)
    about = json.dumps({"versions": dict(folder.versions), "tasks": list(GOALS), "statuses": statuses})
    STORED.write_text(f'{about[:-1]}, "places": [\n{lines}\n]}}\n')


def main() -> None:
    """Run the campaign of the notebook's stored result, or go on with it, and store it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path, help="folder of the campaign; one that is there is gone on with")
    parser.add_argument("--places", type=int, nargs=3, default=(25, 20, 4))
    given = parser.parse_args()
    across, along, turns = given.places
    grid = [np.linspace(-0.3, 0.5, across), np.linspace(-0.6, 0.6, along), np.linspace(-0.8, 0.8, turns)]
    x, y, yaw = ([round(float(value), 4) for value in axis] for axis in grid)
    if given.out.exists():
        store(resume_campaign(given.out, Local()))
    else:
        store(run_campaign(campaign(x, y, yaw), given.out, Local()))


if __name__ == "__main__":
    main()
