"""Whole jobs: rests only where a stage needs one, choices, the state of the scene, and messages."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.files.bundle import read_bundle, read_result
from trajopt.files.export import export
from trajopt.optimise.kinematics.inverse import goal_candidates
from trajopt.planning import Certainty, Status
from trajopt.problem.requirements import Requirement
from trajopt.simulation import Friction
from trajopt.tasks import (
    AnyOrder,
    AttachObject,
    DetachObject,
    Dwell,
    Fallback,
    FollowCurve,
    MoveObject,
    MoveTo,
    OneOf,
    PickObject,
    PlaceObject,
    SetGripper,
    StageCost,
    StageLimits,
    Task,
    TaskResult,
    TaskStage,
    Within,
    joint_travel,
    least_clearance,
)
from trajopt.tasks.cartesian import Begin, FollowOptions, line, raster
from trajopt.tasks.grasping import Grasp, Place, Straight, grasps_of, gripper_of
from trajopt.tasks.grasping.simulation import Hold, simulate_handling, simulate_task
from trajopt.values.errors import FileFormatError, NameNotFound, PlanningFailed, ProblemError, ShapeError
from trajopt.viewer.report import write_report

LIMITED = StageLimits(joints={"panda_joint7": (-2.9, 0.9)})
DOWN = (np.pi, 0.0, 0.0)
ARM = tuple(f"panda_joint{number}" for number in range(1, 8))
READY = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)


def over(x: float, y: float, z: float = 0.3) -> to.Placement:
    return to.placement((x, y, z), rpy=DOWN)


def task(cell: to.Scene, *stages: TaskStage, start: str = "ready", **options: object) -> Task:
    return Task(scene=cell, group="panda_arm", start=start, stages=stages, **options)  # pyright: ignore


@pytest.fixture(scope="module")
def carried(cell: to.Scene, grasps: tuple[Grasp, ...]) -> TaskResult:
    place = Place(placement=to.placement((0.5, 0.25, 0.06)))
    stages = PickObject("cup", grasps), PlaceObject("cup", place), Dwell(0.25, name="wait"), MoveTo("ready")
    return to.plan(task(cell, *stages))


def test_moves_become_one_motion_and_rest_only_for_the_hand(carried: TaskResult) -> None:
    assert carried.verified, carried.explain()
    assert [segment.stages for segment in carried.segments] == [
        ("pick cup: open",),
        ("pick cup: reach", "pick cup: approach"),
        ("pick cup: close",),
        ("pick cup: lift", "place cup: carry", "place cup: lower"),
        ("place cup: release",),
        ("place cup: retreat",),
        ("move to ready",),
    ]
    moving = carried.segments[3].trajectory
    times = [end for _, end in carried.segments[3].ends[:-1]]
    assert (np.abs(moving(np.array(times), 1)).max(axis=1) > 0.05).all(), "it does not rest on the way"


def test_every_motion_is_proven_and_begins_where_the_last_one_ended(carried: TaskResult) -> None:
    at = carried.start
    for segment in carried.segments:
        assert segment.result.require().certificate.verified
        np.testing.assert_allclose(segment.positions(0.0), at, atol=1e-12)
        assert np.abs(segment.trajectory(segment.trajectory.duration, 1)).max() < 1e-9
        at = segment.end
    np.testing.assert_array_equal(at, carried.final_positions)


def test_the_stages_fill_the_time_of_the_task(carried: TaskResult) -> None:
    stages = carried.stages
    assert stages[0].begin == 0.0
    assert stages[-1].end == pytest.approx(carried.duration)
    for before, after in pairwise(stages):
        assert before.end == pytest.approx(after.begin)
    waited = next(stage for stage in stages if stage.name == "wait")
    assert waited.end - waited.begin == pytest.approx(0.25)
    assert "wait" in str(carried.explain())


def test_an_object_stays_upright_before_and_in_the_hand(cell: to.Scene, grasps: tuple[Grasp, ...]) -> None:
    upright = to.axis_alignment("cup", tolerance=0.2)
    place = Place(placement=to.placement((0.5, 0.25, 0.06)))
    stages = PickObject("cup", grasps), PlaceObject("cup", place)
    found = to.plan(task(cell, *stages, constraints=[upright]))
    assert found.verified, found.explain()


def test_stages_of_the_same_name_are_all_done(cell: to.Scene) -> None:
    spots = {"x": over(0.5, 0.2), "x (2)": over(0.5, -0.2)}
    stages = [MoveTo(spot, name=name) for name, spot in spots.items()]
    asked = task(cell, *stages, MoveTo(over(0.4, 0.0), name="x"), MoveTo("ready"))
    assert [stage.name for stage in asked.stages] == ["x", "x (2)", "x (3)", "move to ready"]
    whole = to.plan(asked).trajectory
    rows = whole(np.linspace(0.0, whole.duration, 2000))
    for spot in (*spots.values(), over(0.4, 0.0)):
        places = [cell.placement_of("panda_hand_tcp", row) for row in rows]
        assert min(np.linalg.norm(at.translation - spot.translation) for at in places) < 2e-3


def test_a_stage_must_not_have_the_name_of_a_step_of_another(
    cell: to.Scene, grasps: tuple[Grasp, ...]
) -> None:
    step = MoveTo(over(0.5, -0.2), name="pick cup: reach")
    with pytest.raises(ProblemError, match=r"'pick cup: reach'.* steps of stage 'pick cup'"):
        task(cell, step, PickObject("cup", grasps))


def test_the_trajectory_is_the_whole_task(carried: TaskResult, tmp_path: Path) -> None:
    whole, begin = carried.trajectory, 0.0
    assert whole.duration == pytest.approx(carried.duration)
    index = carried.scene.robot.index(whole.joint_names)
    for segment in carried.segments:
        for t in np.linspace(0.0, segment.duration, 7):
            np.testing.assert_allclose(whole(begin + t), segment.positions(t)[index], atol=1e-9)
        begin += segment.duration
    assert export(carried, tmp_path / "task.csv", to="csv").path.exists()
    assert json.loads(json.dumps(carried.as_dict()))["verified"] is True


@pytest.mark.parametrize("waits", [(), (0.001, 0.3)])
def test_a_robot_without_jerk_limits_rests_between_motions(waits: tuple[float, ...], tmp_path: Path) -> None:
    arm = odd_arm(tmp_path)
    marker = to.Scene(arm).add("marker", to.Box(0.1, 0.1, 0.1), to.placement((2.0, 0.0, 0.0)))
    moves = (MoveTo({"pan": 1.0, "reach": 0.2}), MoveObject("marker", to.placement((3.0, 0.0, 0.0))))
    stages = (*moves, MoveTo({"pan": 0.0}), *map(Dwell, waits), MoveTo({"elbow": 1.0}), Dwell(0.1))
    result = to.plan(Task(scene=marker, start={}, stages=stages))
    begin, whole = 0.0, result.trajectory
    assert whole.duration == pytest.approx(result.duration)
    for segment in result.segments:
        ends = begin + segment.trajectory.duration
        begin += segment.duration
        still = whole(np.linspace(ends, begin, 50))
        np.testing.assert_allclose(still, np.broadcast_to(still[0], still.shape), atol=1e-5)
        assert np.abs(whole(np.linspace(ends, begin, 50), 2)).max() <= arm.limits.acceleration.max() + 1e-6
    for before, after in pairwise(result.stages):
        assert before.end == pytest.approx(after.begin)


def test_a_task_is_read_as_it_was_written(carried: TaskResult, tmp_path: Path) -> None:
    carried.save(tmp_path / "task.trajopt")
    again = read_result(tmp_path / "task.trajopt")
    assert isinstance(again, TaskResult)
    assert again.stages == carried.stages
    assert again.certificate.verified
    np.testing.assert_array_equal(again.trajectory.positions, carried.trajectory.positions)
    assert again.handling("cup").grasp is not None
    with pytest.raises(FileFormatError, match="the result of several motions: read it with read_result"):
        read_bundle(tmp_path / "task.trajopt")
    carried.segments[0].result.save(tmp_path / "open.trajopt")
    with pytest.raises(FileFormatError, match="is a plan: read it with read_bundle"):
        read_result(tmp_path / "open.trajopt")


def test_a_motion_that_was_changed_in_the_file_is_refused(carried: TaskResult, tmp_path: Path) -> None:
    """Scaled to a hundredth of the time, the motion breaks its limits."""
    first = carried.segments[1]
    moved = first.trajectory
    fast = replace(moved, times=0.01 * moved.times)
    spoilt = replace(first, result=replace(first.result, timed=None, trajectory=fast))
    replace(carried, segments=(carried.segments[0], spoilt, *carried.segments[2:])).save(
        tmp_path / "x.trajopt"
    )
    with pytest.raises(FileFormatError, match="has a motion that is not proven"):
        read_result(tmp_path / "x.trajopt")


def test_a_file_without_its_last_motions_is_refused(
    carried: TaskResult, cell: to.Scene, tmp_path: Path
) -> None:
    moves = to.plan(task(cell, MoveTo("extended"), Dwell(0.1), MoveTo("ready")))
    for whole in (carried, moves):
        for count in (1, len(whole.segments) - 1):
            replace(whole, segments=whole.segments[:-count]).save(tmp_path / "x.trajopt")
            with pytest.raises(FileFormatError, match="has no motion of the stage"):
                read_result(tmp_path / "x.trajopt")


def test_motions_that_do_not_join_are_refused(carried: TaskResult) -> None:
    first, second, *others = carried.segments
    for broken in ((second, *others), (first, *others), (first, first, second, *others)):
        with pytest.raises(ShapeError, match=r"segments: motion \d begins .* away from the arm"):
            replace(carried, segments=broken)


def test_the_certificate_has_the_checks_of_all_motions_at_their_times(carried: TaskResult) -> None:
    whole = carried.certificate
    parts = [segment.result.require().certificate for segment in carried.segments]
    assert whole.verified
    assert len(whole.checks) == sum(len(part.checks) for part in parts)
    assert whole.clearance == min(part.clearance for part in parts)
    times = [check.time for check in whole.checks if check.time is not None]
    assert max(times) > carried.begins[-1]
    assert whole.checks[-1].name.startswith("move to ready: ")


def test_in_the_whole_the_object_moves_with_the_hand(carried: TaskResult, tmp_path: Path) -> None:
    reduced, trajectory = carried.whole
    motion = reduced.scene.object("cup").timing.motion
    assert motion is not None
    begin = carried.begins[3]
    for share in (0.2, 0.5, 0.8):
        since = share * carried.segments[3].trajectory.duration
        planned = carried.segments[3].scene.placement_of("cup", carried.segments[3].positions(since))
        there = motion.track.at(float(begin + since))
        assert np.linalg.norm(there.translation - planned.translation) < 1e-3
    assert trajectory.duration == pytest.approx(carried.duration)
    assert to.render(carried, tmp_path / "task.png", width=160, height=120).stat().st_size > 1000
    with pytest.raises(ProblemError, match="simulate: the result of several motions has its own trajectory"):
        to.simulate(carried, trajectory)  # pyright: ignore[reportCallIssue, reportArgumentType]


def test_a_report_has_the_cycle_times_and_the_proof(
    carried: TaskResult, cell: to.Scene, tmp_path: Path
) -> None:
    text = write_report(carried, tmp_path / "task.html", moving=False).read_text()
    assert all(stage.name in text for stage in carried.stages)
    assert "What was proven" in text
    failed = to.plan(task(cell, MoveTo(over(1.5, 0.0), name="too far")))
    assert "too far" in write_report(failed, tmp_path / "failed.html", moving=False).read_text()


def test_a_page_shows_each_motion_in_the_scene_of_its_time(carried: TaskResult) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    page = to.view(carried, port=8190)
    try:
        seen: list[int] = []
        for stage in carried.stages:
            page.show(0.5 * (stage.begin + stage.end))
            seen.append(page.motion)
        assert sorted(set(seen)) == list(range(len(carried.segments)))
    finally:
        page.close()


def test_page_and_report_have_the_cost_of_each_stage_and_the_rejected_ways(
    cell: to.Scene, tmp_path: Path
) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    below, near = MoveTo(over(0.5, 0.0, -0.2), name="below"), MoveTo(over(0.45, 0.1), name="near")
    found = to.plan(task(cell, Fallback([below, near]), Dwell(0.5, name="<wait>"), MoveTo("ready")))
    report = write_report(found, tmp_path / "task.html", moving=False).read_text()
    assert "What was tried" not in report and f"rejected: {found.causes[0]}"[:40] in report
    page = to.view(found, port=8191)
    try:
        page.show(found.stages[1].begin + 0.1)
        content = page._text.content  # pyright: ignore[reportPrivateUsage]
        for words in ("&lt;wait&gt;", "0.50 s", "mm clear", "near (chosen)", "rejected: below"):
            assert words in content, words
        marked = [row for row in content.split("<tr") if "font-weight:600" in row]
        assert len(marked) == 1 and "&lt;wait&gt;" in marked[0]
    finally:
        page.close()


def test_the_cup_ends_at_its_place_and_friction_alone_carries_it(carried: TaskResult) -> None:
    there = carried.final_scene.placement_of("cup", carried.final_positions)
    np.testing.assert_allclose(there.translation, (0.5, 0.25, 0.06), atol=2e-3)
    rolled = simulate_handling(carried.handling("cup"))
    assert rolled.hold is Hold.HELD, rolled.summary()
    with pytest.raises(NameNotFound, match="no picked object named 'table'"):
        carried.handling("table")


def test_friction_holds_every_object_that_a_simulated_task_picks(
    cell: to.Scene, grasps: tuple[Grasp, ...], there: Place, tmp_path: Path
) -> None:
    """The cup is picked twice and stays in the hand; the can and the cup are loose together."""
    can = to.Cylinder(radius=0.02, length=0.1)
    scene = cell.add("can", can, to.placement((0.4, -0.3, 0.05)), mass=0.3)
    aside = Place(placement=to.placement((0.5, 0.0, 0.05)))
    stages = (
        *(PickObject("cup", grasps), PlaceObject("cup", there)),
        *(PickObject("can", grasps_of(scene, "can", gripper_of(scene.robot))), PlaceObject("can", aside)),
        *(PickObject("cup", grasps), MoveTo("ready")),
    )
    result = to.plan(task(scene, *stages))
    rolled = to.simulate(result)
    assert rolled.succeeded, rolled.summary()
    assert [each.result.name for each in rolled.handlings] == ["cup", "can", "cup"]
    assert not rolled.notes and rolled.log.loose == ("cup", "can")
    ended = rolled.log.placements["can"][-1].translation
    np.testing.assert_allclose(ended, aside.placement.translation, atol=2e-3)
    held = result.final_scene.placement_of("cup", result.final_positions)
    np.testing.assert_allclose(rolled.log.placements["cup"][-1].translation, held.translation, atol=3e-3)
    written = json.loads(json.dumps(rolled.as_dict()))
    assert [each["hold"] for each in written["handlings"]] == ["HELD"] * 3
    assert to.render(rolled, tmp_path / "task.png", width=80, height=60).is_file()


def test_an_object_that_slips_out_of_the_fingers_fails_the_simulation(carried: TaskResult) -> None:
    rolled = simulate_task(carried, friction=Friction(pads=0.02))
    assert not rolled.succeeded
    assert [each.hold for each in rolled.handlings] == [Hold.LOST]
    assert "cup: the fingers lost the object" in rolled.summary()


def test_objects_without_friction_follow_their_tracks_in_the_simulation(
    cell: to.Scene, grasps: tuple[Grasp, ...], there: Place
) -> None:
    light = cell.remove("cup").add("cup", to.Cylinder(0.03, 0.12), to.placement((0.5, -0.2, 0.06)))
    rolled = to.simulate(to.plan(task(light, PickObject("cup", grasps), PlaceObject("cup", there))))
    assert rolled.succeeded, rolled.summary()
    assert rolled.handlings == ()
    assert any(note.startswith("object 'cup' follows its planned motion") for note in rolled.notes)
    hold = AttachObject("cup", "panda_hand_tcp", touch_links=("panda_hand",))
    stages = MoveTo(over(0.5, -0.2, 0.17)), hold, MoveTo(over(0.5, 0.2, 0.2)), DetachObject("cup")
    rolled = to.simulate(to.plan(task(cell, SetGripper(0.07), *stages)))
    assert rolled.succeeded, rolled.summary()


def test_motions_of_other_stages_do_not_press(
    cell: to.Scene, grasps: tuple[Grasp, ...], there: Place
) -> None:
    """To "extended" and up are motions of their own, before the pick and while the cup is carried."""
    up = MoveTo(over(0.5, 0.0, 0.5), name="up"), Dwell(0.1)
    stages = MoveTo("extended"), PickObject("cup", grasps), *up, PlaceObject("cup", there)
    found = to.plan(task(cell, *stages))
    handling = found.handling("cup")
    assert found.segments[0].stages == ("move to extended",)
    held = [segment.stage.holds for segment in handling.segments]
    assert not any(held[: held.index(True)])
    assert held.count(True) >= 2
    assert not handling.segments[0].stage.holds
    assert simulate_handling(handling).hold is Hold.HELD


def test_a_task_is_faster_than_single_motions(cell: to.Scene) -> None:
    stops = over(0.5, 0.2), over(0.5, 0.0), over(0.5, -0.2, 0.4)
    through = to.plan(task(cell, *map(MoveTo, stops)))
    rests = to.plan(task(cell, *(stage for stop in stops for stage in (MoveTo(stop), Dwell(1e-3)))))
    assert len(through.require()) == 1
    assert len(rests.require()) == 3
    assert through.duration < 0.95 * rests.duration


def test_improving_shortens_a_task(cell: to.Scene) -> None:
    stages = MoveTo(over(0.5, 0.2)), MoveTo(over(0.5, -0.2, 0.4))
    assert to.plan(task(cell, *stages), improve=True).duration < to.plan(task(cell, *stages)).duration


def test_a_blend_shortens_straight_motions(cell: to.Scene, grasps: tuple[Grasp, ...]) -> None:
    exact, blended = (
        to.plan(task(cell, PickObject("cup", grasps), blend=blend)).require() for blend in (0.0, 0.04)
    )
    ends = [over.positions(over.ends[0][1]) for over in (exact[1], blended[1])]
    far, near = (cell.placement_of("panda_hand_tcp", at).translation[2] for at in ends)
    assert far - near == pytest.approx(0.04, abs=2e-3)


def test_one_of_takes_the_cheapest_and_fallback_the_first(cell: to.Scene) -> None:
    far, near = MoveTo("extended", name="far"), MoveTo(over(0.45, 0.1), name="near")
    assert to.plan(task(cell, OneOf([far, near]))).stages[0].name == "near"
    assert to.plan(task(cell, OneOf([far, near], cost=joint_travel))).stages[0].name == "near"
    assert to.plan(task(cell, Fallback([far, near]))).stages[0].name == "far"
    below = MoveTo(over(0.5, 0.0, -0.2), name="below")
    found = to.plan(task(cell, Fallback([below, [near, Dwell(0.1)]])))
    assert [stage.name for stage in found.stages] == ["near", "dwell"]
    assert {refusal.stage for refusal in found.refusals} == {"below"}


def test_choices_are_branches_with_times_costs_and_reasons(cell: to.Scene, tmp_path: Path) -> None:
    """Also in the file of the result; without a plan only the branches with rejected ways."""
    below, far = MoveTo(over(0.5, 0.0, -0.2), name="below"), MoveTo("extended", name="far")
    quick = Within([replace(far, name="fast")], StageLimits(duration=0.05), name="quick")
    near = [MoveTo(over(0.45, 0.1), name="near"), Dwell(0.1, name="wait")]
    found = to.plan(task(cell, OneOf([below, Fallback([quick, far], name="inner"), near], name="choice")))
    found.save(tmp_path / "task.bundle")
    for each in (found, read_result(tmp_path / "task.bundle")):
        assert isinstance(each, TaskResult)
        assert [(row.depth, row.text.partition(" (")[0][:23]) for row in each.tree if row.time is None] == [
            *((1, "below"), (2, "rejected: below: all 13"), (1, "inner"), (2, "rejected: quick: takes ")),
        ], each.explain()
        timed = [(row.depth, row.text[:20]) for row in each.tree if row.time is not None]
        assert timed == [(0, "choice"), (1, "near, wait (chosen, "), (2, "near"), (2, "wait")]
    assert "(not chosen, cost 1." in found.explain().details[3]
    assert f"chosen, cost {found.duration:.4g}" in found.explain().details[5]
    failed = to.plan(task(cell, Fallback([below, [quick, below]], name="choice"), far))
    assert [line[:10] for line in failed.explain().details] == ["choice", "  below: a", "  quick: t"]


def test_the_ways_of_a_stage_are_compared_by_a_cost(cell: to.Scene, grasps: tuple[Grasp, ...]) -> None:
    """Of three grasps the first is taken, or that with the largest clearance."""
    first = to.plan(task(cell, PickObject("cup", grasps[:3])))
    clearest = OneOf([PickObject("cup", grasps[:3])], cost=StageCost(clearance=1.0), ways_each=3)
    found = to.plan(task(cell, clearest))
    assert found.verified, found.explain()
    least = [least_clearance(each.segments) for each in (first, found)]
    assert least[1] >= least[0]
    travels = OneOf([PickObject("cup", grasps[:3])], cost=StageCost(joint_travel=1.0), ways_each=3)
    short = to.plan(task(cell, travels))
    assert joint_travel(short.segments) <= joint_travel(first.segments) + 1e-6


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        (StageLimits(duration=0.05), "longer than 0.05 s"),
        (StageLimits(joint_travel=0.1), "farther than 0.1"),
        (StageLimits(clearance=2.0), "less than 2"),
        (StageLimits(joints={"panda_joint2": (0.5, 0.6)}), "panda_joint2 moves from"),
    ],
)
def test_ways_beyond_limits_are_rejected(cell: to.Scene, limits: StageLimits, words: str) -> None:
    near, far = MoveTo("ready", name="near"), MoveTo(over(0.45, 0.3), name="far")
    refused = to.plan(task(cell, Within([far], limits, name="strict")))
    assert refused.status is Status.STAGE_LIMITS
    assert "strict: " in refused.reason and words in refused.reason
    if limits.clearance < 0.0:
        taken = to.plan(task(cell, Fallback([Within([far], limits), near]), MoveTo("extended")))
        assert [stage.name for stage in taken.stages] == ["near", "move to extended"]


def test_limits_choose_another_way_and_hold_in_the_plan(cell: to.Scene, grasps: tuple[Grasp, ...]) -> None:
    free = to.plan(task(cell, PickObject("cup", grasps)))
    found = to.plan(task(cell, Within([PickObject("cup", grasps)], LIMITED, name="turned"), MoveTo("ready")))
    assert found.verified, found.explain()
    assert {refusal.stage for refusal in found.refusals} == {"turned"}
    row = cell.robot.joint_names.index("panda_joint7")

    def highest(result: TaskResult) -> float:
        motions = [each for each in result.segments if each.stages[0].startswith("pick cup")]
        return max(
            float(each.positions(time)[row]) for each in motions for time in each.trajectory.times.tolist()
        )

    assert highest(found) <= 0.9 < highest(free)


def test_an_earlier_choice_is_revised(cell: to.Scene) -> None:
    """The first alternative moves the door before the only way to the goal."""
    shut = MoveObject("door", to.placement((0.45, 0.1, 0.3)), name="shut")
    beside = MoveObject("door", to.placement((0.45, -0.6, 0.3)), name="beside")
    room = cell.add("door", to.Box(0.2, 0.2, 0.2), to.placement((0.0, 0.9, 0.3)))
    found = to.plan(task(room, Fallback([shut, beside]), MoveTo(over(0.45, 0.1), name="in")))
    assert found.verified, found.explain()
    assert found.final_scene.placement_of("door", found.final_positions).translation[1] == -0.6
    assert [refusal.stage for refusal in found.refusals] == ["in"], found.explain()
    assert [row.text for row in found.tree[:3]] == ["fallback", "shut (rejected)", "beside (chosen)"]


def test_an_object_that_is_moved_onto_the_arm_is_refused(cell: to.Scene) -> None:
    """Also by the last stage, after which no motion begins in that scene."""
    room = cell.add("door", to.Box(0.2, 0.2, 0.2), to.placement((0.0, 0.9, 0.3)))
    stages = MoveTo(over(0.45, 0.1)), MoveObject("door", to.placement((0.45, 0.1, 0.3)), name="shut")
    found = to.plan(task(room, *stages))
    assert found.status is Status.START_IN_COLLISION
    assert "shut: the object meets the arm at rest" in found.reason


def test_objects_that_move_one_after_the_other_rest_the_arm_for_all_their_times(cell: to.Scene) -> None:
    room = cell.add("door", to.Box(0.2, 0.2, 0.2), to.placement((0.0, 0.9, 0.3)))
    there, back = to.placement((0.0, 0.9, 0.9)), to.placement((0.0, 0.9, 0.3))
    doors = MoveObject("door", there, 1.0, name="up"), MoveObject("door", back, 0.5, name="down")
    found = to.plan(task(room, MoveTo(over(0.45, 0.1)), *doors, MoveTo("ready")))
    lasted = {stage.name: stage.end - stage.begin for stage in found.stages}
    assert lasted["up"] == pytest.approx(1.0) and lasted["down"] == pytest.approx(0.5)


def test_a_curve_among_moving_objects_is_refused(cell: to.Scene) -> None:
    track = to.Track.constant_velocity(to.placement((0.9, 0.8, 0.6)), (0.0, -0.5, 0.0), end=20.0)
    moving = cell.add("ball", to.Sphere(0.05), motion=track)
    seam = to.follows_curve("panda_hand_tcp", line(over(0.4, 0.1), over(0.55, 0.1)))
    with pytest.raises(
        ProblemError, match="'follow': a task follows curves in static scenes only, and 'ball'"
    ):
        task(moving, FollowCurve(seam))


def test_a_place_is_checked_before_its_pick_is_planned(cell: to.Scene, grasps: tuple[Grasp, ...]) -> None:
    """All ways to pick are tried for it, but none is planned."""
    far = Place(placement=to.placement((1.5, 0.0, 0.06)), name="far")
    found = to.plan(task(cell, PickObject("cup", grasps[:4]), PlaceObject("cup", far)))
    assert found.status is Status.NO_INVERSE_KINEMATICS
    assert "qp_solves" not in found.counts
    assert found.failed == "place cup: lower" and "place cup: lower" in found.reason
    placing = [refusal for refusal in found.refusals if refusal.stage == "place cup: lower"]
    assert {refusal.names.grasp for refusal in placing} == {grasp.name for grasp in grasps[:4]}
    assert {refusal.names.place for refusal in placing} == {"far"}


def test_fingers_do_not_close_into_what_they_hold(cell: to.Scene, grasps: tuple[Grasp, ...]) -> None:
    found = to.plan(task(cell, PickObject("cup", grasps), SetGripper(0.02, name="squeeze"), MoveTo("ready")))
    assert found.status is Status.GRIPPER_CANNOT and found.failed == "squeeze"
    assert "the fingers would be 20 mm inside 'cup', which they hold" in found.reason
    for opening, stage in ((0.06, MoveTo("extended")), (0.07, DetachObject("cup"))):
        stages = PickObject("cup", grasps), SetGripper(opening), stage, MoveTo("ready")
        assert to.plan(task(cell, *stages)).verified


def test_an_arm_does_not_leave_behind_what_its_fingers_let_go_of(
    cell: to.Scene, grasps: tuple[Grasp, ...]
) -> None:
    """Opening while holding is a release: it may be followed by a detachment or by closing again."""
    opened = PickObject("cup", grasps), SetGripper(0.07)
    for stages in (
        (MoveTo("extended"),),
        (Dwell(0.1), Fallback([MoveTo("extended")])),
        (PlaceObject("cup", Place(placement=to.placement((0.5, 0.25, 0.06)))),),
    ):
        found = to.plan(task(cell, *opened, *stages))
        assert found.status is Status.GRIPPER_CANNOT
        assert "the fingers have let go of 'cup': detach it or close them on it" in found.reason
    for stages in (
        (DetachObject("cup"), MoveTo("extended")),
        (SetGripper(0.06, name="again"), MoveTo("extended")),
        (DetachObject("cup"), AttachObject("cup", "panda_hand_tcp"), MoveTo("extended")),
    ):
        assert to.plan(task(cell, *opened, *stages)).verified, stages


def test_a_place_beyond_the_arm_is_refused_by_its_length(cell: to.Scene, grasps: tuple[Grasp, ...]) -> None:
    """Every grasp and posture was searched for it, for ten seconds."""
    far = Place(placement=to.placement((500.0, 250.0, 60.0)))
    found = to.plan(task(cell, PickObject("cup", grasps), PlaceObject("cup", far)))
    assert found.status is Status.NO_INVERSE_KINEMATICS and found.failed == "place cup: lower"
    assert "too short" in found.reason and "millimetres" in found.reason


def test_a_place_inside_something_is_refused_without_the_arm(
    cell: to.Scene, grasps: tuple[Grasp, ...]
) -> None:
    def put(height: float) -> TaskResult:
        place = Place(placement=to.placement((0.5, 0.25, height)))
        return to.plan(task(cell, PickObject("cup", grasps), PlaceObject("cup", place)))

    assert put(0.0595).verified
    refused = [each for each in put(0.055).refusals if each.stage == "place cup: lower"]
    words = "cup is inside table at the place, wherever the arm is"
    assert {each.reason for each in refused} == {words}


def test_a_place_that_no_posture_reaches_is_searched_once_for_each_grasp(
    cell: to.Scene, grasps: tuple[Grasp, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was searched for from every posture of every pick."""
    searched: list[str] = []

    def counted(query: object, goals: Sequence[Requirement], **rest: Any) -> object:
        searched.extend(frame for item in goals for frame in item.frames if frame == "cup")
        return goal_candidates(query, goals, **rest)  # type: ignore[arg-type]

    monkeypatch.setattr("trajopt.tasks.search.goal_candidates", counted)
    edge = Place(placement=to.placement((0.86, 0.0, 0.06)))
    found = to.plan(task(cell, PickObject("cup", grasps[:3]), PlaceObject("cup", edge)))
    lowered = [refusal for refusal in found.refusals if refusal.stage == "place cup: lower"]
    assert len(lowered) > len(searched) and 0 < len(searched) <= 3


