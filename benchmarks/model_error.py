"""Robots that differ from their description: plans with a model error, and random robots within it.

python -m benchmarks.model_error DATA [--every K] [--robots N] [--page FILE]

Every K-th problem of MotionBenchMaker's sets is planned for the described robot, and for errors of 0.1
degrees in each joint and of 1 mm and 0.1 degrees in the mounting. Then N robots are drawn from the box, half
of them at its corners, and driven along the proven motions, measured every 0.02 rad with Coal.
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

import trajopt as to
from benchmarks.motion_bench_maker import problems
from benchmarks.page import table, write_section
from benchmarks.sections import TITLES
from trajopt.geometry import evaluator
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats

JOINTS, MOUNTING = float(np.deg2rad(0.1)), (1e-3, float(np.deg2rad(0.1)))
STEP = 0.02
"""Largest step of a joint between two measured configurations [rad | m]."""
HEAD = (
    "robot",
    "problems",
    "solved as described",
    "with the error",
    "CPU, median of ratios",
    "robots drawn",
    "touching",
)


def drawn(scene: to.Scene, rng: np.random.Generator) -> tuple[to.Scene, Floats]:
    """Return a robot of the box: the world as its root sees it, and the offset of each joint."""
    error = scene.model_error
    sizes = np.array([error.joints.get(name, 0.0) for name in scene.robot.joint_names])
    share = rng.choice((-1.0, 1.0), len(sizes)) if rng.random() < 0.5 else rng.uniform(-1.0, 1.0, len(sizes))
    turn, way = rng.normal(size=(2, 3))
    rotation = pin.exp3(turn / np.linalg.norm(turn) * error.turn)
    root = to.Placement(rotation, way / np.linalg.norm(way) * error.shift)
    for name, item in scene.objects.items():
        if item.frame == "world":
            scene = scene.move(name, root.inverse() * item.placement)
    return scene, share * sizes


def touches(problem: to.Problem, motion: to.Trajectory, rng: np.random.Generator) -> bool:
    """Return whether a robot of the box touches anything on a motion."""
    scene, offsets = drawn(problem.scene, rng)
    start = reduce_model(scene, problem.group, scene.robot.followed(problem.start_positions) + offsets)
    bare = replace(scene, model_error=problem.scene.with_model_error().model_error)
    reduced = reduce_model(bare, problem.group, start.start)
    places = [scene.robot.joint_names.index(name) for name in reduced.joint_names]
    travel = np.abs(np.diff(motion.positions, axis=0)).max(axis=1).sum()
    moments = np.linspace(0.0, motion.duration, 2 + int(travel / STEP))
    found = evaluator(reduced).close_pairs(
        motion(moments) + offsets[places], np.zeros(len(reduced.pairs.first))
    )
    return bool((found.distance < 0.0).any())


def row(name: str, data: Path, every: int, robots: int) -> tuple[str, ...]:
    """Measure the problems of a robot."""
    found = problems(data, name)
    if isinstance(found, to.TrajoptError):
        raise found
    solved, ratios, motions = [0, 0], list[float](), list[tuple[to.Problem, to.Trajectory]]()
    asked = [found[key] for key in sorted(found)][::every]
    to.plan(asked[0].make())
    for instance in asked:
        described = instance.make()
        wrong = replace(described, scene=described.scene.with_model_error(joints=JOINTS, mounting=MOUNTING))
        used: list[float] = []
        plans: list[to.Result] = []
        for turn, problem in enumerate((described, wrong)):
            begin = time.process_time()
            plans.append(to.plan(problem))
            used.append(time.process_time() - begin)
            solved[turn] += plans[turn].verified
        if plans[1].verified:
            ratios.append(used[1] / used[0])
            motions.append((wrong, plans[1].require().trajectory))
    rng = np.random.default_rng(0)
    count = sum(touches(*motions[number % len(motions)], rng) for number in range(robots))
    ratio = f"{np.median(ratios):.2f}"
    return (TITLES[name], str(len(asked)), *map(str, solved), ratio, str(robots), str(count))


def main() -> None:
    """Measure, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path, help="MotionBenchMaker's problems")
    parser.add_argument("--every", type=int, default=10)
    parser.add_argument("--robots", type=int, default=1000, help="drawn for each arm")
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    rows = [row(name, given.data, given.every, given.robots) for name in ("panda", "ur5", "fetch")]
    text = table(HEAD, rows)
    print(text)
    if given.page is not None:
        write_section(given.page, "model error", text)


if __name__ == "__main__":
    main()
