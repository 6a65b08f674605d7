"""Picking and placing among what moves: each stage meets it at its time in the sequence."""

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.kinematics import reduce_model, validity
from trajopt.tasks.grasping import Gripper, PickPlaceResult, Place, Stage, grasps_of, pick, pick_and_place
from trajopt.values.errors import ProblemError

from .conftest import BLOCK, FUNCTIONS, STOOD, on_table

FAR = np.array((0.0, 0.0, 1.2))
EVERY = 0.01
"""Between two looks of a test [s]."""


def _met(result: PickPlaceResult, track: to.Track) -> bool:
    """Whether a ball on a track touches anything in the sequence, by a still scene for each look."""
    line, met = result.timeline, False
    for time in np.arange(0.0, line.duration, EVERY).tolist():
        segment = line.segments[line.segment_at(time)]
        still = segment.scene.remove("ball") if "ball" in segment.scene.objects else segment.scene
        at = line(time)
        reduced = reduce_model(still.add("ball", to.Sphere(0.05), track.at(time)), result.group, at)
        joints = still.robot.index(still.robot.group(result.group).joints)
        touching = validity(reduced, at[joints]).examination.collisions
        met |= any("ball" in (pair.first, pair.second) for pair in touching)
    return met


def test_moving_objects_are_met_at_the_time_of_each_stage(panda: to.Robot, gripper: Gripper) -> None:
    """A ball falls through where the hand would be in the middle of carrying."""
    still = on_table(panda, BLOCK, STOOD)
    grasps, places = grasps_of(still, "thing", gripper), Place(placement=FUNCTIONS)
    alone = pick_and_place(still, "thing", start="ready", grasps=grasps, places=places)
    carry = next(k for k, item in enumerate(alone.segments) if item.stage is Stage.CARRY)
    then = float(alone.timeline.begins[carry]) + 0.5 * alone.segments[carry].duration
    there = still.placement_of(gripper.tool, alone.timeline(then)).translation
    fall = to.Track.through([then - 1.0, then + 1.0], [to.placement(there + FAR), to.placement(there - FAR)])
    assert _met(alone, fall)
    moving = still.add("ball", to.Sphere(0.05), motion=fall)
    among = pick_and_place(moving, "thing", start="ready", grasps=grasps, places=places)
    assert among.verified, among.explain()
    assert not _met(among, fall)
    lasts = among.timeline.duration
    ball = among.final_scene.object("ball").timing.motion
    assert ball is not None
    np.testing.assert_allclose(ball.track.at(0.0).translation, fall.at(lasts).translation, atol=1e-12)


def test_the_hand_is_clear_while_the_fingers_press(panda: to.Robot, gripper: Gripper) -> None:
    """The rest at the end of closing is asked for as a stay at the goal."""
    still = on_table(panda, BLOCK, STOOD)
    far = to.Track.constant_velocity(to.placement((2.0, 2.0, 0.5)), (0.1, 0.0, 0.0))
    scene = still.add("cart", to.Box(0.1, 0.1, 0.1), motion=far)
    result = pick(scene, "thing", start="ready", grasps=grasps_of(still, "thing", gripper))
    closing = result.segment(Stage.CLOSE)
    assert closing is not None and closing.rest > 0.0
    assert closing.result.problem.dwell == closing.rest


def test_only_objects_at_rest_are_picked_and_placed(panda: to.Robot, gripper: Gripper) -> None:
    still = on_table(panda, BLOCK, STOOD)
    grasps = grasps_of(still, "thing", gripper)
    belt = to.Track.constant_velocity(STOOD, (0.0, 0.1, 0.0))
    moving = still.remove("thing").add("thing", BLOCK, motion=belt, mass=0.3)
    with pytest.raises(ProblemError, match="'thing' moves by itself"):
        pick(moving, "thing", start="ready", grasps=grasps)
    scene = still.add("tray", to.Box(0.1, 0.1, 0.01), motion=belt)
    tray = Place(placement=to.placement((0.0, 0.0, 0.06)), frame="tray")
    with pytest.raises(ProblemError, match="is on 'tray', which moves by itself"):
        pick_and_place(scene, "thing", start="ready", grasps=grasps, places=tray)
