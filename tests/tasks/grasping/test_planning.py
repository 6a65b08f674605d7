"""Picking and placing, planned: each stage in its own scene, judged; candidates in order; refusals."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.kinematics import forward_kinematics
from trajopt.planning import Certainty, Status
from trajopt.tasks.grasping import (
    Grasp,
    GraspingOptions,
    Gripper,
    PickPlaceResult,
    Place,
    Stage,
    Straight,
    grasps_of,
    gripper_of,
    pick,
    pick_and_place,
    place,
)
from trajopt.values.errors import FrameNotFound, ObjectNotFound, PlanningFailed, ProblemError, ShapeError

from .conftest import BLOCK, FUNCTIONS, STOOD, drawn, on_table


@pytest.fixture(scope="module")
def carried(panda: to.Robot, gripper: Gripper) -> PickPlaceResult:
    scene = on_table(panda, BLOCK, STOOD)
    grasps = grasps_of(scene, "thing", gripper)
    upright = to.axis_alignment("thing", direction=(0.0, 0.0, 1.0), tolerance=0.1)
    return pick_and_place(
        scene,
        "thing",
        start="ready",
        grasps=grasps,
        places=Place(placement=FUNCTIONS),
        constraints=[upright],
    )


def test_all_stages_are_planned_and_judged(carried: PickPlaceResult) -> None:
    assert carried.verified, carried.explain()
    assert [segment.stage for segment in carried.segments] == list(Stage)
    assert carried.failed == ""
    assert len(str(carried.explain()).splitlines()) == 2 + len(Stage)
    assert carried.timeline.gap < 1e-12
    assert carried.timeline.duration == pytest.approx(sum(s.duration for s in carried.segments))
    np.testing.assert_allclose(carried.timeline(0.0), carried.start, atol=1e-12)
    np.testing.assert_allclose(
        carried.timeline(carried.timeline.duration), carried.final_positions, atol=1e-12
    )


def test_the_object_rests_then_is_carried_then_rests(carried: PickPlaceResult) -> None:
    for segment in carried.segments:
        frame = segment.scene.object("thing").frame
        assert frame == (carried.gripper.tool if segment.stage.holds else "world"), segment.stage
    final = carried.final_scene
    assert final.object("thing").frame == "world"
    assert final.allowances == () and final.pair_margins == {}
    placed = final.placement_of("thing", carried.final_positions)
    assert np.abs(Place(placement=FUNCTIONS).error(placed, to.placement())).max() < 1e-3


def test_the_object_is_where_it_was_between_stages(carried: PickPlaceResult) -> None:
    for before, after in zip(carried.segments[:-1], carried.segments[1:], strict=True):
        was = before.scene.placement_of("thing", before.end)
        now = after.scene.placement_of("thing", after.positions(0.0))
        assert np.abs(was.homogeneous - now.homogeneous).max() < 1e-12
    final = carried.final_scene.placement_of("thing", carried.final_positions)
    last = carried.segments[-1]
    assert np.abs(last.scene.placement_of("thing", last.end).homogeneous - final.homogeneous).max() < 1e-12


def test_the_object_that_is_picked_is_in_the_hand_as_the_motion_takes_it(
    panda: to.Robot, gripper: Gripper
) -> None:
    scene = on_table(panda, to.Cylinder(0.03, 0.1), STOOD)
    taken = pick(scene, "thing", start="ready", grasps=grasps_of(scene, "thing", gripper))
    lift = taken.segment(Stage.LIFT)
    assert lift is not None
    stood, held = scene.placement_of("thing", taken.start), taken.final_scene
    assert held.allowances == ()
    there = held.placement_of("thing", lift.positions(0.0))
    assert np.abs(there.homogeneous - stood.homogeneous).max() < 1e-12
    lifted = held.placement_of("thing", taken.final_positions)
    assert np.abs(lifted.homogeneous - lift.scene.placement_of("thing", lift.end).homogeneous).max() < 1e-12


@pytest.mark.parametrize(
    ("stage", "direction"),
    [
        (Stage.APPROACH, (0.0, 0.0, -1.0)),
        (Stage.LIFT, (0.0, 0.0, 1.0)),
        (Stage.LOWER, (0.0, 0.0, -1.0)),
        (Stage.RETREAT, (0.0, 0.0, 1.0)),
    ],
)
def test_straight_stages_are_straight(
    carried: PickPlaceResult, stage: Stage, direction: tuple[float, float, float]
) -> None:
    segment = carried.segment(stage)
    assert segment is not None
    times = np.linspace(0.0, segment.trajectory.duration, 41)
    tools = [segment.scene.placement_of(carried.gripper.tool, segment.positions(float(t))) for t in times]
    way = np.array([tool.translation - tools[0].translation for tool in tools])
    along = way @ direction
    assert along[-1] == pytest.approx(0.1, abs=1e-3)
    assert np.linalg.norm(way - along[:, None] * np.array(direction), axis=1).max() < 3e-3
    assert max(np.abs(tool.rotation - tools[0].rotation).max() for tool in tools) < 0.03


def test_constraints_hold_only_while_the_object_is_held(carried: PickPlaceResult) -> None:
    for segment in carried.segments:
        asked = [
            item for item in segment.result.problem.constraints if "thing" in getattr(item, "frames", ())
        ]
        assert len(asked) == int(segment.stage.holds), segment.stage
        if segment.stage.holds:
            for t in np.linspace(0.0, segment.trajectory.duration, 21):
                thing = segment.scene.placement_of("thing", segment.positions(float(t)))
                assert np.arccos(min(thing.rotation[2, 2], 1.0)) < 0.1


def test_tool_speed_holds_in_every_motion_of_the_arm(panda: to.Robot, gripper: Gripper) -> None:
    scene = on_table(panda, BLOCK, STOOD)
    slow = GraspingOptions(tool_speed=to.tool_speed("panda_hand_tcp", linear=0.2))
    picked = pick(scene, "thing", start="ready", grasps=grasps_of(scene, "thing", gripper), options=slow)
    assert picked.verified, picked.explain()
    for segment in picked.segments:
        problem, motion = segment.result.problem, segment.trajectory
        times = np.linspace(0.0, motion.duration, 200)
        placed = forward_kinematics(problem.reduced, "panda_hand_tcp", motion(times))
        speeds = np.linalg.norm(np.gradient(placed.translation, times, axis=0), axis=1)
        assert speeds.max() < 0.2 * 1.01, segment.stage


def test_fingers_keep_clear_until_they_close(carried: PickPlaceResult) -> None:
    """The approach is proven clear of the object; only closing and letting go may touch it."""
    for segment in carried.segments:
        for finger in carried.gripper.fingers:
            may = segment.scene.may_touch(finger, "thing")
            assert may == (segment.stage in {Stage.CLOSE, Stage.RELEASE} or segment.stage.holds)
    assert {s.stage: s.scene.may_touch("thing", "table") for s in carried.segments}[Stage.CARRY] is False


def test_fingers_open_and_close_to_the_widths_of_the_grasp(panda: to.Robot, carried: PickPlaceResult) -> None:
    grasp, gripper = carried.grasp, carried.gripper
    assert grasp is not None
    for stage, opening in (
        (Stage.OPEN, grasp.opening),
        (Stage.CLOSE, grasp.width),
        (Stage.RELEASE, grasp.opening),
    ):
        segment = carried.segment(stage)
        assert segment is not None
        assert gripper.opening_at(panda, segment.end) == pytest.approx(opening, abs=2e-4)


def test_the_answer_is_the_same_every_time(
    panda: to.Robot, gripper: Gripper, carried: PickPlaceResult
) -> None:
    again = pick_and_place(
        carried.scene,
        "thing",
        start=carried.start,
        grasps=grasps_of(carried.scene, "thing", gripper),
        places=Place(placement=FUNCTIONS),
        constraints=[to.axis_alignment("thing", direction=(0.0, 0.0, 1.0), tolerance=0.1)],
    )
    assert again.timeline.duration == carried.timeline.duration
    np.testing.assert_array_equal(again.final_positions, carried.final_positions)


def test_pick_then_place_joins(panda: to.Robot, gripper: Gripper) -> None:
    scene = on_table(panda, to.Cylinder(0.03, 0.1), STOOD)
    taken = pick(scene, "thing", start="ready", grasps=grasps_of(scene, "thing", gripper))
    assert [segment.stage for segment in taken.segments][-1] is Stage.LIFT
    assert taken.place is None
    assert taken.final_scene.holder("thing").link != "world"
    put = place(
        taken.final_scene,
        "thing",
        start=taken.final_positions,
        # A cylinder may turn about its axis.
        places=Place(placement=FUNCTIONS, rotation_tolerance=(1e-3, 1e-3, np.inf)),
    )
    assert [segment.stage for segment in put.segments] == [
        Stage.CARRY,
        Stage.LOWER,
        Stage.RELEASE,
        Stage.RETREAT,
    ]
    np.testing.assert_allclose(put.timeline(0.0), taken.final_positions, atol=1e-12)
    assert put.final_scene.object("thing").touch_links == frozenset()


def test_an_object_in_a_shelf_is_grasped_from_the_side(panda: to.Robot, gripper: Gripper) -> None:
    board = to.Box(0.3, 0.6, 0.02)
    boards = [(board, to.placement((0.0, 0.0, height))) for height in (0.01, 0.36)]
    can = to.placement((0.55, 0.0, 0.23))
    scene = on_table(panda, to.Cylinder(0.03, 0.12), can).add("shelf", boards, to.placement((0.6, 0.0, 0.15)))
    place_on_table = Place(placement=to.placement((0.4, 0.35, 0.06)))
    # From above without, then with, a board in the way.
    above, beside = (
        [grasp for grasp in grasps_of(scene, "thing", gripper) if ("side" in grasp.name) is side]
        for side in (False, True)
    )
    found = pick_and_place(scene, "thing", start="ready", grasps=[above[0], *beside], places=place_on_table)
    assert found.verified, found.explain()
    assert found.grasp is not None and "side" in found.grasp.name
    assert found.refusals[0].names.grasp == above[0].name
    assert "shelf" in found.refusals[0].reason


def test_the_first_place_that_works_is_taken(panda: to.Robot, gripper: Gripper) -> None:
    scene = on_table(panda, BLOCK, STOOD).add("stand", to.Box(0.1, 0.1, 0.2), to.placement((0.5, 0.2, 0.1)))
    grasps = grasps_of(scene, "thing", gripper)[:2]
    found = pick_and_place(
        scene,
        "thing",
        start="ready",
        grasps=grasps,
        places=[
            Place(placement=to.placement((1.5, 0.0, 0.05)), name="far"),
            Place(placement=to.placement((0.5, 0.2, 0.1)), name="inside"),
            Place(placement=to.placement((0.0, 0.0, 0.15)), frame="stand", name="on the stand"),
        ],
    )
    assert found.place is not None and found.place.name == "on the stand"
    assert [(refusal.names.place, refusal.stage) for refusal in found.refusals] == [
        ("far", "place thing: lower"),
        ("inside", "place thing: lower"),
    ]
    assert "stand" in found.refusals[1].reason


def test_a_start_that_no_motion_leaves_is_the_reason(panda: to.Robot, gripper: Gripper) -> None:
    scene = on_table(panda, BLOCK, STOOD)
    elbow = scene.placement_of("panda_link4", panda.positions("ready"))
    scene = scene.add("post", to.Sphere(0.08), elbow)
    grasps = grasps_of(scene, "thing", gripper)
    sideways = to.placement(rpy=(np.pi / 2.0, 0.0, 0.0)) * grasps[0].placement
    found = pick(
        scene, "thing", start="ready", grasps=[replace(grasps[0], placement=sideways, name="low"), *grasps]
    )
    assert found.status is Status.START_IN_COLLISION and len(found.refusals) == 1
    assert "post" in found.reason and found.explain().certainty is Certainty.PROVEN


def test_an_object_out_of_reach_is_refused_by_its_distance(panda: to.Robot, gripper: Gripper) -> None:
    scene = on_table(panda, BLOCK, to.placement((2.5, 0.0, 0.1)))
    grasps = grasps_of(scene, "thing", gripper)
    found = pick(scene, "thing", start="ready", grasps=grasps)
    assert len(found.refusals) == len(grasps) and "too short" in found.reason
    assert not found.counts, "no search for what is proven impossible"


def test_explains_why_no_path_exists(panda: to.Robot, gripper: Gripper) -> None:
    scene = on_table(panda, BLOCK, STOOD)
    first, second = grasps_of(scene, "thing", gripper)[:2]
    below = to.placement(rpy=(np.pi, 0.0, 0.0)) * first.placement
    found = pick_and_place(
        scene,
        "thing",
        start="ready",
        grasps=[
            replace(first, opening=0.2, name="wide"),
            replace(first, force=500.0, name="strong"),
            replace(first, placement=below, name="from below"),
            replace(second, approach=Straight(5.0), name="from far"),
            replace(second, lift=Straight(0.1, direction=(0.0, 0.0, -1.0)), name="downwards"),
            second,
        ],
        places=Place(placement=to.placement((0.5, 0.25, -0.02))),
    )
    assert not found.verified
    assert found.segments == () and found.grasp is None and found.final_scene is scene
    assert found.failed == "place thing: lower"
    reasons = {}
    for refusal in found.refusals:
        reasons.setdefault(refusal.names.grasp, (refusal.stage, refusal.reason))
    assert reasons["wide"][0] == "pick thing: open" and "200.0 mm" in reasons["wide"][1]
    assert reasons["strong"][0] == "pick thing: open" and "500 N" in reasons["strong"][1]
    assert reasons["from below"][0] == "pick thing: reach"
    assert "is inside table" in reasons["from below"][1]
    assert reasons["from far"][0] == "pick thing: approach" and "along the line" in reasons["from far"][1]
    assert reasons["downwards"][0] == "pick thing: lift" and "table" in reasons["downwards"][1]
    assert reasons[second.name][0] == "place thing: lower" and "table" in reasons[second.name][1]
    assert found.causes[0].startswith("pick thing: open: wide: ") and found.causes[0].endswith(" (2 ways)")
    assert found.reason.startswith("GOAL_IN_COLLISION: place thing: lower: ")
    assert found.status is Status.GOAL_IN_COLLISION and found.explain().status is found.status
    with pytest.raises(PlanningFailed, match="place thing: lower"):
        found.require()


def test_a_full_hand_picks_nothing_else(panda: to.Robot, gripper: Gripper) -> None:
    scene = on_table(panda, BLOCK, STOOD).add(
        "lamp", to.Sphere(0.02), frame=gripper.tool, touch_links=["panda_hand"]
    )
    grasps = grasps_of(scene, "thing", gripper)
    scene = scene.add("other", to.Box(0.04, 0.04, 0.04), frame=gripper.tool, touch_links=gripper.links)
    found = pick(scene, "thing", start="ready", grasps=grasps)
    assert (
        found.reason
        == "GRIPPER_CANNOT: pick thing: the gripper holds 'other' already: place or detach it first"
    )
    assert [refusal.status for refusal in found.refusals] == [Status.GRIPPER_CANNOT]


def test_misuse_is_refused(panda: to.Robot, gripper: Gripper) -> None:
    scene = on_table(panda, BLOCK, STOOD)
    grasps = grasps_of(scene, "thing", gripper)
    there = Place(placement=FUNCTIONS)
    with pytest.raises(ObjectNotFound, match="did you mean 'thing'"):
        pick(scene, "thingy", start="ready", grasps=grasps)
    with pytest.raises(ProblemError, match="at least one grasp"):
        pick(scene, "thing", start="ready", grasps=[])
    with pytest.raises(ProblemError, match="at least one place"):
        pick_and_place(scene, "thing", start="ready", grasps=grasps, places=[])
    with pytest.raises(ProblemError, match="not in a hand"):
        place(scene, "thing", start="ready", places=there)
    held = scene.attach("thing", gripper.tool, placement=to.placement())
    with pytest.raises(ProblemError, match="in a hand already"):
        pick(held, "thing", start="ready", grasps=grasps)
    with pytest.raises(ShapeError, match="less than the object is wide"):
        Grasp(placement=to.placement(), width=0.05, opening=0.04)
    with pytest.raises(ProblemError, match="distance must be positive"):
        Straight(0.0)
    with pytest.raises(FrameNotFound, match="did you mean 'table'"):
        pick_and_place(scene, "thing", start="ready", grasps=grasps, places=replace(there, frame="tabel"))
    with pytest.raises(FrameNotFound, match="no frame named 'tool'"):
        pick(scene, "thing", start="ready", grasps=[replace(grasps[0], lift=Straight(frame="tool"))])
    with pytest.raises(ShapeError, match="contact_time"):
        GraspingOptions(contact_time=0.0)


def test_slow_pick_and_place_is_slow(panda: to.Robot, gripper: Gripper, carried: PickPlaceResult) -> None:
    found = pick_and_place(
        carried.scene,
        "thing",
        start="ready",
        grasps=grasps_of(carried.scene, "thing", gripper),
        places=Place(placement=FUNCTIONS),
        options=GraspingOptions(velocity_scaling=0.3, acceleration_scaling=0.1),
    )
    assert found.verified, found.explain()
    assert found.timeline.duration > 2.0 * carried.timeline.duration


def test_plain_data_holds_every_motion(carried: PickPlaceResult, tmp_path: Path) -> None:
    carried.write(tmp_path / "carried.json")
    read = json.loads((tmp_path / "carried.json").read_text())
    assert [item["name"] for item in read["stages"]] == [stage.name for stage in Stage]
    assert carried.grasp is not None and read["grasp"] == carried.grasp.name
    assert read["stages"][-1]["end"] == pytest.approx(carried.timeline.duration)
    assert read["segments"][-1]["points"]


@pytest.mark.parametrize("kind", ["straight", "grasp", "place", "grasps_of", "gripper_of", "pick"])
def test_spoilt_arguments_are_refused_in_words(panda: to.Robot, gripper: Gripper, kind: str) -> None:
    scene = on_table(panda, BLOCK, STOOD)
    grasp = grasps_of(scene, "thing", gripper)[0]
    function, given = {
        "straight": (Straight, {"distance": 0.1, "frame": "world"}),
        "grasp": (
            Grasp,
            {
                "placement": to.placement(),
                "width": 0.05,
                "opening": 0.07,
                "approach": Straight(),
                "lift": Straight(),
            },
        ),
        "place": (
            Place,
            {"placement": FUNCTIONS, "frame": "world", "position_tolerance": 0.01, "rotation_tolerance": 0.1},
        ),
        "grasps_of": (grasps_of, {"scene": scene, "name": "thing", "gripper": gripper, "reach": 0.03}),
        "gripper_of": (gripper_of, {"robot": panda, "end_effector": "hand", "tool": "panda_hand"}),
        "pick": (
            pick,
            {
                "scene": scene,
                "name": "thing",
                "start": "ready",
                "grasps": [grasp],
                "options": GraspingOptions(),
            },
        ),
    }[kind]
    for argument in given:
        for junk in (b"bytes", object(), 3 + 1j, float("nan"), [1, "a"]):
            with pytest.raises(to.TrajoptError, match=r".{10}"):
                function(**{**given, argument: junk})


@pytest.mark.slow
def test_most_random_objects_are_handled(panda: to.Robot, gripper: Gripper) -> None:
    solved = 0
    for seed in range(100, 140):
        scene, put = drawn(panda, np.random.default_rng(seed))
        grasps = grasps_of(scene, "thing", gripper)
        found = pick_and_place(scene, "thing", start="ready", grasps=grasps, places=Place(placement=put))
        solved += found.verified
    assert solved >= 39
