"""Programs for Universal Robots, executed by a small interpreter."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import trajopt as to
from tests.files.export.urscript import CALL, Controller, Halted
from trajopt.files.export import Movej, Servoj, UrProgram, export
from trajopt.files.export.urscript import UR_JOINTS
from trajopt.optimise.kinematics import forward_kinematics
from trajopt.tasks import AttachObject, DetachObject, Dwell, FollowCurve, MoveTo, Task, TaskResult
from trajopt.tasks.cartesian import Begin, FollowOptions, follow, follows_curve, line, polyline
from trajopt.timing.time_scaling import begun_later
from trajopt.values.arrays import Floats
from trajopt.values.errors import ShapeError

START = np.array((0.0, -1.57, 1.2, -0.5, 0.3, 0.1))
END = np.array((1.1, -1.0, 0.7, -1.5, 0.3, -0.2))


@pytest.fixture
def motion() -> to.Trajectory:
    """From rest to rest, its joints in another order than URScript's, with a prefix."""
    via = (START + END) / 2 + np.array((0.0, 0.3, -0.2, 0.0, 0.1, 0.0))
    rows = np.array((START, via, END))
    speeds = np.array((np.zeros(6), (END - START) / 2.0, np.zeros(6)))
    flipped = tuple(f"left_{name}" for name in reversed(UR_JOINTS))
    return to.Trajectory(
        flipped, np.array((0.0, 1.0, 2.003)), rows[:, ::-1], speeds[:, ::-1], np.zeros((3, 6))
    )


def ordered(motion: to.Trajectory, t: float) -> Floats:
    return motion(t)[::-1]


def test_servoj_streams_the_motion_in_time(motion: to.Trajectory, tmp_path: Path) -> None:
    exported = export(motion, tmp_path / "m.script", to="urscript")
    arm = Controller(START)
    arm.run((tmp_path / "m.script").read_text())
    for time, joints in arm.visited:
        reached = ordered(motion, time)
        assert np.abs(joints - reached).max() < 1e-8, time
    assert [time for time, _ in arm.visited[:3]] == pytest.approx([0.008, 0.016, 0.024])
    assert arm.stopped and np.array_equal(arm.joints, END)
    assert motion.duration + 0.1 <= arm.time <= motion.duration + 0.1 + 2 * 0.008
    assert exported.duration == pytest.approx(arm.time)


def test_speeds_of_the_stream_are_within_those_of_the_motion(motion: to.Trajectory, tmp_path: Path) -> None:
    fastest = np.abs(motion(np.linspace(0.0, 2.003, 20001), 1)).max(axis=0)[::-1]
    for hz in (None, 500.0, 50.0):
        export(motion, tmp_path / "m.script", to=Servoj(lookahead_time=0.05), hz=hz)
        arm = Controller(START)
        arm.run((tmp_path / "m.script").read_text())
        rows = np.array([START, *(joints for _, joints in arm.visited)])
        steps = np.diff([0.0, *(time for time, _ in arm.visited)])[:, None]
        assert (np.abs(np.diff(rows, axis=0) / steps).max(axis=0) <= fastest + 1e-6).all()


def test_movej_waits_as_long_as_the_motion_does(motion: to.Trajectory, tmp_path: Path) -> None:
    later = begun_later(motion, 0.8)
    written = export(later, tmp_path / "m.script", to="urscript-movej")
    lines = (tmp_path / "m.script").read_text().split("\n")
    (wait,) = (line.strip() for line in lines if "sleep(" in line)
    assert 0.75 <= float(wait.removeprefix("sleep(").removesuffix(")")) <= 0.85
    assert any("waits 0." in note for note in written.notes)
    export(motion, tmp_path / "at_once.script", to="urscript-movej")
    assert "sleep(" not in (tmp_path / "at_once.script").read_text()


UR5_READY = dict(zip(UR_JOINTS, (0.0, -1.2, 1.6, -1.97, -1.57, 0.0), strict=True))


