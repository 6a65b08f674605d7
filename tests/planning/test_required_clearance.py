"""A required clearance is kept by planned motions, and what cannot keep it is refused by name."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.verify.arms import joint, link, robot
from trajopt.planning.status import Certainty

RADIUS = 0.05


def slide(folder: Path) -> to.Robot:
    """Two slides, along x and y."""
    return robot(
        folder,
        link("base"),
        link("rail"),
        link("hand"),
        joint("x", "base", "rail", kind="prismatic", axis="1 0 0"),
        joint("y", "rail", "hand", kind="prismatic", axis="0 1 0"),
    )


def ball_over_box(folder: Path, gap: float) -> to.Scene:
    """A ball on the slides, so far above a box at x = y = 0 [m]."""
    scene = to.Scene(slide(folder), margin=0.0)
    scene = scene.add("ball", to.Sphere(RADIUS), frame="hand", touch_links=["hand"])
    return scene.add("box", to.Box(0.2, 0.2, 0.2), to.placement((0.0, 0.0, -0.1 - RADIUS - gap)))


@pytest.mark.parametrize(
    ("gap", "required", "certainty"),
    [
        (1e-7, 0.0, Certainty.EVIDENCE),
        (9e-7, 0.0, Certainty.EVIDENCE),
        (-1e-7, 0.0, Certainty.EVIDENCE),
        (-1e-4, 0.0, Certainty.PROVEN),
        (0.02 + 1e-7, 0.02, Certainty.EVIDENCE),
        (0.02 - 1e-4, 0.02, Certainty.PROVEN),
    ],
)
def test_what_is_too_near_by_less_than_distances_err_is_not_proven(
    tmp_path: Path, gap: float, required: float, certainty: Certainty
) -> None:
    scene = ball_over_box(tmp_path, gap).with_clearance(required)
    away, there = {"x": 0.5, "y": 0.0}, {"x": 0.0, "y": 0.0}
    for start, goal, status in (
        (there, away, to.Status.START_IN_COLLISION),
        (away, there, to.Status.GOAL_IN_COLLISION),
    ):
        exactly = to.joint_positions(goal, tolerance=0.0)
        result = to.plan(to.Problem(scene=scene, start=start, goal=exactly))
        assert result.status is status and result.certainty is certainty
        explained = result.explain()
        assert explained.certainty is certainty
        assert ("less than the distance may err" in explained.grounds) == (certainty is Certainty.EVIDENCE)
        assert "0.0 mm inside" not in result.message


def test_a_start_more_than_a_micrometre_clear_is_no_collision(tmp_path: Path) -> None:
    problem = to.Problem(
        scene=ball_over_box(tmp_path, 1.1e-6), start={}, goal=to.joint_positions({"x": 0.5, "y": 0.0})
    )
    assert to.plan(problem).status is not to.Status.START_IN_COLLISION


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.array, int])
def test_meant_contact_takes_any_number(tmp_path: Path, kind: type) -> None:
    scene = ball_over_box(tmp_path, -5e-4)
    leaving = scene.allow_contact("lift off", "ball", "box", depth=kind(1), first=kind(1), last=kind(1))
    plain = scene.allow_contact("lift off", "ball", "box", depth=1.0, first=1.0, last=1.0)
    assert leaving.allowances == plain.allowances
    result = to.plan(to.Problem(scene=leaving, start={}, goal=to.joint_positions({"x": 0.5, "y": 0.0})))
    assert result.verified and result.certificate is not None
    assert any(check.name == "contact: lift off" for check in result.certificate.checks)
    assert type(leaving.with_margin(kind(0)).margin) is float
