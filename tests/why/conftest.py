"""A small arm and problems that it cannot solve."""

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm

START = {"pan": -1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
GOAL = {"pan": 1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}


@pytest.fixture(scope="session")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


@pytest.fixture(scope="session")
def pillar(arm: to.Robot) -> to.Scene:
    return to.Scene(arm).add("pillar", to.Cylinder(0.08, 1.0), to.placement((0.72, 0.0, 0.3)))


def tip_at(scene: to.Scene, joints: dict[str, float], **changes: object) -> to.Requirement:
    """Require the tip where joints put it, however turned."""
    where = scene.placement_of("tip", scene.robot.positions(joints))
    given = {"position_tolerance": 1e-3, "rotation_tolerance": np.inf, **changes}
    return to.frame_placement("tip", where, **given)  # pyright: ignore[reportArgumentType]