def test_the_other_hand_does_not_place() -> None:
    arms = to.load("two_pandas")
    left, right = (gripper_of(arms, end_effector=f"{side}_hand") for side in ("left", "right"))
    scene = to.Scene(arms).add("cup", to.Cylinder(0.03, 0.12), to.placement((0.4, 0.4, 0.06)))
    pick = PickObject("cup", grasps_of(scene, "cup", left)[:2], left)
    put = PlaceObject("cup", Place(placement=to.placement((0.4, -0.4, 0.06))), right)
    found = to.plan(Task(scene=scene, group="both", start="ready", stages=[pick, put]))
    assert found.status is Status.GRIPPER_CANNOT
    assert "'right_panda_hand_tcp' does not hold 'cup'" in found.reason
    for stages, group in (([pick], "right_panda_manipulator"), ([pick, put], "left_panda_manipulator")):
        with pytest.raises(ProblemError, match=f"no joint of group '{group}' moves '.*_panda_hand_tcp'"):
            Task(scene=scene, group=group, start="left_ready", stages=stages)


def test_what_a_finger_carries_is_held_by_its_gripper() -> None:
    """Before, a group that moves the fingers too was told that its hand does not hold the cup."""
    panda = to.load("panda")
    scene = to.Scene(panda).add(
        "cup", to.Cylinder(0.02, 0.06), to.placement((0.0, -0.02, 0.045)), frame="panda_leftfinger"
    )
    hand = gripper_of(panda)
    start = hand.opened(panda, panda.positions(), 0.04)
    put = PlaceObject("cup", Place(placement=to.placement((0.5, 0.2, 0.03))), hand)
    found = to.plan(Task(scene=scene, group="panda_arm_hand", start=start, stages=[put]))
    assert not found.verified and "does not hold" not in found.reason


