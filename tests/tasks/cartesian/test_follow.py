"""Following curves: all of them where that is possible, and a reason where it is not."""

import json
import re
from functools import cache
from pathlib import Path
from threading import Event

import numpy as np
import pytest

import trajopt as to
from trajopt.planning import Budget, Certainty, Status
from trajopt.tasks.cartesian import (
    Avoid,
    Begin,
    Curve,
    Followed,
    FollowOptions,
    circle,
    follow,
    follows_curve,
    line,
    polyline,
)
from trajopt.values.errors import FrameNotFound, PlanningFailed, ProblemError
from trajopt.viewer.report import write_report

TCP = "panda_hand_tcp"
TENTH = 1e-4
"""What a curve is followed to [m]."""


@cache
def panda() -> to.Robot:
    return to.load("panda")


def ready() -> to.Placement:
    return to.Scene(panda()).placement_of(TCP, panda().positions("ready"))


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> to.Placement:
    """The tool as it is when ready, moved [m]."""
    return to.placement(ready().translation + np.array((x, y, z)), rotation=ready().rotation)


def followed(way: Curve, scene: to.Scene | None = None, **more: object) -> Followed:
    options = more.pop("options", FollowOptions())
    required = follows_curve(TCP, way, **more)  # type: ignore[arg-type]
    return follow(
        scene or to.Scene(panda()),
        required,
        start="ready",
        group="panda_arm",
        options=options,  # type: ignore[arg-type]
    )


def tips(result: Followed, count: int = 2000) -> np.ndarray:
    trajectory, reduced = result.trajectory, result.problem.reduced
    assert trajectory is not None
    return np.array(
        [
            reduced.scene.placement_of(TCP, reduced.all_positions(q)).translation
            for q in trajectory(np.linspace(0.0, trajectory.duration, count))
        ]
    )


def test_a_line_is_followed_to_a_tenth_of_a_millimetre() -> None:
    end = at(0.1, 0.3, 0.1)
    result = followed(line(at(), end))
    assert result.complete
    assert result.fraction == 1.0
    assert result.stop is None
    assert result.deviation <= TENTH
    plan = result.require()
    assert plan.certificate.verified
    points = tips(result)
    direction = (end.translation - points[0]) / np.linalg.norm(end.translation - points[0])
    along = (points - points[0]) @ direction
    off = points - points[0] - along[:, None] * direction
    assert np.linalg.norm(off, axis=1).max() <= TENTH
    assert (np.diff(along) >= -1e-9).all()
    assert points[-1] == pytest.approx(end.translation, abs=TENTH)
    assert json.loads(json.dumps(result.as_dict()))["complete"]


def test_sharp_corners_come_to_rest_and_rounded_ones_do_not() -> None:
    poses = (at(), at(0.0, 0.2, 0.0), at(0.2, 0.2, 0.0))
    sharp, rounded = followed(polyline(poses)), followed(polyline(poses, blend=0.04))
    assert sharp.complete
    assert rounded.complete
    speeds = [np.linalg.norm(np.diff(tips(each), axis=0), axis=1)[400:-400] for each in (sharp, rounded)]
    assert speeds[0].min() < 1e-3 * speeds[0].max()
    assert speeds[1].min() > 0.2 * speeds[1].max()
    assert sharp.trajectory is not None
    assert rounded.trajectory is not None
    assert rounded.trajectory.duration < sharp.trajectory.duration


def test_a_circle_is_closed() -> None:
    turned = to.placement(at(0.1, 0.0, 0.0).translation, rpy=(0, 0, np.pi))
    result = followed(circle(turned, radius=0.1, rotation=ready().rotation))
    assert result.complete
    points = tips(result)
    assert np.linalg.norm(points - turned.translation, axis=1) == pytest.approx(0.1, abs=TENTH)
    assert points[0] == pytest.approx(points[-1], abs=TENTH)


