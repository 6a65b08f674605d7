"""The gripper of a description: measured openings, directions, forces; and what is none."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.tasks.grasping import Gripper, grasps_of, gripper_of, pick
from trajopt.values.errors import GripperError, NameNotFound, ShapeError

LIMIT = '<limit lower="{}" upper="{}" effort="{}" velocity="0.1"/>'


def jaw(
    folder: Path, *, fingers: int = 2, effort: float = 40.0, span: tuple[float, float] = (0.0, 0.05)
) -> to.Robot:
    """A hand with independent fingers on an arm of one joint; each pad stands 1 cm off its own origin."""
    palm = '<collision><geometry><box size="0.04 0.2 0.02"/></geometry></collision>'
    links = f'<link name="base"/><link name="wrist"/><link name="hand">{palm}</link><link name="tip"/>'
    joints = (
        '<joint name="turn" type="revolute"><parent link="base"/><child link="wrist"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="5" velocity="1"/></joint>'
        '<joint name="mount" type="fixed"><parent link="wrist"/><child link="hand"/></joint>'
        '<joint name="tip_joint" type="fixed"><parent link="hand"/><child link="tip"/>'
        '<origin xyz="0 0 0.08"/></joint>'
    )
    for k in range(fingers):
        side = 1 - 2 * (k % 2)
        links += (
            f'<link name="finger{k}"><collision><origin xyz="0 {side * 0.01} 0.05"/>'
            '<geometry><box size="0.01 0.01 0.06"/></geometry></collision></link>'
        )
        joints += (
            f'<joint name="slide{k}" type="prismatic"><parent link="hand"/><child link="finger{k}"/>'
            f'<axis xyz="0 {side} 0"/>{LIMIT.format(*span, effort)}</joint>'
        )
    (folder / "jaw.urdf").write_text(f'<robot name="jaw">{links}{joints}</robot>')
    names = "".join(f'<joint name="slide{k}"/>' for k in range(fingers))
    listed = "".join(f'<link name="finger{k}"/>' for k in range(fingers))
    (folder / "jaw.srdf").write_text(
        '<robot name="jaw"><group name="arm"><chain base_link="base" tip_link="tip"/></group>'
        f'<group name="jaws"><link name="hand"/>{names}{listed}</group>'
        '<end_effector name="jaws" group="jaws" parent_link="wrist" parent_group="arm"/></robot>'
    )
    return to.Robot.from_urdf(folder / "jaw.urdf", srdf=folder / "jaw.srdf")


def test_panda_opens_twice_as_far_as_a_finger_moves(gripper: Gripper) -> None:
    assert gripper.tool == "panda_hand_tcp"
    assert set(gripper.fingers) == {"panda_leftfinger", "panda_rightfinger"}
    for opening in (0.01, 0.033, 0.07):
        # The pads of the description overlap by 0.04 mm where the joint is at zero.
        assert gripper.joints_at(opening) == {
            "panda_finger_joint1": pytest.approx(opening / 2 + 2e-5, abs=1e-6)
        }
    np.testing.assert_allclose(gripper.approach, (0.0, 0.0, 1.0), atol=1e-9)
    np.testing.assert_allclose(np.abs(gripper.closing), (0.0, 1.0, 0.0), atol=1e-9)


def test_followers_follow(panda: to.Robot, gripper: Gripper) -> None:
    opened = gripper.opened(panda, panda.positions("ready"), 0.05)
    left, right = opened[panda.index(("panda_finger_joint1", "panda_finger_joint2"))]
    assert left == right
    assert gripper.opening_at(panda, opened) == pytest.approx(0.05, abs=1e-9)


def test_independent_fingers_share(tmp_path: Path) -> None:
    robot = jaw(tmp_path)
    gripper = gripper_of(robot)
    # Pads stand 1 cm off, half a centimetre thick: 1 cm apart where both joints are at zero.
    assert gripper.narrowest == pytest.approx(0.01, abs=1e-9)
    assert gripper.widest == pytest.approx(0.11, abs=1e-9)
    assert gripper.tool == "tip"
    assert gripper.joints_at(0.05) == {"slide0": pytest.approx(0.02), "slide1": pytest.approx(0.02)}


@pytest.mark.parametrize("force", [1.0, 25.0])
def test_pressing_does_the_work_of_the_pads(tmp_path: Path, gripper: Gripper, force: float) -> None:
    """Power of the motors equals force on each pad times how fast they come together."""
    for each in (gripper, gripper_of(jaw(tmp_path))):
        torques, step = each.pressing(0.03, force), 1e-4
        nearer, wider = each.joints_at(0.03 - step), each.joints_at(0.03 + step)
        work = sum(torque * (nearer[joint] - wider[joint]) for joint, torque in torques.items())
        assert work == pytest.approx(force * 2 * step, rel=1e-6)


def test_force_equals_the_motors_force(tmp_path: Path, gripper: Gripper) -> None:
    """One motor of 100 N drives both fingers of the Panda; each of the jaw's fingers has its own."""
    assert gripper.force == pytest.approx(50.0, rel=1e-6)
    assert gripper_of(jaw(tmp_path, effort=40.0)).force == pytest.approx(40.0, rel=1e-6)


