"""What a description says that a robot does not have is left out, and said: `Robot.notes`."""

import re
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.robots_for_tests import ODD_ARM, odd_arm, two_arms
from trajopt.files.moveit import read_request
from trajopt.robot.joints import draw_positions
from trajopt.values.errors import (
    FileFormatError,
    GroupNotFound,
    JointNotFound,
    MeshFileError,
    ModelError,
    ShapeError,
    StateNotFound,
)
from trajopt.values.shapes.shapes import Box, Cylinder

ARM = '<group name="arm"><chain base_link="base" tip_link="tip"/></group>'


def with_srdf(folder: Path, inner: str) -> to.Robot:
    """Return the odd arm with an SRDF."""
    odd_arm(folder)
    (folder / "odd.srdf").write_text(f'<robot name="odd">{inner}</robot>')
    return to.load(folder / "odd.urdf", srdf=folder / "odd.srdf")


def test_a_description_without_fault_needs_no_note(tmp_path: Path) -> None:
    assert odd_arm(tmp_path).notes == two_arms(tmp_path).notes == ()
    state = '<group_state name="bent" group="arm"><joint name="wrist" value="0.4"/></group_state>'
    fixed = '<virtual_joint name="world" type="fixed" parent_frame="map" child_link="base"/>'
    robot = with_srdf(tmp_path, ARM + state + fixed)
    assert robot.notes == () and robot.left_out == {}


GROUPS = {
    "an unknown joint": ('<joint name="wirst"/>', r"no joint \(in group 'odd'\) named 'wirst'.*mean 'wrist'"),
    "an unknown link": ('<link name="tpi"/>', r"no link .*'tpi'"),
    "a chain to an unknown link": ('<chain base_link="base" tip_link="hand"/>', r"no link .*'hand'"),
    "a chain upwards": ('<chain base_link="tip" tip_link="base"/>', r"no base link .*'tip'"),
    "an unknown group": ('<group name="legs"/>', r"no subgroup .*'legs'"),
    "itself": ('<group name="odd"/>', r"no subgroup .*'odd'"),
    "nothing": ("", "it is empty"),
}


@pytest.mark.parametrize("inner,reason", GROUPS.values(), ids=GROUPS)
def test_a_group_with_unknown_members_is_omitted_with_a_reason(
    tmp_path: Path, inner: str, reason: str
) -> None:
    robot = with_srdf(tmp_path, f'{ARM}<group name="odd">{inner}</group>')
    assert list(robot.groups) == ["arm"]
    (note,) = robot.notes
    assert re.match(rf"group 'odd' is left out: {reason}", note)
    with pytest.raises(GroupNotFound, match=f"no group named 'odd'; it was left out: {reason}"):
        robot.group("odd")
    with pytest.raises(GroupNotFound, match=f"it was left out: {reason}"):
        to.Problem(scene=to.Scene(robot), group="odd", start={}, goal=to.joint_positions({"wrist": 0.1}))
    with pytest.raises(GroupNotFound, match="did you mean 'arm'"):
        robot.group("amr")


def test_groups_that_include_an_omitted_group_are_omitted(tmp_path: Path) -> None:
    legs = '<group name="legs"><joint name="knee"/></group>'
    both = '<group name="both"><group name="arm"/><group name="legs"/></group>'
    robot = with_srdf(tmp_path, ARM + legs + both)
    assert list(robot.groups) == ["arm"]
    assert set(robot.left_out) == {"legs", "both"}
    assert "'knee'" in robot.left_out["both"]


def test_where_no_group_is_left_all_joints_are_one(tmp_path: Path) -> None:
    robot = with_srdf(tmp_path, '<group name="legs"><joint name="knee"/></group>')
    assert robot.group("all").joints == ("pan", "reach", "elbow", "wrist")
    assert robot.notes[1] == "no group of the SRDF is left: all joints are in one named 'all'"
    request = tmp_path / "request.yaml"
    request.write_text(
        "{group_name: legs, goal_constraints: [{joint_constraints: [{joint_name: wrist, position: 0}]}]}"
    )
    with pytest.raises(GroupNotFound, match=r"group_name.*'legs'; it was left out: no joint"):
        read_request(request, to.Scene(robot))


def test_a_state_without_a_group_or_of_one_that_is_not_there_is_left_out(tmp_path: Path) -> None:
    joint = '<joint name="wrist" value="0.4"/>'
    robot = with_srdf(
        tmp_path,
        f'{ARM}<group_state name="loose">{joint}</group_state>'
        f'<group_state name="kneeling" group="legs">{joint}</group_state>'
        f'<group_state name="bent" group="arm">{joint}</group_state>',
    )
    assert robot.notes == (
        "state 'loose' is left out: it names no group",
        "state 'kneeling' is left out: its group 'legs' is left out or is not there",
    )
    assert list(robot.states) == [("arm", "bent")]
    for name in ("loose", "kneeling"):
        with pytest.raises(StateNotFound, match=f"named '{name}'; it was left out: its|it names no group"):
            robot.positions(name)
    with pytest.raises(StateNotFound, match="did you mean 'bent'"):
        robot.positions("bnet")