def test_a_blocked_line_reports_the_place_and_the_obstacle(tmp_path: Path) -> None:
    way = line(at(), at(0.1, 0.35, 0.0))
    wall = to.Scene(panda()).add("wall", to.Box(0.3, 0.02, 0.6), to.placement((0.4, 0.25, 0.4)))
    result = followed(way, wall)
    assert not result.complete
    assert result.verified, "the part before the wall is a motion"
    assert result.stop is not None
    assert result.stop.status is Status.COLLISION
    assert result.stop.pair is not None
    assert "wall" in result.stop.pair
    assert result.stop.pose == 0
    assert result.stop.at == pytest.approx(result.fraction * way.length)
    assert 0.1 < result.fraction < 0.6
    assert "wall" in result.reason
    assert tips(result)[-1] == pytest.approx(way.placement(result.stop.at).translation, abs=TENTH)
    assert result.require(0.1).trajectory.duration > 0.0
    with pytest.raises(PlanningFailed, match="wall"):
        result.require()
    page = write_report(result, tmp_path / "part.html", moving=False, pictures=False).read_text()
    assert "Proven." in page and "followed, proven" in page and "COLLISION after pose 0" in page


def test_the_end_of_a_line_is_reported_as_margin_or_requirement() -> None:
    way = line(at(), at(0.1, 0.35, 0.0))
    wall = to.Scene(panda()).add("wall", to.Box(0.3, 0.02, 0.6), to.placement((0.4, 0.25, 0.4)))
    kept, required = followed(way, wall), followed(way, wall.with_clearance(0.01))
    assert kept.stop is not None and required.stop is not None
    assert "10.0 mm are kept along a curve, as a margin: Scene.with_margin lowers it" in kept.stop.message
    assert "15.0 mm are kept along a curve, 10 mm required and a margin" in required.stop.message
    nearer = followed(way, wall.with_margin(0.002))
    assert nearer.fraction > kept.fraction


def test_reports_a_line_out_of_reach() -> None:
    result = followed(line(at(), at(0.9, 0.0, 0.0)))
    assert result.stop is not None
    assert result.stop.status in {Status.OUT_OF_REACH, Status.JOINT_LIMIT}
    assert 0.2 < result.fraction < 0.9
    assert result.verified


def test_a_turn_ends_at_a_joint_limit() -> None:
    half, turned = (
        to.placement(ready().translation, rotation=ready().rotation @ to.placement(rpy=(0, 0, yaw)).rotation)
        for yaw in (-3.0, -6.0)
    )
    way = polyline((at(), half, turned))
    result = followed(way)
    assert result.stop is not None
    assert result.stop.status is Status.JOINT_LIMIT
    assert result.stop.joint == "panda_joint7"
    assert "panda_joint7" in result.reason
    assert result.stop.pose == 1
    assert result.verified


def test_the_start_must_be_on_the_curve() -> None:
    way = line(at(0.0, 0.0, 0.1), at(0.0, 0.2, 0.1))
    result = followed(way)
    assert result.stop is not None
    assert result.stop.status is Status.START_BREAKS_CONSTRAINT
    assert result.fraction == 0.0
    assert result.trajectory is None
    assert followed(way, options=FollowOptions(begin=Begin.ANY_BRANCH)).complete
    far = line(to.placement((3.0, 0, 0)), to.placement((3.0, 0, 1)))
    lost = followed(far, options=FollowOptions(begin=Begin.ANY_BRANCH))
    assert lost.stop is not None
    assert lost.stop.status is Status.NO_INVERSE_KINEMATICS


def test_bad_input_is_refused() -> None:
    with pytest.raises(FrameNotFound):
        follow(
            to.Scene(panda()),
            follows_curve("hand", line(at(), at(0.1, 0, 0))),
            start="ready",
            group="panda_arm",
        )
    with pytest.raises(ProblemError, match="tube"):
        FollowOptions(tube=0.1)


def deviating(tube: float) -> FollowOptions:
    return FollowOptions(avoid=Avoid.DEVIATE, tube=tube)