def test_fingers_that_meet_something_are_refused_without_the_arm(
    cell: to.Scene, grasps: tuple[Grasp, ...]
) -> None:
    """Every posture of every grasp was planned up to the object: seconds for a mobile robot."""
    posts = cell
    for side in (-1, 1):
        post = to.Box(0.2, 0.002, 0.12)
        posts = posts.add(f"post {side}", post, to.placement((0.5, -0.2 + side * 0.0355, 0.06)))
    grasp = replace(next(each for each in grasps if "closing at 90" in each.name), opening=0.079)
    met = to.plan(task(posts, PickObject("cup", [grasp])))
    assert met.failed == "pick cup: close" and "finger is inside post" in met.reason, met.explain()
    assert "qp_solves" not in met.counts
    wall = cell.add("wall", to.Box(0.3, 0.01, 0.12), to.placement((0.5, 0.3185, 0.06)))
    place = Place(placement=to.placement((0.5, 0.25, 0.06)))
    beside = PlaceObject("cup", place, opening=0.079)
    found = to.plan(task(wall, PickObject("cup", [grasp]), beside))
    assert found.failed == "place cup: release" and "finger is inside wall" in found.reason, found.explain()
    assert "qp_solves" not in found.counts
    assert to.plan(task(wall, PickObject("cup", [grasp]), replace(beside, opening=0.07))).verified


