"""What is said of a required clearance that stands in the way: reasons, remedies and prices name it."""

from pathlib import Path

import pytest

import trajopt as to
from tests.verify.arms import joint, link, robot
from tests.why.test_remedies import remedied

RADIUS = 0.05
START, GOAL = {"x": -0.5}, {"x": 0.5}
BETWEEN = {"required clearance between ball and person", "required clearance between person and ball"}


def passing(folder: Path, gap: float, *, axes: str = "x") -> to.Scene:
    """A ball on one slide or two; on the straight line it passes a person's sphere at this gap [m]."""
    links = ["base", *(f"{axis}_link" for axis in axes)]
    directions = {"x": "1 0 0", "y": "0 1 0"}
    arm = robot(
        folder,
        *(link(name) for name in links),
        *(
            joint(axis, parent, child, kind="prismatic", axis=directions[axis])
            for axis, parent, child in zip(axes, links, links[1:], strict=False)
        ),
    )
    scene = to.Scene(arm, margin=0.002).add(
        "ball", to.Sphere(RADIUS), frame=links[-1], touch_links=links[-1:]
    )
    return scene.add("person", to.Sphere(0.1), to.placement((0.0, RADIUS + 0.1 + gap, 0.0)))


def problem(scene: to.Scene) -> to.Problem:
    return to.Problem(scene=scene, start=START, goal=to.joint_positions(GOAL))


def test_a_clearance_that_cannot_be_kept_is_lowered_as_far_as_needed(tmp_path: Path) -> None:
    blocked = problem(passing(tmp_path, 0.025).with_clearance(0.03, "ball", "person"))
    result = to.plan(blocked)
    assert result.status is to.Status.PROVEN_INFEASIBLE
    assert "nearer than the required 30 mm" in result.message
    assert any("(30 mm required)" in block.words for block in result.explain().blocks)
    found = remedied(blocked)
    assert not any(what.startswith("margin") for what in found), "the clearance binds, not the margin"
    (remedy,) = (found[what] for what in found if what in BETWEEN)
    assert "lowered from 30 to" in remedy.words and 0.005 <= remedy.amount <= 0.011
    required = remedy.problem.scene.clearance_of("ball", "person")
    assert required == pytest.approx(0.03 - remedy.amount) and required <= 0.025
    clear = remedy.result.certificate
    assert clear is not None and clear.clearance >= required


def test_a_margin_gives_way_and_the_clearance_does_not(tmp_path: Path) -> None:
    blocked = problem(passing(tmp_path, 0.025).with_clearance(0.01).with_margin(0.05, "ball", "person"))
    result = to.plan(blocked)
    clear = result.require().certificate.clearance
    assert 0.01 <= clear <= 0.025
    assert "no motion keeps the margin of 50 mm between ball and person" in " ".join(result.remarks)


@pytest.mark.parametrize("end", ["start", "goal"])
def test_an_end_that_is_too_near_may_be_allowed_by_less_clearance(tmp_path: Path, end: str) -> None:
    scene = passing(tmp_path, 0.022, axes="xy").with_clearance(0.03, "ball", "person")
    near, far = {"x": 0.0, "y": 0.0}, {"x": -0.5, "y": 0.0}
    start, goal = (near, far) if end == "start" else (far, near)
    blocked = to.Problem(scene=scene, start=start, goal=to.joint_positions(goal))
    result = to.plan(blocked)
    collision = to.Status.START_IN_COLLISION if end == "start" else to.Status.GOAL_IN_COLLISION
    assert result.status is collision
    assert "22.0 mm from" in result.message and "30 mm are required" in result.message
    found = remedied(blocked)
    (remedy,) = (found[what] for what in found if what in BETWEEN)
    assert 0.008 <= remedy.amount < 0.0095 and "lowered from 30 to 21" in remedy.words


def test_the_price_of_a_required_clearance_names_it(tmp_path: Path) -> None:
    scene = passing(tmp_path, -0.02, axes="xy")
    ends = {"start": {"x": -0.5, "y": 0.0}, "goal": to.joint_positions({"x": 0.5, "y": 0.0})}
    for clear, margin, what in (
        (scene.with_clearance(0.03), 0.002, "required clearance between"),
        (scene.with_clearance(0.03), 0.06, "margin of"),
        (scene, 0.03, "margin of"),
    ):
        result = to.plan(to.Problem(scene=clear.with_margin(margin), **ends))
        (price,) = (item for item in result.explain().prices if "person" in item.what)
        assert price.what.startswith(what) and price.objective is not None and price.objective > 0.0