def test_a_state_is_without_the_joints_that_cannot_be_in_it(tmp_path: Path) -> None:
    robot = with_srdf(
        tmp_path,
        f'{ARM}<group_state name="standing" group="arm"><joint name="root_joint" value="0 0 0.5 0 0 0 1"/>'
        '<joint name="turret" value="1"/><joint name="wrist" value="0.4"/></group_state>',
    )
    assert robot.state("standing") == {"wrist": 0.4}
    assert robot.notes == (
        "root_joint has no single number and is left out of the named states: standing",
        "state 'standing' is without turret: the robot has no such joint",
    )


def test_a_state_that_contradicts_a_mimic_joint_is_noted(tmp_path: Path) -> None:
    state = '<group_state name="{}" group="arm"><joint name="wrist" value="0.4"/>{}</group_state>'
    follow = '<joint name="follow" value="{}"/>'
    robot = with_srdf(
        tmp_path, ARM + state.format("good", follow.format(0.0)) + state.format("bad", follow.format(0.3))
    )
    assert robot.notes == ("state 'bad' puts follow at 0.3, but it follows wrist to 0: it follows",)
    assert robot.positions("bad") == pytest.approx(robot.positions("good"))


def test_other_elements_with_unknown_names_are_noted(tmp_path: Path) -> None:
    robot = with_srdf(
        tmp_path,
        f'{ARM}<end_effector name="claw" group="arm" parent_link="palm"/>'
        '<end_effector name="gone" group="claws" parent_link="tip"/>'
        '<end_effector name="kept" group="arm" parent_link="tip"/>'
        '<disable_collisions link1="tip" link2="palm"/><disable_collisions link1="base" link2="tip"/>'
        '<passive_joint name="wheel"/>',
    )
    assert robot.notes == (
        "end effector 'claw' is left out: there is no link 'palm'",
        "end effector 'gone' is left out: there is no group 'claws'",
        "<disable_collisions> names links that the robot does not have: palm",
        "<passive_joint> names joints that the robot does not have: wheel",
    )
    assert list(robot.end_effectors) == ["kept"]
    assert frozenset(("base", "tip")) in robot.disabled_pairs
    assert all(pair <= set(robot.links) for pair in robot.disabled_pairs)


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_a_movable_base_is_fixed_at_its_pose(tmp_path: Path, kind: str) -> None:
    root = f'<virtual_joint name="root" type="{kind}" parent_frame="odom" child_link="base"/>'
    body = '<group name="body"><joint name="root"/><group name="arm"/></group>'
    robot = with_srdf(
        tmp_path,
        ARM + body + root + '<group name="base"><joint name="root"/></group><passive_joint name="root"/>',
    )
    assert robot.group("body").joints == robot.group("arm").joints
    assert any("root" in note and kind in note for note in robot.notes)
    with pytest.raises(GroupNotFound, match=r"'base'; it was left out: .*root, which does not move"):
        robot.group("base")


def test_missing_visual_meshes_are_noted_and_collision_shapes_drawn(tmp_path: Path) -> None:
    visual = '<visual><geometry><mesh filename="package://odd/{}.dae"/></geometry></visual>'
    seen = '<visual><geometry><box size="1 2 3"/></geometry></visual>'
    text = ODD_ARM.replace('<link name="turret">', '<link name="turret">' + visual.format("turret") + seen)
    text = text.replace('<link name="fore">', '<link name="fore">' + seen)
    (tmp_path / "odd.urdf").write_text(text)
    robot = to.load(tmp_path / "odd.urdf")
    assert robot.notes == (
        "visual meshes are missing, collision shapes are drawn instead: 'package://odd/turret.dae' of turret",
    )
    drawn = {visual.link: visual.geometry for visual in robot.visuals}
    assert isinstance(drawn["turret"], Cylinder) and isinstance(drawn["fore"], Box)
    (tmp_path / "odd.urdf").write_text(text.replace("visual>", "collision>"))
    with pytest.raises(MeshFileError, match="turret"):
        to.load(tmp_path / "odd.urdf")


def test_a_robot_without_a_name_is_called_after_its_file(tmp_path: Path) -> None:
    (tmp_path / "nameless.urdf").write_text(ODD_ARM.replace(' name="odd"', "", 1))
    robot = to.load(tmp_path / "nameless.urdf")
    assert robot.name == "nameless"
    assert robot.notes == ("the file gives the robot no name; it is called 'nameless'",)


def test_a_file_without_a_link_describes_no_robot(tmp_path: Path) -> None:
    (tmp_path / "empty.urdf").write_text("<robot/>")
    with pytest.raises(FileFormatError, match=r"empty\.urdf: has no <link>, so it describes no robot"):
        to.load(tmp_path / "empty.urdf")