def test_a_failed_pick_names_step_part_and_cause_once(cell: to.Scene, grasps: tuple[Grasp, ...]) -> None:
    """The farthest step counts, not the one tried last; the object is named though its stage is not."""
    wide = replace(grasps[0], opening=0.5, name="wide")
    far = Place(placement=to.placement((1.5, 0.0, 0.06)), name="far")
    stages = PickObject("cup", [grasps[0], wide], name="take"), PlaceObject("cup", far, name="put")
    found = to.plan(task(cell, *stages))
    assert found.failed == "put: lower" and found.status is Status.NO_INVERSE_KINEMATICS
    assert found.refusals[-1].stage == "take: open"
    assert f"put: lower: part cup, {grasps[0].name}, far: " in found.reason
    alone = str(to.plan(task(cell, PickObject("cup", [wide], name="take"))).explain())
    assert alone.count("take: open: part cup, wide: needs 500.0 mm") == 1


UPRIGHT = to.axis_alignment("tool", axis=(0.0, 0.0, 1.0), direction=(0.0, 0.0, 1.0), tolerance=0.1)
WRONG_STAGES = {
    "class": (lambda: [MoveTo], "must be a TaskStage"),
    "item": (lambda: [Fallback(["ready"])], "items must be a TaskStage or several, is 'ready'"),  # pyright: ignore
    "constraint": (
        lambda: [MoveTo("ready", constraints=[UPRIGHT])],
        "stage 'move to ready': no frame named 'tool'",
    ),
    "still frame": (
        lambda: [FollowCurve(to.follows_curve("table", line(over(0.4, 0.1), over(0.5, 0.1))), name="seam")],
        "stage 'seam': 'table' is fixed in the world",
    ),
    "world": (lambda: [AttachObject("cup", "world")], "stage 'attach cup': 'world' is fixed in the world"),
    "cost": (lambda: [OneOf([MoveTo("ready")], cost="duration")], "cost must be a function"),  # pyright: ignore
    "range": (
        lambda: [Within([MoveTo("ready")], StageLimits(joints={"panda_joint1": 1.0}))],  # pyright: ignore
        "joints: 'panda_joint1' needs the lowest and highest position",
    ),
    "own place": (
        lambda: [PlaceObject("cup", Place(placement=over(0.5, 0.1), frame="cup", name="spot"))],
        "stage 'place cup': place 'spot' of 'cup' is on itself",
    ),
    "nested": (
        lambda: [Fallback([[Dwell(0.1), PlaceObject("cup", Place(placement=over(0.5, 0.1)))]])],
        "stage 'fallback': stage 'place cup': object 'cup' is not in a hand",
    ),
}