def test_a_blocked_line_is_left_no_farther_than_needed() -> None:
    """A ball of 4 cm on the line: the fingers are wider than thick, so 5 to 8 cm must do."""
    way = line(at(), at(0.1, 0.4, 0.0))
    ball = to.Scene(panda()).add("ball", to.Sphere(0.04), at(0.05, 0.2, 0.0))
    result = followed(way, ball, options=deviating(0.15))
    assert result.complete
    assert result.around is not None
    assert "ball" in (result.around.pair or ())
    assert 0.04 < result.deviation < 0.08
    points = tips(result)
    measured = np.linalg.norm(
        points - way(np.linspace(0.0, way.length, 3001)).translation[:, None], axis=2
    ).min(axis=0)
    assert measured.max() <= result.deviation + 1e-4
    assert points[-1] == pytest.approx(way.placement(way.length).translation, abs=TENTH)
    assert result.turn <= np.radians(0.1)
    assert "ball" in result.reason
    narrow = followed(way, ball, options=deviating(0.02))
    assert not narrow.complete
    assert narrow.stop is not None
    assert narrow.stop.status is Status.COLLISION
    free = followed(way, options=deviating(0.15))
    assert free.around is None
    assert free.deviation <= TENTH


def test_part_of_a_curve_is_followed_on_request() -> None:
    way = line(at(), at(0.1, 0.4, 0.0))
    ball = to.Scene(panda()).add("ball", to.Sphere(0.04), at(0.05, 0.2, 0.0))
    half = followed(way, until=0.5 * way.length)
    assert half.complete
    assert half.fraction == 1.0
    assert tips(half)[-1] == pytest.approx(way.placement(0.5 * way.length).translation, abs=TENTH)
    around = followed(way, ball, until=0.8 * way.length, options=deviating(0.15))
    assert around.complete
    assert tips(around)[-1] == pytest.approx(way.placement(0.8 * way.length).translation, abs=TENTH)


def straight(**more: object) -> Followed:
    required = follows_curve(TCP, line(at(), at(0.1, 0.2, 0.0)))
    return follow(to.Scene(panda()), required, start="ready", group="panda_arm", **more)  # type: ignore[arg-type]


def test_a_budget_of_one_work_unit_ends_planning_immediately() -> None:
    result = straight(budget=Budget(work=1))
    assert result.status is Status.OUT_OF_WORK
    assert not result.verified and result.fraction == 0.0 and result.trajectory is None
    assert result.counts["forward_kinematics"] > 0 and "programs" not in result.counts
    assert "OUT_OF_WORK" in str(result.explain())
    with pytest.raises(PlanningFailed, match="OUT_OF_WORK"):
        result.require()


def test_work_bounds_the_program_too() -> None:
    whole = straight()
    work = whole.counts["forward_kinematics"]
    assert whole.status is Status.SOLVED and whole.counts["programs"] == 1
    again = straight(budget=Budget(work=work))
    assert again.complete and again.counts == whole.counts
    for share in (0.25, 0.5, 0.9):
        less = straight(budget=Budget(work=int(share * work)))
        assert less.status is Status.OUT_OF_WORK and not less.verified
        assert int(share * work) < less.counts["forward_kinematics"] <= work


def test_time_ends_it() -> None:
    ticks = iter(range(10**9))
    result = straight(budget=Budget(seconds=5.0, clock=lambda: float(next(ticks))))
    assert result.status is Status.OUT_OF_TIME and result.result.stopped_by_clock


def test_it_is_cancelled_before_and_in_every_stage() -> None:
    cancel = Event()
    cancel.set()
    result = straight(cancel=cancel)
    assert result.status is Status.CANCELLED and result.counts == {}
    for stage in ("track", "optimise", "densify", "retime"):
        cancel.clear()

        def progress(name: str, _: object, *, last: str = stage) -> None:
            if name == last:
                cancel.set()

        result = straight(cancel=cancel, progress=progress)
        assert result.status is Status.CANCELLED, stage
        assert not result.verified and result.counts["forward_kinematics"] > 0