def test_joints_without_an_effort_limit_are_noted(tmp_path: Path) -> None:
    text = ODD_ARM.replace('effort="80"', 'effort="0"').replace('effort="5"', 'effort="0"')
    (tmp_path / "odd.urdf").write_text(text)
    robot = to.load(tmp_path / "odd.urdf")
    assert robot.notes == ("no effort limit is stated, or 0, so torque is not limited: pan",)
    assert robot.limits.effort[0] == np.inf, "what follows has no motor of its own, and nothing is said of it"
    limits = tmp_path / "limits.yaml"
    limits.write_text("joint_limits: {pan: {has_effort_limits: true, max_effort: 20}}")
    assert to.load(tmp_path / "odd.urdf", limits=limits).notes == ()


def test_implausibly_low_effort_limits_are_noted(tmp_path: Path) -> None:
    (tmp_path / "odd.urdf").write_text(ODD_ARM.replace('effort="60"', 'effort="0.6"'))
    robot = to.load(tmp_path / "odd.urdf")
    (note,) = robot.notes
    assert re.fullmatch(r"effort limits that do not hold .*: elbow \(0\.6 of [0-9.]+ Nm\); .*scaling.*", note)
    needed = float(note.split(" of ")[1].split()[0])
    rng = np.random.default_rng(1)
    data, still = robot.model.createData(), np.zeros(robot.model.nv)
    held = [
        abs(float(pin.rnea(robot.model, data, robot.configuration(posture), still, still)[2]))
        for posture in draw_positions(robot.limits, 2000, rng=rng)
    ]
    assert needed == pytest.approx(np.median(held), rel=0.2)


def test_limits_of_torque_are_scaled_or_turned_off(tmp_path: Path) -> None:
    robot = odd_arm(tmp_path)
    stronger = robot.with_torque_scaling(1.5, joints=["pan", "wrist"])
    assert stronger.limits.effort == pytest.approx(robot.limits.effort * (1.5, 1, 1, 1.5, 1))
    assert stronger.notes == ("torque limits of pan, wrist are multiplied by 1.5",)
    free = to.load(tmp_path / "odd.urdf", torque_scaling=np.inf)
    assert np.isinf(free.limits.effort).all() and np.array_equal(free.limits.velocity, robot.limits.velocity)
    assert free.notes == ("torque limits of all joints are turned off",)
    assert np.isfinite(robot.limits.effort).all()
    for wrong in (0.0, -1.0, np.nan):
        with pytest.raises(ShapeError, match="scaling"):
            robot.with_torque_scaling(wrong)
    with pytest.raises(JointNotFound, match="wrist"):
        robot.with_torque_scaling(2.0, joints=["wirst"])


def test_a_motion_that_needs_more_torque_is_planned_with_limits_turned_off(tmp_path: Path) -> None:
    (tmp_path / "odd.urdf").write_text(ODD_ARM.replace('effort="60"', 'effort="0.6"'))
    for scaling in (1.0, np.inf):
        robot = to.load(tmp_path / "odd.urdf", torque_scaling=scaling)
        problem = to.Problem(scene=to.Scene(robot), start={}, goal=to.joint_positions({"pan": 1.0}))
        result = to.plan(problem)
        assert result.verified is (scaling == np.inf), result.reason


def test_limits_that_leave_a_joint_no_position_are_refused(tmp_path: Path) -> None:
    odd_arm(tmp_path)
    limits = tmp_path / "limits.yaml"
    limits.write_text("joint_limits: {elbow: {has_position_limits: true, min_position: 2.7}}")
    with pytest.raises(ModelError, match=r"'elbow': its position limits 2\.7 and 2\.5 leave it no position"):
        to.load(tmp_path / "odd.urdf", limits=limits)


FINGERED = """<robot name="fingered"><link name="base"/><link name="arm"/><link name="{link}"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="{joint}" type="prismatic"><parent link="arm"/><child link="{link}"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.1" effort="1" velocity="1"/></joint></robot>"""


@pytest.mark.parametrize(
    ("joint", "link", "looks"),
    [
        ("jointGripper", "mover", True),
        ("slide", "left_finger", True),
        ("slide", "gripper", False),
        ("gripper_roll_joint", "tool", False),
        ("lift", "tool", False),
    ],
)
def test_a_gripper_in_the_group_of_all_joints_is_noted(
    tmp_path: Path, joint: str, link: str, looks: bool
) -> None:
    (tmp_path / "arm.urdf").write_text(FINGERED.format(joint=joint, link=link))
    said = (
        "no groups are named, so all joints are in group 'all' and are planned together, "
        f"including likely joints of a gripper: {joint}"
    )
    assert (said in to.load(tmp_path / "arm.urdf").notes) is looks
    group = '<group name="arm"><joint name="turn"/></group>'
    (tmp_path / "arm.srdf").write_text(f'<robot name="fingered">{group}</robot>')
    assert said not in to.load(tmp_path / "arm.urdf", srdf=tmp_path / "arm.srdf").notes