@pytest.mark.parametrize("name", WRONG_STAGES)
def test_bad_stages_are_refused_by_name(cell: to.Scene, name: str) -> None:
    stages, words = WRONG_STAGES[name]
    with pytest.raises(ProblemError, match=words):
        task(cell, *stages())  # pyright: ignore[reportArgumentType]


def test_objects_that_move_by_themselves_are_not_moved_by_a_task(cell: to.Scene) -> None:
    track = to.Track.constant_velocity(over(0.9, 0.8), (0.0, -0.5, 0.0), end=20.0)
    moving = cell.add("ball", to.Sphere(0.05), motion=track)
    for stage in (AttachObject("ball", "panda_hand"), MoveObject("ball", over(0.5, 0.1))):
        with pytest.raises(ProblemError, match="ball': object 'ball' moves by itself"):
            task(moving, stage)


def test_costs_that_are_not_numbers_are_refused(cell: to.Scene) -> None:
    with pytest.raises(ShapeError, match="cost: holds a number"):
        to.plan(task(cell, OneOf([MoveTo(over(0.5, 0.1))], cost=lambda _: np.nan)))


def test_results_of_one_and_of_several_motions_have_the_same_members(
    cell: to.Scene, carried: TaskResult, tmp_path: Path
) -> None:
    seam = to.follows_curve("panda_hand_tcp", line(over(0.4, 0.1), over(0.55, 0.1)))
    options = FollowOptions(begin=Begin.ANY_BRANCH)
    followed = to.follow(cell, seam, start="ready", group="panda_arm", options=options)
    single = to.plan(to.Problem(scene=cell, group="panda_arm", start=followed, goal="ready"))
    for result in (carried, carried.handling("cup"), followed, single):
        assert result.verified and result.certificate is not None and not result.stopped_by_clock
        assert set(result.final_state) == set(cell.robot.joint_names)
        result.save(tmp_path / "kept.trajopt")
        result.write(tmp_path / "kept.json")
        assert json.loads((tmp_path / "kept.json").read_text())["verified"] is True
        with pytest.raises(AttributeError, match="'success': use result"):
            result.success  # noqa: B018  # pyright: ignore
    for result in (carried, carried.handling("cup"), followed):
        times = result.stages
        assert result.trajectory is not None and times[0].begin == 0.0
        assert times[-1].end == pytest.approx(result.trajectory.duration)


