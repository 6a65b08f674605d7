"""The question whether a motion is still proven after one object among 20 has moved.

python -m benchmarks.standing [--scenes 200] [--page FILE]

A Panda's motion past a pillar, among 20 boxes; a box moves to a random place in the room. Compared are
`StandingMotion.proven_in` and `judge`, with CPU time in one thread.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.files.proof import StandingMotion

SEED = 20261127
BOXES = 20


def room(drawn: np.random.Generator) -> to.Scene:
    """Return a Panda among boxes, one of them near."""
    scene = to.Scene(to.load("panda"))
    for number in range(BOXES):
        angle, distance = drawn.uniform(-np.pi, np.pi), drawn.uniform(0.9, 1.4)
        where = (distance * np.cos(angle), distance * np.sin(angle), drawn.uniform(0.1, 1.0))
        scene = scene.add(f"box {number}", to.Box(0.1, 0.15, 0.2), to.placement(where))
    return scene


def timed(ask: Callable[[], bool]) -> tuple[bool, float]:
    begin = time.process_time()
    return ask(), time.process_time() - begin


def main() -> None:
    """Measure, print, and write a section of a page."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("--scenes", type=int, default=200)
    options.add_argument("--page", type=Path)
    given = options.parse_args()
    drawn = np.random.default_rng(SEED)
    scene = room(drawn)
    start, goal = [0.0, -0.6, 0.0, -2.2, 0.0, 1.7, 0.8], [1.2, -0.2, 0.2, -1.8, 0.1, 1.8, 0.8]
    joints = dict(zip(scene.robot.joint_names[:7], goal, strict=True))
    problem = to.Problem(
        scene=scene, group="panda_arm", start=start, goal=to.joint_positions(joints), name="room"
    )
    plan = to.plan(problem).require()
    standing = StandingMotion(problem, plan.trajectory)
    found: dict[str, list[tuple[float, float, bool]]] = {"proven": [], "refuted": []}
    for _ in range(given.scenes):
        where = (*drawn.uniform(-0.9, 0.9, 2), drawn.uniform(0.1, 1.0))
        moved = scene.move(f"box {drawn.integers(BOXES)}", to.placement(where))
        answer, quick = timed(lambda moved=moved: standing.proven_in(moved))
        again, slow = timed(
            lambda moved=moved: to.judge(replace(problem, scene=moved), plan.trajectory).verified
        )
        found["proven" if again else "refuted"].append((1000.0 * quick, 1000.0 * slow, answer == again))
    rows = [row(name, values) for name, values in found.items()]
    text = table(("answer", "scenes", "equal answers", "by moved pairs ms", "judged again ms", "ratio"), rows)
    print(text)
    if given.page is not None:
        write_section(given.page, "standing", text)


def row(name: str, values: list[tuple[float, float, bool]]) -> tuple[str, ...]:
    """Return medians and 90th percentiles."""
    quick, slow, equal = (np.array(column) for column in zip(*values, strict=True))
    sides = (f"{np.median(each):.2f} / {np.percentile(each, 90):.2f}" for each in (quick, slow))
    return (
        name,
        str(len(values)),
        str(int(equal.sum())),
        *sides,
        f"{np.median(slow) / np.median(quick):.0f}",
    )


if __name__ == "__main__":
    main()
