"""What is printed is short and in the units that people speak in."""

import numpy as np
import pytest

import trajopt as to

INF = np.inf
AT = to.placement((0.41, 0.3, 0.14))


def test_a_placement() -> None:
    assert str(AT) == "(0.41, 0.3, 0.14) m"
    assert str(to.placement((0, 0, 1), rpy=(np.pi, 0, 0))) == "(0, 0, 1) m turned by rpy (180, 0, 0) deg"
    assert repr(AT).startswith("placement(xyz=")


@pytest.mark.parametrize(
    ("tolerances", "said"),
    [
        ({}, "within 0.1 mm and 0.0573 deg"),
        (
            {"position_tolerance": 1e-3, "rotation_tolerance": (np.deg2rad(5), np.deg2rad(5), INF)},
            "within 1 mm and 5 deg, free about z",
        ),
        (
            {"position_tolerance": (INF, 1e-3, 2e-3), "rotation_tolerance": INF},
            "within y 1, z 2 mm, free along x, free about x, y, z",
        ),
    ],
)
def test_a_frame_at_a_placement(tolerances: dict[str, object], said: str) -> None:
    goal = to.frame_placement("cup", AT, **tolerances)  # type: ignore[arg-type]
    assert str(goal) == f"cup at (0.41, 0.3, 0.14) m, {said}"
    seen = to.frame_placement("cup", AT, reference="tray")
    assert str(seen).startswith("cup at (0.41, 0.3, 0.14) m from tray, ")


def test_a_problem_says_its_goal_so() -> None:
    robot = to.load("planar2")
    goal = to.frame_placement(robot.links[-1], AT)
    problem = to.Problem(scene=to.Scene(robot), start={}, goal=goal)
    assert f"at the end   {goal}" in str(problem)
