"""Curves on other arms, a jump between branches, steady speed, figures: whole ways through the house."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.tasks.cartesian.test_follow import TCP, at, followed, panda, ready, tips
from tests.verify.arms import joint as joint_xml
from tests.verify.arms import link as link_xml
from tests.verify.arms import robot
from trajopt.files.moveit.trajectories import read_trajectory
from trajopt.planning import Status
from trajopt.problem.requirements import FramePlacement
from trajopt.tasks import FollowCurve, Task
from trajopt.tasks.cartesian import (
    Begin,
    Curve,
    FollowOptions,
    follow,
    follows_curve,
    line,
    polyline,
    raster,
    read_poses,
    spline,
)
from trajopt.values.documents.document import write_json
from trajopt.verify import Evidence

UR5_READY = {
    f"{name}_joint": value
    for name, value in zip(
        ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"),
        (-0.245, -1.67, 1.875, -1.776, -1.571, -1.816),
        strict=True,
    )
}


def eight(width: float, depth: float) -> Curve:
    """A level figure-eight that begins in its crossing, the tool pointing down."""
    angle = np.linspace(0.0, 2.0 * np.pi, 33)
    return spline([at(depth * np.sin(2.0 * a), width * np.sin(a), 0.0) for a in angle])


def test_a_big_figure_eight_with_the_tool_down() -> None:
    way = eight(0.25, 0.12)
    assert way.length > 1.2
    result = followed(way)
    assert result.complete
    assert result.deviation <= 1e-4
    points = tips(result, 4000)
    assert np.abs(points[:, 2] - ready().translation[2]).max() <= 1e-4
    assert np.ptp(points[:, 1]) == pytest.approx(0.5, abs=1e-3)


def test_a_letter_from_a_file(tmp_path: Path) -> None:
    """The M of the problem of writing, drawn in 18 cm."""
    corners = ((-0.5, -0.5), (-0.5, 0.5), (0.0, 0.0), (0.5, 0.5), (0.5, -0.5))
    origin = at(0.1, 0.0, -0.2).translation
    rows = [f"{origin[0] + 0.18 * x},{origin[1] + 0.18 * y},{origin[2]}" for x, y in corners]
    path = tmp_path / "letter.csv"
    path.write_text("x,y,z\n" + "\n".join(rows) + "\n")
    way = polyline(read_poses(path, rpy=(np.pi, 0.0, 0.0)))
    result = followed(way, options=FollowOptions(begin=Begin.ANY_BRANCH))
    assert result.complete
    assert len(way.poses) == 5
    write_json(tmp_path / "letter.json", result.as_dict())
    stored = read_trajectory(tmp_path / "letter.json")
    assert result.trajectory is not None
    assert stored.positions == pytest.approx(result.trajectory.positions)


def test_a_seam_at_steady_speed_with_a_free_spin() -> None:
    speed = to.tool_speed(TCP, linear=0.1, steady=0.02)
    way = polyline((at(), at(0.0, 0.15, 0.0), at(0.1, 0.3, 0.0)), blend=0.05)
    result = followed(way, spin=(0, 0, 1), options=FollowOptions(tool_speed=(speed,)))
    assert result.complete
    (steady,) = [check for check in result.require().certificate.checks if "steady" in check.name]
    assert steady.holds
    assert result.turn <= np.radians(0.1)


def test_an_arm_of_six_joints() -> None:
    ur5 = to.load("ur5")
    scene = to.Scene(ur5)
    begin = scene.placement_of("tool0", ur5.positions(UR5_READY))

    def there(*moved: float) -> to.Placement:
        return to.placement(begin.translation + np.array(moved), rotation=begin.rotation)

    def run(way: Curve, options: FollowOptions | None = None):
        return follow(
            scene,
            follows_curve("tool0", way),
            start=UR5_READY,
            group="manipulator",
            options=options or FollowOptions(),
        )

    assert run(polyline((begin, there(0.1, 0.2, 0.1), there(0.2, -0.2, 0.1)))).complete
    far = run(line(begin, there(0.8, 0.0, 0.0)))
    assert far.stop is not None
    assert far.stop.status is Status.OUT_OF_REACH
    assert far.verified
    assert far.fraction == pytest.approx(0.49, abs=0.03)
    below = line(there(0.0, -0.2, 0.1), there(0.0, 0.3, 0.1))
    assert run(below, FollowOptions(begin=Begin.ANY_BRANCH)).complete


def test_a_jump_between_branches_is_named(tmp_path: Path) -> None:
    """A wrist whose first and last axes fall together where the way turns sideways."""
    wrist = robot(
        tmp_path,
        link_xml("base"), link_xml("a"), link_xml("b"), link_xml("c"),
        joint_xml("first", "base", "a", axis="0 0 1"),
        joint_xml("middle", "a", "b", axis="0 1 0"),
        joint_xml("last", "b", "c", axis="0 0 1"),
    )  # fmt: skip
    way = polyline((to.placement(rpy=(0, 0.5, 0)), to.placement(), to.placement(rpy=(0.5, 0, 0))))
    result = follow(to.Scene(wrist), follows_curve("c", way), start={"middle": 0.5}, group="all")
    assert result.stop is not None
    assert result.stop.status is Status.BRANCH_JUMP
    assert result.stop.joint in {"first", "last"}
    assert result.stop.amount == pytest.approx(np.pi / 2.0, abs=0.05)
    assert result.stop.pose == 1
    assert result.fraction == pytest.approx(0.5, abs=0.01)
    straight = polyline((to.placement(rpy=(0, 0.5, 0)), to.placement(rpy=(0, -0.5, 0))))
    through = follow(to.Scene(wrist), follows_curve("c", straight), start={"middle": 0.5}, group="all")
    assert through.complete, "straight on there is no jump"


def test_motions_that_an_arm_of_few_joints_lacks_are_named(tmp_path: Path) -> None:
    """Two joints turn about z, one about y: the hand never tilts about x, and turns as it moves aside."""
    arm = robot(
        tmp_path,
        link_xml("base"), link_xml("a"), link_xml("b"), link_xml("hand"),
        joint_xml("pan", "base", "a"),
        joint_xml("nod", "a", "b", x=0.3, axis="0 1 0"),
        joint_xml("end", "b", "hand", kind="fixed", x=0.2),
    )  # fmt: skip
    begin = to.placement((0.5, 0.0, 0.0))

    def why(x: float, y: float, roll: float = 0.0, **options: float) -> str:
        end = begin * to.placement((x, y, 0.0), rpy=(roll, 0.0, 0.0))
        required = follows_curve("hand", line(begin, end), **options)
        stop = follow(to.Scene(arm), required, start={"pan": 0.0}, group="all").stop
        assert stop is not None
        assert stop.status is Status.OUT_OF_REACH
        return stop.message

    assert "needs the arm to turn hand about x of its axes there, which its 2 joints cannot" in why(0, 0, 0.5)
    assert "moves hand along y of its axes only while it turns about z" in why(0.0, 0.1)
    assert why(0.0, 0.1).endswith("; spin or rotation_tolerance frees its rotation")
    away = why(0.1, 0.0, rotation_tolerance=np.inf)
    assert "needs the arm to move hand along x of its axes there, which its 2 joints cannot" in away
    scene, fixed = to.Scene(arm), FollowOptions(begin=Begin.ANY_BRANCH)
    tilted = line(to.placement((0.5, 0.0, 0.0), rpy=(0.5, 0.0, 0.0)), to.placement((0.4, 0.0, 0.0)))
    nowhere = follow(scene, follows_curve("hand", tilted), start={"pan": 0.0}, group="all", options=fixed)
    assert nowhere.stop is not None
    assert "at the beginning of the curve: the nearest of the configurations" in nowhere.stop.message
    assert "2 joints move in group all, and the goal fixes 6 axes of hand" in nowhere.stop.message


def test_redundancy_is_used() -> None:
    """Held as it is, joint 1 would end at its limit; the others take over."""
    begin = {**panda().state("ready"), "panda_joint1": 2.6}
    scene = to.Scene(panda())
    start = scene.placement_of(TCP, panda().positions(begin))
    turn = to.placement(rpy=(0.0, 0.0, 0.35))
    end = to.placement(turn.rotation @ start.translation, rotation=turn.rotation @ start.rotation)
    result = follow(scene, follows_curve(TCP, line(start, end)), start=begin, group="panda_arm")
    assert result.complete
    assert result.trajectory is not None
    assert result.trajectory.positions[:, 0].max() <= 2.8973


def test_the_drawn_figure_eight_is_covered_whole() -> None:
    """The points of the problem of writing, as a curve to a tenth of a millimetre in place of stops."""
    drawn = to.named_problem("figure_eight_panda")
    asked = [item[0] for item in drawn.waypoint_requirements] + [drawn.goals[0]]
    points = [item.placement.translation for item in asked if isinstance(item, FramePlacement)]
    down = to.placement(rpy=(np.pi, 0.0, 0.0)).rotation
    way = spline([to.placement(point, rotation=down) for point in (points[-1], *points)])
    result = follow(
        drawn.scene,
        follows_curve(TCP, way),
        group=drawn.group,
        start=drawn.start_positions,
        options=FollowOptions(begin=Begin.ANY_BRANCH),
    )
    assert result.complete
    assert result.fraction == 1.0
    assert result.deviation <= 1e-4


def test_a_wide_cone_takes_no_more_work_than_a_narrow_one() -> None:
    way = line(at(0.0, -0.1, -0.1), at(0.1, 0.1, -0.1))
    narrow, wide = (
        followed(
            way,
            spin=(0, 0, 1),
            rotation_tolerance=np.radians(cone),
            options=FollowOptions(begin=Begin.ANY_BRANCH),
        )
        for cone in (0.1, 15.0)
    )
    assert narrow.complete
    assert wide.complete
    work = "forward_kinematics"
    assert wide.result.counts[work] < 1.5 * narrow.result.counts[work]


def test_rows_on_a_wall_by_arm_and_base() -> None:
    """A PR2 covers more than its arm reaches, at 0.2 m/s within 2 %."""
    past = to.named_problem("past_column_pr2")
    arm, tool = past.scene.robot, "brush"
    scene = to.Scene(arm).add("wall", to.Box(0.1, 3.0, 1.8), to.placement((1.25, 0.0, 0.9)))
    forward = to.placement(rpy=(0.0, np.pi / 2.0, 0.0))
    scene = scene.with_tool(tool, on="r_gripper_tool_frame", placement=forward)
    corners = np.array([(1.1, y, z) for y in (-0.7, 0.7) for z in (0.8, 1.0)])
    rows = raster(to.Mesh(corners, np.array([(0, 1, 2), (1, 3, 2)])), face=0, spacing=0.2, along=(0, 1, 0))
    steady = FollowOptions(tool_speed=(to.tool_speed(tool, linear=0.204, steady=0.0392),))
    stages = [FollowCurve(to.follows_curve(tool, row, spin=(0, 0, 1)), steady, off=0.03) for row in rows]
    found = to.plan(Task(scene=scene, group=past.group, start=past.start_positions, stages=stages))
    assert found.verified, found.explain()
    checks = [check for check in found.certificate.checks if "path: steady" in check.name]
    assert len(checks) == 2
    assert all(check.evidence is Evidence.PROVEN for check in checks)
    moved = np.ptp(found.trajectory.positions, axis=0)
    joints = dict(zip(found.trajectory.joint_names, moved.tolist(), strict=True))
    assert joints["world_joint/y"] > 0.5
    assert joints["r_shoulder_pan_joint"] > 0.1