def test_postures_in_any_order_meet_the_constraints_of_their_moves(cell: to.Scene) -> None:
    inside = to.joint_positions({"panda_joint1": 0.5}, tolerance=0.05)
    free = to.frame_placement(
        "panda_hand_tcp", over(0.5, 0.0), rotation_tolerance=(0.1, 0.1, np.inf), position_tolerance=1e-3
    )
    kept = [MoveTo(free, constraints=[inside], name="kept"), Dwell(0.1)]
    begin = {"panda_joint1": 0.5}
    found = to.plan(task(cell, AnyOrder([kept]), start=begin | dict(zip(ARM[1:], READY[1:], strict=True))))  # pyright: ignore[reportArgumentType]
    assert found.verified and not found.refusals, found.explain()
    turn = found.trajectory.positions[:, found.trajectory.joint_names.index("panda_joint1")]
    assert np.abs(turn - 0.5).max() <= 0.05 + 1e-6


def test_any_order_is_not_slower_than_the_given_one(cell: to.Scene) -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform((0.35, -0.3), (0.65, 0.3), (10, 2)).tolist()
    spots = [over(x, y, 0.25) for x, y in points]
    moves = [MoveTo(spot, name=f"spot {k}") for k, spot in enumerate(spots)]
    ordered = to.plan(task(cell, AnyOrder(moves, then="ready"), MoveTo("ready")))
    given = to.plan(task(cell, *moves, MoveTo("ready")))
    assert {stage.name for stage in ordered.stages} == {stage.name for stage in given.stages}
    assert ordered.duration < 0.8 * given.duration
    drilled = to.plan(task(cell, AnyOrder([[move, Dwell(0.1)] for move in moves])))
    assert len(drilled.require()) == 10
    assert all(segment.rest == 0.1 for segment in drilled.segments)


