"""Goals of which nearly every configuration collides: the search must not give up on the rest."""

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.kinematics import inverse as inverse_kinematics

JOINTS = (-0.344, -0.122, -0.624, 1.287, -0.106, 1.146, 0.0)


@pytest.fixture(scope="module")
def crowded() -> to.Problem:
    """An xArm7 reaches over a panel to grasp a bar wherever along it: one solution in two hundred is free."""
    try:
        arm = to.load("xarm7")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    scene = (
        to.Scene(arm)
        .add("bar", to.Cylinder(0.01, 0.6), to.placement((0.486, 0.123, 0.359), rpy=(np.pi / 2, 0.0, -0.018)))
        .add("panel", to.Box(0.02, 0.5, 0.5), to.placement((-0.15, 0.05, 0.153)), frame="bar")
    )
    along = to.frame_placement(
        "link_eef",
        to.placement((0.0, 0.06, 0.0)),
        reference="bar",
        position_tolerance=(5e-3, 5e-3, 0.25),
        rotation_tolerance=np.inf,
    )
    over = to.axis_alignment("link_eef", direction=(0.0, -1.0, 0.0), reference="bar", tolerance=0.3)
    start = {f"joint{count}": value for count, value in enumerate(JOINTS, start=1)}
    return to.Problem(scene=scene, start=start, goal=(along, over))


def found(problem: to.Problem) -> int:
    """Of twenty searches, how many find a free configuration."""
    return sum(
        len(to.goal_configurations(problem, rng=np.random.default_rng(seed))) > 0 for seed in range(20)
    )


def test_searches_around_the_least_colliding_solutions(
    crowded: to.Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert found(crowded) >= 18
    monkeypatch.setattr(inverse_kinematics, "PUSHES", 0)
    assert found(crowded) <= 16, "no test any more: without looking around as much is found"


def test_found_configurations_are_free_and_fulfil_the_goal(crowded: to.Problem) -> None:
    (first, *_) = to.goal_configurations(crowded)
    assert to.examine(crowded.reduced, first).clear