def test_a_motor_of_the_default_force_of_a_grasp_is_enough(tmp_path: Path) -> None:
    """The measured force was 29.999999999999996 N, and every grasp of 30 N was refused."""
    for effort in (0.3, 30.0, 70.0):
        assert gripper_of(jaw(tmp_path, effort=effort, span=(0.0, 0.045))).force == effort


@pytest.mark.parametrize("name", ["ur5", "xarm7"])
def test_reports_a_robot_without_gripper(name: str) -> None:
    with pytest.raises(GripperError, match=f"gripper of robot '{name}' is not known.*end_effector.*Gripper"):
        gripper_of(to.load(name))


def test_of_two_hands_one_is_named() -> None:
    robot = to.load("two_pandas")
    with pytest.raises(GripperError, match="left_hand, right_hand"):
        gripper_of(robot)
    assert gripper_of(robot, end_effector="left_hand").tool == "left_panda_hand_tcp"
    with pytest.raises(NameNotFound, match="did you mean 'left_hand'"):
        gripper_of(robot, end_effector="lefthand")


def test_a_tool_frame_at_the_link_of_the_end_effector_gives_no_approach(tmp_path: Path) -> None:
    robot = jaw(tmp_path)
    with pytest.raises(GripperError, match=r"'(\w+)' is at '\1'.* no direction; name a frame"):
        gripper_of(robot, tool=next(iter(robot.end_effectors.values())).parent_link)


def test_a_finger_is_not_the_tool(tmp_path: Path) -> None:
    """Without a frame between the pads the farthest link on the last joint of the arm is a finger."""
    jaw(tmp_path)
    urdf, srdf = tmp_path / "jaw.urdf", tmp_path / "jaw.srdf"
    raised = urdf.read_text().replace('<axis xyz="0 1', '<origin xyz="0 0 0.09"/><axis xyz="0 1')
    urdf.write_text(raised)
    srdf.write_text(srdf.read_text().replace('tip_link="tip"', 'tip_link="hand"'))
    robot = to.Robot.from_urdf(urdf, srdf=srdf)
    with pytest.raises(GripperError, match=r"'finger0', is a finger; name a frame between the pads \(tool="):
        gripper_of(robot)
    assert gripper_of(robot, tool="tip").tool == "tip"


