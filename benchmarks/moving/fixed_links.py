"""Boxes that pass through a fixed link: problems without an answer.

python -m benchmarks.moving.fixed_links DATA --out benchmarks/moving/not_askable.json

The boxes were drawn by where they hit links that move; what else is in their way, the arm's own base too,
was not looked at. The rule: a problem is not asked if its box touches a link that no joint of the arm moves
(Coal, on the shapes of the links) before the joint that has farthest to go can be at the goal, at its speed
limit all the way. No motion changes that. What is touched later is left as it comes: a motion may be over.

What the rule leaves out lies in `not_askable.json`, once and for all: the problem, and why.
"""

import argparse
import json
from pathlib import Path

import numpy as np

import trajopt as to
from benchmarks.moving.crossings import ROBOTS, Arm, Crossing, crossings, instances
from trajopt.problem.requirements import JointPositions

FILE = Path(__file__).with_name("not_askable.json")
LEAST = 1e-3
"""Shortest time that is skipped [s]: 1 mm of a box's way at most."""


def first_touch(problem: to.Problem, crossing: Crossing, *, near: float = 0.0) -> float | None:
    """Return when a box first touches a link that no joint moves [s]; None if it never does.

    Args:
        problem: Of the arm.
        crossing: The box.
        near: What counts as touching [m].
    """
    fixed, track = Arm(problem.reduced, carried=False), crossing.track
    bodies = fixed.placements(problem.reduced.start_positions)
    speed, now = float(np.linalg.norm(crossing.velocity)), 0.0
    while now <= track.end:
        distance = fixed.distance(bodies, crossing.shape, track.at(now))
        if distance <= near:
            return now
        now += max((distance - near) / speed, LEAST)
    return None


def least_time(problem: to.Problem) -> float:
    """Return how long the joint that has farthest to go takes at its speed limit [s]."""
    (goal,) = problem.goals
    if not isinstance(goal, JointPositions):
        raise TypeError("the goal must be joint positions")
    wanted = np.array([goal.positions[name] for name in problem.reduced.joint_names])
    return float((np.abs(wanted - problem.reduced.start_positions) / problem.limits.velocity).max())


def why_not(problem: to.Problem, crossing: Crossing) -> str | None:
    """Return why a problem is not answerable; None if it is.

    Args:
        problem: The still problem.
        crossing: The box.
    """
    touched, least = first_touch(problem, crossing), least_time(problem)
    if touched is None or touched >= least:
        return None
    return (
        f"the box touches a link that no joint moves at {touched:.3f} s, and no motion is over before "
        f"{least:.3f} s"
    )


def not_askable(file: Path = FILE) -> dict[str, str]:
    """Read the reasons of unanswerable problems, by key."""
    return json.loads(file.read_text())


def main() -> None:
    """Examine all problems and write the unanswerable ones."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    boxes, found = crossings(), dict[str, str]()
    for robot in ROBOTS:
        for key, item in instances(given.data, robot).items():
            if key in boxes and (reason := why_not(item.make(), boxes[key])) is not None:
                found[key] = reason
    given.out.write_text(json.dumps(found, indent=1) + "\n")
    print(f"{len(found)} of {len(boxes)} cannot be asked: {given.out}")


if __name__ == "__main__":
    main()