def test_an_order_avoids_a_wall(cell: to.Scene) -> None:
    """Two spots on each side of a wall: it is crossed once."""
    walled = cell.add("wall", to.Box(0.3, 0.02, 0.5), to.placement((0.55, 0.0, 0.25)))
    moves = [
        MoveTo(over(x, y, 0.25), name=f"{side} {x}")
        for x in (0.45, 0.6)
        for side, y in (("left", 0.12), ("right", -0.12))
    ]
    found = to.plan(task(walled, AnyOrder(moves)))
    sides = [stage.name.split()[0] for stage in found.stages]
    assert found.verified, found.explain()
    assert sum(a != b for a, b in pairwise(sides)) == 1, sides
    assert [row.text for row in found.tree][1:] == [stage.name for stage in found.stages]


def test_a_suction_cup_attaches_and_detaches(cell: to.Scene) -> None:
    on_top = MoveTo(over(0.5, -0.2, 0.145), name="on top")
    stages = on_top, AttachObject("cup", "panda_hand_tcp"), MoveTo("ready"), MoveTo(over(0.5, 0.2, 0.2))
    held = to.plan(task(cell, SetGripper(0.0), *stages))
    assert held.verified, held.explain()
    assert held.final_scene.holder("cup").link != "world"
    down = to.plan(task(cell, SetGripper(0.0), *stages, DetachObject("cup")))
    assert down.final_scene.holder("cup").link == "world"
    assert ["attach cup", "detach cup"] == [each.name for each in down.stages if each.end == each.begin]
    assert down.final_scene.placement_of("cup", down.final_positions).translation[1] == pytest.approx(
        0.2, abs=2e-3
    )


def test_an_object_that_the_tool_does_not_reach_is_not_attached(cell: to.Scene) -> None:
    """The stage is named; a distance that is stated is accepted."""
    far = to.plan(task(cell, AttachObject("cup", "panda_hand_tcp")))
    assert far.status is Status.GRIPPER_CANNOT and far.failed == "attach cup"
    assert "away from 'panda_hand_tcp', farther than 50 mm" in far.reason
    assert to.plan(task(cell, AttachObject("cup", "panda_hand_tcp", within=np.inf))).verified


def test_a_start_in_collision_is_proven(cell: to.Scene) -> None:
    walled = cell.add("wall", to.Box(0.2, 0.2, 0.2), to.placement((0.3, 0.0, 0.6)))
    found = to.plan(task(walled, MoveTo({"panda_joint1": 0.5})))
    assert found.status is Status.START_IN_COLLISION
    assert found.explain().certainty is Certainty.PROVEN and "evidence" not in str(found.explain())


def test_a_curve_is_followed_after_the_way_to_its_beginning(cell: to.Scene) -> None:
    seam = to.follows_curve("panda_hand_tcp", line(over(0.4, 0.1), over(0.55, 0.1)))
    found = to.plan(task(cell, MoveTo(over(0.5, 0.2)), FollowCurve(seam, name="seam"), MoveTo("ready")))
    assert [stage.name for stage in found.stages] == [
        "move",
        "seam: reach",
        "seam",
        "move to ready",
    ], found.explain()
    far = to.follows_curve("panda_hand_tcp", line(over(0.4, 0.1), over(1.4, 0.1)))
    failed = to.plan(task(cell, FollowCurve(far, name="seam")))
    assert not failed.verified
    assert "seam" in failed.reason


def test_rows_are_joined_without_a_rest_off_the_surface(cell: to.Scene) -> None:
    """Two rows over a plate on the table, above it: retract, reach and approach are one motion."""
    corners = np.array([(x, y, 0.045) for x in (0.4, 0.6) for y in (0.1, 0.2)])
    top = to.Mesh(corners, np.array([(0, 2, 1), (1, 2, 3)], dtype=np.int32))
    rows = raster(top, 0, 0.06, along=(1, 0, 0), margin=0.02)
    steady = FollowOptions(
        begin=Begin.ANY_BRANCH, tool_speed=(to.tool_speed("panda_hand_tcp", linear=0.05, steady=0.02),)
    )
    stages = [
        FollowCurve(to.follows_curve("panda_hand_tcp", row), options=steady, off=0.05, name=f"row {number}")
        for number, row in enumerate(rows)
    ]
    high = cell.add("plate", to.Box(0.2, 0.1, 0.005), to.placement((0.5, 0.15, 0.0025)))
    found = to.plan(task(high, SetGripper(0.0), *stages, MoveTo("ready")))
    assert found.verified, found.explain()
    assert ("row 0: retract", "row 1: reach", "row 1: approach") in [part.stages for part in found.segments]