@pytest.fixture(scope="module")
def polished() -> TaskResult:
    """A part is taken by suction and led along a corner."""
    arm = to.load("ur5")
    scene = to.Scene(arm)
    here = scene.placement_of("tool0", arm.positions(UR5_READY))
    scene = scene.add("part", to.Box(0.02, 0.02, 0.02), here * to.placement((0.0, 0.0, 0.02)))
    corners = [here, here * to.placement((0.05, 0.0, 0.0)), here * to.placement((0.05, 0.05, 0.0))]
    steady = (to.tool_speed("tool0", linear=0.05),)
    options = FollowOptions(begin=Begin.ANY_BRANCH, tool_speed=steady)
    curve = follows_curve("tool0", polyline(corners, blend=0.01), offset=(0.0, 0.0, 0.04))
    stages = [
        MoveTo(UR5_READY),
        AttachObject("part", "tool0", touch_links=("wrist_3_link",)),
        Dwell(0.3),
        FollowCurve(curve, options=options, name='edge "A"'),
        DetachObject("part"),
        MoveTo(dict(zip(UR_JOINTS, START, strict=True)), name="home"),
    ]
    result = to.plan(Task(scene=scene, group="manipulator", start=UR5_READY, stages=stages))
    assert result.verified, result.explain()
    return result


def called(text: str, *names: str) -> list[tuple[str, str]]:
    """Return the calls of a program, in order."""
    found = [CALL.fullmatch(line.strip()) for line in text.splitlines()]
    return [(each[1], each[2]) for each in found if each is not None and each[1] in names]


def test_a_program_has_sections_with_outputs_and_curves(polished: TaskResult, tmp_path: Path) -> None:
    path = tmp_path / "m.script"
    export(polished, path, to=UrProgram(grip=2, process=3))
    calls = called(
        path.read_text(), "set_standard_digital_out", "movel", "movep", "set_tcp", "sleep", "stopj"
    )
    kinds = [name + (f"({words})" if "out" in name else "") for name, words in calls]
    on, off = "set_standard_digital_out(2, True)", "set_standard_digital_out(2, False)"
    before, after = "set_standard_digital_out(3, True)", "set_standard_digital_out(3, False)"
    legs = kinds.count("movep")
    ahead = kinds[: kinds.index("set_tcp")]
    assert [name for name in ahead if name != "stopj"] == [on, "sleep"]
    assert kinds[len(ahead) :] == ["set_tcp", "movel", before, *["movep"] * legs, after, off, "stopj"]
    assert 3 <= legs < 60
    (tool,) = (words for name, words in calls if name == "set_tcp")
    np.testing.assert_allclose(pose(tool), (0, 0, 0.04, 0, 0, 0), atol=1e-9)


def pose(words: str) -> Floats:
    return np.array([float(each) for each in words.removeprefix("p[").partition("]")[0].split(",")])


def test_the_lines_of_a_program_follow_the_curve(polished: TaskResult, tmp_path: Path) -> None:
    path = tmp_path / "m.script"
    export(polished, path, to=UrProgram(tolerance=2e-4, blend=5e-4))
    (plan,) = (each.result.require() for each in polished.segments if each.stages == ('edge "A"',))
    motion, reduced = plan.trajectory, plan.problem.reduced
    rows = motion(np.linspace(0.0, motion.duration, 4000))
    seen = forward_kinematics(reduced, "tool0", rows, reference="base", offset=(0.0, 0.0, 0.04))
    lines = [words for _, words in called(path.read_text(), "movel", "movep")]
    tips = np.array([pose(words)[:3] for words in lines])
    assert np.linalg.norm(seen.translation[:, None] - tips, axis=-1).min(axis=0).max() < 3e-5
    share = np.linspace(0.0, 1.0, 30)[:, None]
    between = np.concatenate([a + share * (b - a) for a, b in pairwise(tips)])
    apart = np.linalg.norm(seen.translation[:, None] - between, axis=-1)
    assert apart.min(axis=0).max() < 4e-4 and apart.min(axis=1).max() < 1.5e-3
    turned = Rotation.from_rotvec(pose(lines[-1])[3:]).as_matrix()
    np.testing.assert_allclose(turned, seen.rotation[-1], atol=1e-6)
    np.testing.assert_allclose(given(lines, "v"), 0.05, rtol=0.02)
    text = path.read_text()
    assert 'popup("Grip part, then continue."' in text and "# edge  A \n" in text


