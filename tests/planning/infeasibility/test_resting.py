"""An object in the hand that still rests on something."""

import numpy as np
import pytest

import trajopt as to

FINGERS = ("panda_leftfinger", "panda_rightfinger")


@pytest.fixture(scope="module")
def grasped() -> tuple[to.Scene, to.Plan]:
    """A scene with a part on a table, and the motion that brings the hand to the part."""
    scene = (
        to.Scene(robot=to.load("panda"))
        .add("table", to.Box(0.6, 0.6, 0.1), to.placement((0.5, 0.0, 0.0)))
        .add("part", to.Box(0.04, 0.04, 0.1), to.placement((0.5, 0.1, 0.1)), touch_links=FINGERS)
    )
    goal = to.frame_placement(
        "panda_hand_tcp", to.placement((0.0, 0.0, 0.03), rpy=(np.pi, 0.0, 0.0)), reference="part"
    )
    return scene, to.plan(to.Problem(scene=scene, group="panda_arm", start="ready", goal=goal)).require()


def lifted(scene: to.Scene, pick: to.Plan) -> to.Result:
    return to.plan(to.Problem(scene=scene, group="panda_arm", start=pick, goal="ready"))


def test_names_the_support_where_a_carried_object_touches_it(grasped: tuple[to.Scene, to.Plan]) -> None:
    scene, pick = grasped
    result = lifted(scene.attach("part", "panda_hand_tcp", at=pick), pick)
    assert result.status is to.Status.START_IN_COLLISION
    assert "attach it with `resting_on='table'`" in result.reason


def test_resting_objects_are_lifted(grasped: tuple[to.Scene, to.Plan]) -> None:
    scene, pick = grasped
    held = scene.attach("part", "panda_hand_tcp", at=pick, resting_on="table")
    assert lifted(held, pick).verified


def test_gives_no_hint_for_deep_overlap(grasped: tuple[to.Scene, to.Plan]) -> None:
    scene, pick = grasped
    deeper = scene.move("table", to.placement((0.5, 0.0, 0.02))).attach("part", "panda_hand_tcp", at=pick)
    result = lifted(deeper, pick)
    assert result.status is to.Status.START_IN_COLLISION
    assert "resting_on" not in result.reason


def test_rejects_a_support_that_does_not_exist(grasped: tuple[to.Scene, to.Plan]) -> None:
    scene, pick = grasped
    with pytest.raises(to.errors.FrameNotFound, match=r"tabel.*table"):
        scene.attach("part", "panda_hand_tcp", at=pick, resting_on="tabel")


def test_lifts_a_part_off_a_moving_belt() -> None:
    conveyor = to.Track.constant_velocity(to.placement((0.5, -0.8, 0.1)), (0.0, 0.2, 0.0))
    belt = (
        to.Scene(robot=to.load("panda"))
        .add("belt", to.Box(0.3, 0.2, 0.02), motion=conveyor)
        .add("part", to.Box(0.04, 0.04, 0.1), to.placement((0.0, 0.0, 0.06)), frame="belt")
    )
    above = to.frame_placement(
        "panda_hand_tcp", to.placement((0.0, 0.0, 0.07), rpy=(np.pi, 0.0, 0.0)), reference="part"
    )
    pick = to.plan(to.Problem(scene=belt, group="panda_arm", start="ready", goal=above, dwell=0.5)).require()
    after = belt.at(pick.trajectory.duration)

    def lift(scene: to.Scene) -> to.Result:
        return to.plan(
            to.Problem(
                scene=scene,
                group="panda_arm",
                start=pick,
                start_velocity=pick.final_velocity,
                start_acceleration=pick.final_acceleration,
                goal="ready",
            )
        )

    refused = lift(after.attach("part", "panda_hand_tcp", at=pick, touch_links=FINGERS))
    assert "attach it with `resting_on='belt'`" in refused.reason
    held = after.attach("part", "panda_hand_tcp", at=pick, touch_links=FINGERS, resting_on="belt")
    assert lift(held).verified
