"""Random problems of robots that no constant was chosen for, from their URDF or xacro files alone.

python -m benchmarks.unseen_robots DESCRIPTION ... [--package-dir FOLDER ...] [--problems N] [--page FILE]

Each robot gets the SRDF that `trajopt srdf` proposes, and its first arm random starts and goals, free of
collision, among boxes around it.
"""

import argparse
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.lab.srdf import propose_srdf
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.verify import Judge

BOXES = 4
"""Number of boxes in each scene."""
EDGES = (0.12, 0.45)
"""Shortest and longest edge of a box, as shares of the arm's reach."""
DRAWN = 200
"""Configurations drawn for a free one; a scene in which none of them is free is left out."""
SAMPLED = 20
"""Configurations that measure the reach of an arm."""
HEAD = ("robot", "joints", "problems", "solved", "proven infeasible", "other answers", "CPU ms median / p90")


def loaded(description: Path, packages: Sequence[Path]) -> to.Robot:
    """Load a robot with the SRDF that is proposed for it."""
    bare = to.load(description, package_dirs=packages)
    with tempfile.TemporaryDirectory() as folder:
        srdf = Path(folder) / "proposed.srdf"
        srdf.write_text(propose_srdf(bare, rng=np.random.default_rng(0)).xml)
        return to.load(description, srdf=srdf, package_dirs=packages)


def drawn(robot: to.Robot, group: str, rng: np.random.Generator) -> Floats:
    """Draw positions of a group within its limits, at most a turn each."""
    limits = robot.limits.take(robot.index(robot.group(group).joints))
    return rng.uniform(np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi))


def around(robot: to.Robot, group: str, rng: np.random.Generator) -> to.Scene:
    """Return boxes around an arm, at random places within its reach."""
    scene, arm = to.Scene(robot), robot.group(group)
    base = scene.placement_of(robot.links[0], robot.positions()).translation
    postures = (dict(zip(arm.joints, drawn(robot, group, rng), strict=True)) for _ in range(SAMPLED))
    tips = [scene.placement_of(arm.tip, robot.positions(posture)) for posture in postures]
    reach = max(float(np.linalg.norm(tip.translation - base)) for tip in tips)
    for number in range(BOXES):
        where = base + reach * rng.uniform((-1.0, -1.0, 0.0), (1.0, 1.0, 1.0))
        scene = scene.add(f"box {number}", to.Box(*reach * rng.uniform(*EDGES, 3)), to.placement(where))
    return scene


def free(scene: to.Scene, group: str, rng: np.random.Generator) -> Floats | None:
    """Draw a configuration without a fault; None if there is none among many."""
    judge = Judge(reduce_model(scene, group, scene.robot.positions()))
    return next(
        (q for q in (drawn(scene.robot, group, rng) for _ in range(DRAWN)) if judge.examine(q).clear), None
    )


def problems(robot: to.Robot, group: str, count: int) -> Iterator[to.Problem]:
    """Yield problems with free ends, in scenes of their own."""
    for seed in range(count):
        rng = np.random.default_rng(seed)
        scene = around(robot, group, rng)
        start, goal = (free(scene, group, rng) for _ in range(2))
        if start is not None and goal is not None:
            yield to.Problem(scene=scene, group=group, start=start, goal=goal)


def measured(robot: to.Robot, count: int) -> tuple[str, ...]:
    """Plan the problems of a robot, and return its row of the table."""
    group = next(iter(robot.groups))
    answers, spent = Counter[str](), list[float]()
    for problem in problems(robot, group, count):
        begin = time.process_time()
        answers[to.plan(problem).status.name] += 1
        spent.append(1e3 * (time.process_time() - begin))
    total, solved, infeasible = answers.total(), answers.pop("SOLVED", 0), answers.pop("PROVEN_INFEASIBLE", 0)
    others = ", ".join(f"{number} {name}" for name, number in answers.most_common()) or "-"
    cpu = " / ".join(f"{np.percentile(spent, share):.0f}" for share in (50, 90)) if spent else "-"
    joints = len(robot.group(group).joints)
    return robot.name, f"{joints}", f"{total}", f"{solved}", f"{infeasible}", others, cpu


def main() -> None:
    """Measure the robots, print the table, and write it into a page if one is named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("descriptions", nargs="+", type=Path)
    parser.add_argument("--package-dir", action="append", type=Path, default=[])
    parser.add_argument("--problems", type=int, default=25)
    parser.add_argument("--page", type=Path)
    given = parser.parse_args()
    rows = [measured(loaded(each, given.package_dir), given.problems) for each in given.descriptions]
    text = table(HEAD, rows)
    print(text)
    if given.page is not None:
        write_section(given.page, "unseen-robots", text)


if __name__ == "__main__":
    main()