def test_of_a_linkage_the_farthest_links_are_the_fingers(tmp_path: Path) -> None:
    """Grippers of Robotiq and UFactory move six links."""
    plain = gripper_of(jaw(tmp_path))
    urdf, srdf = tmp_path / "jaw.urdf", tmp_path / "jaw.srdf"
    box = '<geometry><box size="0.01 0.01 0.02"/></geometry>'
    knuckles = "".join(
        f'<link name="knuckle{k}"><collision>{box}</collision></link>'
        f'<joint name="swing{k}" type="prismatic"><parent link="hand"/><child link="knuckle{k}"/>'
        f'<origin xyz="0 {0.01 * side} 0.01"/><axis xyz="0 {side} 0"/>'
        '<limit lower="0" upper="1" effort="1" velocity="1"/><mimic joint="slide0" multiplier="0.5"/></joint>'
        for k, side in enumerate((1, -1))
    )
    urdf.write_text(urdf.read_text().replace("</robot>", f"{knuckles}</robot>"))
    links = "".join(f'<link name="knuckle{k}"/><joint name="swing{k}"/>' for k in range(2))
    srdf.write_text(srdf.read_text().replace("</group><end", f"{links}</group><end"))
    found = gripper_of(to.Robot.from_urdf(urdf, srdf=srdf))
    assert found.fingers == plain.fingers and set(found.links) > {"knuckle0", "knuckle1"}
    np.testing.assert_allclose(found.openings, plain.openings, atol=1e-12)
    assert found.force == plain.force and found.joint_names == plain.joint_names


def test_three_fingers_are_not_a_parallel_gripper(tmp_path: Path) -> None:
    with pytest.raises(GripperError, match="should move two fingers"):
        gripper_of(jaw(tmp_path, fingers=3))


def test_a_finger_that_its_follower_stops_is_named(tmp_path: Path) -> None:
    """A PR2 of a public package: its gripper was refused for fingers that do not open."""
    jaw(tmp_path)
    urdf, srdf = tmp_path / "jaw.urdf", tmp_path / "jaw.srdf"
    limit = LIMIT.format(0.0, 0.05, 40.0)
    follows = f'<axis xyz="0 -1 0"/>{limit}<mimic joint="slide0" multiplier="-1"/>'
    urdf.write_text(urdf.read_text().replace(f'<axis xyz="0 -1 0"/>{limit}', follows))
    robot = to.Robot.from_urdf(urdf, srdf=srdf)
    named = r"joint slide0 cannot move: its range is empty \(the limit of slide1, which follows slide0\)"
    with pytest.raises(GripperError, match=named):
        gripper_of(robot)


def test_openings_out_of_range_are_refused(gripper: Gripper) -> None:
    with pytest.raises(ShapeError, match=r"0\.2 m is not between"):
        gripper.joints_at(0.2)


def test_a_described_gripper_is_checked(gripper: Gripper) -> None:
    from dataclasses import replace

    with pytest.raises(ShapeError, match="increasing"):
        replace(gripper, openings=gripper.openings[::-1])
    with pytest.raises(ShapeError, match="right angle"):
        replace(gripper, closing=(0.0, 1.0, 1.0))


def test_a_tool_of_the_scene_is_between_the_pads(panda: to.Robot) -> None:
    scene = to.Scene(panda).add("cup", to.Cylinder(0.03, 0.12), to.placement((0.5, -0.2, 0.06)))
    plain = gripper_of(panda)
    further = scene.with_tool("pads", on=plain.tool, placement=to.placement((0, 0, 0.01), rpy=(0, 0, np.pi)))
    found = gripper_of(further, tool="pads")
    assert found.tool == "pads" == gripper_of(further).tool and plain.tool not in further.tools
    assert found.approach == pytest.approx(plain.approach) and found.force == pytest.approx(plain.force)
    assert found.closing == pytest.approx(-plain.closing)
    with pytest.raises(to.TrajoptError, match="'pads'"):
        gripper_of(further, tool="pad")
    grasps = grasps_of(further, "cup", found)
    carried = pick(further, "cup", group="panda_arm", start="ready", grasps=grasps, gripper=found)
    assert carried.verified, carried.explain()