def given(lines: list[str], name: str) -> Floats:
    return np.array([float(words.partition(f"{name}=")[2].partition(",")[0]) for words in lines])


def test_no_joint_goes_faster_along_a_curve_than_in_the_motion(tmp_path: Path) -> None:
    arm = to.load("ur5")
    scene, start = to.Scene(arm), dict(zip(UR_JOINTS, (-0.72, -1.05, 1.94, -1.44, -0.47, 0.02), strict=True))
    here = scene.placement_of("tool0", arm.positions(start))
    there = to.placement((0.72, -0.54, 0.12), rpy=np.deg2rad((132.3, -1.9, 142.2)))
    plan = follow(
        scene, follows_curve("tool0", line(here, there)), group="manipulator", start=start
    ).require()
    written = export(plan, tmp_path / "m.script", to="urscript-program")
    lines = [words for _, words in called((tmp_path / "m.script").read_text(), "movel", "movep")]
    rows = plan.trajectory(np.linspace(0.0, plan.trajectory.duration, 4001))
    seen = forward_kinematics(plan.problem.reduced, "tool0", rows, reference="base").translation
    tips = np.array([pose(words)[:3] for words in lines])
    corners = np.linalg.norm(seen[:, None] - tips, axis=-1).argmin(axis=0)
    peaks = np.abs(plan.trajectory(plan.trajectory.times, 1)).max(axis=0)
    lasting = 0.0
    for speed, (a, b) in zip(given(lines, "v")[1:], pairwise(corners), strict=True):
        steps = np.linalg.norm(np.diff(seen[a : b + 1], axis=0), axis=1)
        turned = np.abs(np.diff(rows[a : b + 1], axis=0))[steps > 1e-6]
        assert (turned / steps[steps > 1e-6, None] * speed < 1.05 * peaks).all()
        lasting += steps.sum() / speed
    assert lasting < written.duration < lasting + 1.0


def test_a_program_begins_each_stream_where_the_motion_does(polished: TaskResult, tmp_path: Path) -> None:
    path = tmp_path / "m.script"
    export(polished, path, to="urscript-program")
    starts = [pose(words.removeprefix("[")) for name, words in called(path.read_text(), "movej")]
    streamed = [each for each in polished.segments if each.stages != ('edge "A"',)]
    planned = [each.trajectory.ordered(UR_JOINTS).positions[0] for each in streamed]
    np.testing.assert_allclose(starts, planned, atol=1e-8)


def test_outputs_that_are_not_there_are_refused() -> None:
    with pytest.raises(ShapeError, match="grip: must be from 0 to 7, is 8"):
        UrProgram(grip=8)


def test_one_line_is_reported_in_the_singular(motion: to.Trajectory, tmp_path: Path) -> None:
    straight = motion.between(0.0, 1e-3)
    assert "\n  1 straight line in joint space" in str(
        export(straight, tmp_path / "m.script", to="urscript-movej")
    )


def test_movej_stays_near_and_ends_at_rest_at_the_end(motion: to.Trajectory, tmp_path: Path) -> None:
    for tolerance in (0.05, 0.01):
        export(motion, tmp_path / "m.script", to=Movej(tolerance=tolerance, blend=0.01))
        arm = Controller(START)
        arm.run((tmp_path / "m.script").read_text())
        assert np.array_equal(arm.joints, END) and arm.radii[-1] == 0.0
        assert len(arm.radii) > 2 and set(arm.radii[:-1]) == {0.01}
        corners = np.array([START, *(joints for _, joints in arm.visited)])
        lines = np.concatenate([np.linspace(a, b, 400) for a, b in pairwise(corners)])
        for t in np.linspace(0.0, motion.duration, 300):
            assert np.abs(lines - ordered(motion, t)).max(axis=1).min() <= tolerance + 1e-3


def test_speed_and_acceleration_of_each_line_are_within_the_motions(
    motion: to.Trajectory, tmp_path: Path
) -> None:
    export(motion, tmp_path / "m.script", to="urscript-movej")
    arm = Controller(START)
    arm.run((tmp_path / "m.script").read_text())
    dense = np.linspace(0.0, motion.duration, 20001)
    fastest, hardest = (np.abs(motion(dense, order)).max(axis=0)[::-1] * (1 + 1e-4) for order in (1, 2))
    for moved, speed, acceleration in arm.speeds:
        share = np.abs(moved) / np.abs(moved).max()
        assert (share * speed <= fastest + 1e-6).all() and (share * acceleration <= hardest + 1e-6).all()