def test_progress_names_the_stages() -> None:
    stages: list[str] = []
    assert straight(progress=lambda name, _: stages.append(name)).complete
    assert stages[0] == "start"
    assert {"track", "optimise", "densify", "retime", "verify"} <= set(stages)


@pytest.mark.parametrize(
    "budget", [Budget(attempts=3), Budget(workers=2), Budget(work=10**6, improve=True)], ids=str
)
def test_options_that_do_not_apply_to_a_curve_are_refused(budget: Budget) -> None:
    with pytest.raises(ProblemError, match="seconds and work only"):
        straight(budget=budget)


def test_the_explanation_has_parts() -> None:
    complete, blocked = straight(), followed(line(at(), at(0.9, 0.0, 0.0)))
    assert complete.explain().certainty is Certainty.PROVEN
    assert blocked.explain().certainty is Certainty.EVIDENCE
    assert blocked.explain().status is blocked.status
    assert blocked.reason in str(blocked.explain())


def test_a_seam_out_of_reach_is_followed_by_tilting_within_the_cone() -> None:
    """Without the freedom the end is refused and named; with it every tilt is within the cone."""
    scene = to.Scene(to.load("ur5"))
    down = [to.placement((x, 0.1, 0.1), rpy=(np.pi, 0.0, 0.0)) for x in (0.6, 0.93)]
    options = FollowOptions(begin=Begin.ANY_BRANCH)

    def followed(cone: float | None) -> Followed:
        seam = to.follows_curve("tool0", polyline(down), spin=(0, 0, 1), rotation_tolerance=cone)
        return follow(scene, seam, start="up", group="manipulator", options=options)

    upright, cone = followed(None), np.radians(25.0)
    assert not upright.complete and upright.status is Status.OUT_OF_REACH
    found = followed(cone)
    assert found.complete
    plan = found.result.require()
    for time in np.linspace(0.0, plan.trajectory.duration, 200).tolist():
        at = found.result.problem.reduced.all_positions(plan.trajectory(time))
        tilt = np.arccos(np.clip(-scene.placement_of("tool0", at).rotation[2, 2], -1.0, 1.0))
        assert tilt <= cone


def test_a_steady_speed_that_is_only_ramps_states_the_length_that_is_missing() -> None:
    """The way that is longer by the stated ramps is followed at that speed."""
    speed = to.tool_speed(TCP, linear=1.0, steady=0.02)
    options = FollowOptions(begin=Begin.ANY_BRANCH, tool_speed=(speed,))

    def followed(before: float, after: float) -> Followed:
        ends = [to.placement((0.5, y, 0.3), rpy=(np.pi, 0.0, 0.0)) for y in (-0.1 - before, 0.1 + after)]
        curve = to.follows_curve(TCP, polyline(ends), spin=(0, 0, 1))
        return follow(to.Scene(panda()), curve, start="ready", group="panda_arm", options=options)

    refused = followed(0.0, 0.0)
    assert not refused.complete
    ramps = re.search(r"its ramps take ([\d.]+) mm and ([\d.]+) mm: lengthen the way", refused.reason)
    assert ramps is not None, refused.reason
    assert followed(*(1e-3 * float(length) for length in ramps.groups())).complete


@pytest.mark.parametrize("steady", [0.001, 0.005])
def test_a_speed_steadier_than_its_timing_is_refused_with_the_drop_that_suffices(steady: float) -> None:
    def at_speed(drop: float) -> Followed:
        speed = to.tool_speed(TCP, linear=0.01, steady=drop)
        return followed(line(at(), at(y=0.1)), options=FollowOptions(tool_speed=(speed,)))

    refused = at_speed(steady)
    assert not refused.complete
    stated = re.search(r"`steady=([\d.]+)`", refused.reason)
    assert stated is not None, refused.reason
    assert at_speed(float(stated[1])).complete
