"""What the core keeps is let go with what keeps it."""

import gc
import sys
from pathlib import Path

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.query import query
from trajopt.query.dynamics import DynamicsQuery


def test_a_model_outlives_neither_its_cell_nor_its_dynamics(tmp_path: Path) -> None:
    scene, at = to.Scene(odd_arm(tmp_path)), {"pan": 0.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
    reduced = to.Problem(scene=scene, start=at, goal=to.joint_positions(at)).reduced
    model = reduced.model
    before = sys.getrefcount(model)
    for _ in range(3):
        kept = DynamicsQuery(reduced), query._cell(reduced)
        assert sys.getrefcount(model) > before
        del kept
        gc.collect()
        assert sys.getrefcount(model) == before
