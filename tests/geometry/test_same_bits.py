"""Distances are the same to the last bit, whatever a process has measured before."""

import subprocess
import sys
from pathlib import Path

import numpy as np

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query
from trajopt.scene.reducing import reduce_model

ROOT = Path(__file__).parents[2]
CODE = "from pathlib import Path; from tests.geometry.test_same_bits import {}; {}"


def penetrate() -> None:
    """Measure an arm deep inside a box: another first contact of a box."""
    robot = to.load("ur5")
    where = to.placement((0.2, 0.1, 0.0), rpy=(0.3, 0.2, 0.5))
    scene = to.Scene(robot).add("box", to.Box(1.4, 0.04, 3.0), where)
    start = dict.fromkeys(robot.group("manipulator").joints, 0.4)
    reduced = reduce_model(scene, "manipulator", robot.positions(start))
    found = Query(reduced).close_pairs(reduced.start_positions[None], reduced.pairs.margin)
    assert found.distance.min() < -0.01


def digest(folder: Path) -> str:
    """Measure boxes beside a box, and return all bits."""
    robot = odd_arm(folder)
    scene = to.Scene(robot).add("wall", to.Box(1.0, 0.02, 2.0), to.placement((1.05, 0.0, 0.3)))
    reduced = reduce_model(scene, "all", robot.positions())
    positions = np.random.default_rng(0).uniform(-1.0, 1.0, (40, 4))
    found = Query(reduced).close_pairs(positions, np.full(len(reduced.pairs.margin), 1.0))
    order = np.lexsort((found.pair, found.sample))
    return np.stack((found.distance[order], *found.normal[order].T)).tobytes().hex()


def said(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_results_do_not_depend_on_the_first_query_of_a_process(tmp_path: Path) -> None:
    """Coal keeps for all later boxes how it rounds the first one's edges."""
    measured = f"print(digest(Path({str(tmp_path)!r})))"
    fresh = said(CODE.format("digest", measured))
    after = said(CODE.format("digest, penetrate", f"penetrate(); {measured}"))
    assert len(fresh) > 100 and fresh == after
    assert fresh.strip() == digest(tmp_path)