def test_a_failure_names_its_stage_once(cell: to.Scene) -> None:
    failed = to.plan(task(cell, MoveTo(over(0.5, 0.1)), MoveTo(over(1.5, 0.0), name="too far")))
    assert failed.status is Status.NO_INVERSE_KINEMATICS
    assert str(failed.explain()).count("  too far: ") == 1
    with pytest.raises(PlanningFailed, match="too far"):
        failed.require()


def test_a_reason_names_the_status_once(cell: to.Scene) -> None:
    walled = cell.add("wall", to.Box(0.1, 0.1, 0.1), cell.placement_of("panda_hand", "ready"))
    reason = to.plan(task(walled, MoveTo("extended"))).reason
    assert reason.startswith("START_IN_COLLISION: move to extended: the start is in collision")


def test_a_budget_and_a_cancellation_end_it(cell: to.Scene) -> None:
    stages = MoveTo(over(0.5, 0.1)), MoveTo("extended")
    assert to.plan(task(cell, *stages), budget=to.Budget(work=1)).status is Status.OUT_OF_WORK
    with pytest.raises(ProblemError, match="cannot improve"):
        to.plan(task(cell, *stages), budget=to.Budget(improve=True, seconds=1.0))
    with pytest.raises(ProblemError, match="method is an argument for a problem"):
        to.plan(task(cell, *stages), method="chomp")  # pyright: ignore[reportCallIssue, reportArgumentType]


@pytest.mark.parametrize("far", [1e-9, 1e-6, 1e-4])
def test_lines_shorter_than_a_tolerance_are_planned(
    cell: to.Scene, grasps: tuple[Grasp, ...], far: float
) -> None:
    short = [replace(grasp, approach=Straight(far), lift=Straight(far)) for grasp in grasps]
    assert to.plan(task(cell, PickObject("cup", short))).verified
    curve = to.follows_curve("panda_hand_tcp", line(over(0.5, 0.1), over(0.5, 0.2)))
    assert to.plan(task(cell, FollowCurve(curve, off=far))).verified


def test_a_joint_that_mimics_another_does_not_drive_a_gripper(
    cell: to.Scene, grasps: tuple[Grasp, ...]
) -> None:
    hand = gripper_of(cell)
    follower = hand.joint_names[0].replace("1", "2")
    names, positions = (*hand.joint_names, follower), hand.positions.repeat(2, axis=1)
    both = replace(hand, joint_names=names, positions=positions)
    with pytest.raises(ProblemError, match=f"joint {follower} of the gripper follows {names[0]}"):
        task(cell, PickObject("cup", grasps, gripper=both))


Stages = Callable[[tuple[Grasp, ...], Place], Sequence[object]]
BAD: dict[str, tuple[Stages, str]] = {
    "nothing": (lambda _g, _p: [], "at least one stage"),
    "no stage": (lambda _g, _p: ["ready"], "must be a TaskStage"),
    "a place before its pick": (
        lambda _g, p: [PlaceObject("cup", p)],
        "'place cup': object 'cup' is not in a",
    ),
    "picked twice": (
        lambda g, _p: [PickObject("cup", g), PickObject("cup", g)],
        "'pick cup \\(2\\)': .* already",
    ),
    "unknown object": (lambda g, _p: [PickObject("cap", g)], "'pick cap': no object .* did you mean 'cup'"),
    "unknown state": (lambda _g, _p: [MoveTo("redy")], "'move to redy': no state .*'ready'"),
    "too wide": (lambda _g, _p: [SetGripper(0.5)], "'gripper': opening: 0.5 m"),
    "pick in any order": (lambda g, _p: [AnyOrder([PickObject("cup", g)])], "item 1 begins with PickObject"),
    "moved in the hand": (
        lambda g, _p: [PickObject("cup", g), MoveObject("cup", to.placement((0.6, 0.0, 0.06)))],
        "'move object cup': object 'cup' is attached",
    ),
    "unknown link that may touch": (
        lambda _g, _p: [AttachObject("cup", "panda_hand", touch_links=["panda_hend"])],
        "'attach cup': .* did you mean 'panda_hand'",
    ),
    "links that may touch as one text": (
        lambda _g, _p: [AttachObject("cup", "panda_hand", touch_links="panda_hand")],
        "touch_links must be a list",
    ),
    "detached before": (lambda _g, _p: [DetachObject("cup")], "'detach cup': object 'cup' is not attached"),
    "held or not": (
        lambda g, _p: [OneOf([MoveTo("ready"), PickObject("cup", g)])],
        "'one of': the alternatives end with different objects in the hand: cup or nothing",
    ),
    "a set": (lambda _g, _p: [MoveTo(to.any_of({"a": "ready", "b": "extended"}))], "use OneOf"),  # pyright: ignore
    "a pause of nothing": (lambda _g, _p: [Dwell(0.0)], "seconds must be positive"),
}


@pytest.mark.parametrize("bad", BAD)
def test_a_bad_task_is_refused_in_a_sentence_that_names_the_stage(
    bad: str, cell: to.Scene, grasps: tuple[Grasp, ...], there: Place
) -> None:
    stages, words = BAD[bad]
    with pytest.raises(ProblemError, match=words):
        task(cell, *stages(grasps, there))  # pyright: ignore[reportArgumentType]


def test_the_rest_in_a_moving_world_is_proven(cell: to.Scene) -> None:
    """A ball passes while the arm waits; the next motion meets the world at its time."""
    track = to.Track.constant_velocity(to.placement((0.9, 0.8, 0.6)), (0.0, -0.5, 0.0), end=20.0)
    moving = cell.add("ball", to.Sphere(0.05), motion=track)
    found = to.plan(task(moving, MoveTo(over(0.5, 0.2)), Dwell(0.5), MoveTo("ready")))
    assert found.verified, found.explain()
    assert len(found.segments) == 2


def test_a_task_without_a_motion_has_a_result_without_a_trajectory(cell: to.Scene) -> None:
    name = next(iter(cell.objects))
    found = to.plan(task(cell, AttachObject(name, "panda_hand", within=np.inf)))
    assert found.verified
    assert found.duration == 0.0
    assert found.stages == ()
    assert "in 0 motions" in str(found.explain())
    assert found.final_positions == pytest.approx(found.start)
    for part in ("trajectory", "certificate"):
        with pytest.raises(ProblemError, match="has no motion"):
            getattr(found, part)
