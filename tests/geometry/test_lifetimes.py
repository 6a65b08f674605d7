"""What the core keeps is let go with what keeps it."""

import gc
import sys
from pathlib import Path
from weakref import ref

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry import query
from trajopt.geometry.dynamics import DynamicsQuery


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


def test_a_scene_with_dynamic_obstacles_is_freed_with_its_plans(tmp_path: Path) -> None:
    """Whoever watches a world that moves has another scene each time that he sees it."""
    robot, at = odd_arm(tmp_path), {"pan": 0.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}

    def planned() -> ref[to.Scene]:
        track = to.Track.constant_velocity(to.placement((0.0, 9.0, 0.0)), (0.0, 0.1, 0.0))
        scene = to.Scene(robot).add("ball", to.Sphere(0.1), motion=to.Prediction(track, (0.01, 0.0, 0.0)))
        result = to.plan(to.Problem(scene=scene, start=at, goal=to.joint_positions({**at, "pan": 0.3})))
        assert result.verified
        return ref(scene)

    seen = [planned() for _ in range(3)]
    gc.collect()
    assert [scene() for scene in seen] == [None, None, None]