@pytest.mark.parametrize("to_", ["urscript", "urscript-movej"])
def test_an_arm_that_is_elsewhere_does_not_move(motion: to.Trajectory, tmp_path: Path, to_: str) -> None:
    export(motion, tmp_path / "m.script", to=to_)
    for joint in range(6):
        arm = Controller(START + 0.02 * np.eye(6)[joint])
        with pytest.raises(Halted, match="not at the start"):
            arm.run((tmp_path / "m.script").read_text())
        assert not arm.visited


@pytest.mark.parametrize("to_", ["urscript", "urscript-movej"])
def test_losses_are_reported_in_file_and_summary(motion: to.Trajectory, tmp_path: Path, to_: str) -> None:
    exported = export(motion, tmp_path / "m.script", to=to_)
    text = (tmp_path / "m.script").read_text()
    assert text.startswith("def trajopt_motion():\n") and text.endswith("\nend\n")
    assert any(note.startswith("loses: ") for note in exported.notes)
    assert all(f"# {note}\n" in text and note in str(exported) for note in exported.notes)


@pytest.mark.parametrize(
    ("names", "says"),
    [
        (
            ("a", "b", "c"),
            "this motion has a, b, c: for other arms there are csv, ros2, ros2-topic and moveit",
        ),
        (
            (*UR_JOINTS[:5], "wrist_4_joint"),
            "this motion has no wrist_3_joint; URScript cannot move wrist_4_joint",
        ),
        ((*UR_JOINTS, "finger_joint"), "URScript cannot move finger_joint"),
        (
            (*UR_JOINTS[:5], "left_wrist_3_joint"),
            "this motion has no wrist_3_joint; .* cannot move left_wrist_3_joint",
        ),
        (("a_elbow_joint",), "this motion has a_elbow_joint: for other arms there are csv"),
    ],
)
def test_other_arms_are_refused(names: tuple[str, ...], says: str, tmp_path: Path) -> None:
    rows = np.zeros((2, len(names)))
    with pytest.raises(ShapeError, match=f"six joints of one UR arm .*{says}"):
        export(to.Trajectory(names, np.array((0.0, 1.0)), rows), tmp_path / "m.script", to="urscript")
    assert not list(tmp_path.iterdir())


def test_a_program_for_another_arm_is_refused_by_its_joints(tmp_path: Path) -> None:
    plan = to.plan(to.named_problem("planar_fold")).require()
    with pytest.raises(ShapeError, match=r"six joints of one UR arm .*has joint1, joint2: for other"):
        export(plan, tmp_path / "m.script", to="urscript-program")


def test_options_that_the_controller_does_not_take(motion: to.Trajectory, tmp_path: Path) -> None:
    for make, says in (
        (lambda: Servoj(lookahead_time=0.5), "lookahead_time: must be from 0.03 to 0.2"),
        (lambda: Servoj(gain=np.nan), "gain"),
        (lambda: Movej(blend=-0.1), "blend: must be from 0 to 1"),
        (lambda: Movej(tolerance=0.0), "tolerance"),
        (lambda: export(motion, tmp_path / "m", to="urscript-movej", hz=10.0), "hz: movej has no rate"),
        (lambda: export(motion, tmp_path / "m", to="urscript", hz=1000.0), "hz: .* 500"),
    ):
        with pytest.raises(ShapeError, match=says):
            make()


def test_constant_and_linear_motions_are_exported(tmp_path: Path) -> None:
    still = to.Trajectory(UR_JOINTS, np.array((0.0, 1.0)), np.array((START, START)))
    line = to.Trajectory(UR_JOINTS, np.array((0.0, 1.0)), np.array((START, END)))
    for name in ("urscript", "urscript-movej"):
        for motion, end in ((still, START), (line, END)):
            export(motion, tmp_path / "m.script", to=name)
            arm = Controller(START)
            arm.run((tmp_path / "m.script").read_text())
            assert np.array_equal(arm.joints, end)
