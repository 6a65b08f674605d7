"""The frame that a placement means for a group: of chains, of joints by name, and where there is no SRDF."""

from pathlib import Path

import pytest
import trajopt_robots
from trajopt_robots._example_robot_data import share_folder

import trajopt as to
from tests.robots_for_tests import ODD_ARM, odd_arm, two_arms
from trajopt.problem.requirements import FramePlacement
from trajopt.ros import commander
from trajopt.scene.group_tools import end_link, ends_of, tool_of
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.values.errors import ProblemError

SRDF = """<robot name="odd">
  <group name="by_joints">
    <joint name="pan"/><joint name="reach"/><joint name="elbow"/><joint name="wrist"/>
  </group>
  <group name="still"><link name="base"/></group>
</robot>"""


@pytest.fixture
def by_joints(tmp_path: Path) -> to.Scene:
    (tmp_path / "odd.srdf").write_text(SRDF)
    (tmp_path / "odd.urdf").write_text(ODD_ARM)
    return to.Scene(to.load(tmp_path / "odd.urdf", srdf=tmp_path / "odd.srdf"))


def test_a_group_of_named_joints_ends_at_the_link_of_the_last(by_joints: to.Scene) -> None:
    assert ends_of(by_joints, "by_joints") == ("tip",)
    there = by_joints.placement_of("tip", by_joints.robot.positions({"pan": 0.4}))
    problem = to.Problem(scene=by_joints, group="by_joints", start={}, goal=there)
    (goal,) = problem.goals
    assert isinstance(goal, FramePlacement) and goal.frame == "tip"
    assert to.plan(problem).verified


def test_a_tool_on_its_end_is_meant_and_one_on_its_way_is_not(by_joints: to.Scene) -> None:
    both = by_joints.with_tool("tcp", on="tip").with_tool("camera", on="slide")
    assert tool_of(both, "by_joints") == "tcp"


def test_the_frame_of_a_sensor_in_the_hand_is_not_its_tool_centre_point(tmp_path: Path) -> None:
    sensor = (
        '<link name="force_sensor"/><joint name="f" type="fixed"><parent link="panda_hand"/>'
        '<child link="force_sensor"/><origin xyz="0 0 0.01"/></joint></robot>'
    )
    described = share_folder() / "example-robot-data" / "robots" / "panda_description" / "urdf" / "panda.urdf"
    (tmp_path / "panda.urdf").write_text(described.read_text().replace("</robot>", sensor))
    robot = to.load(
        tmp_path / "panda.urdf",
        srdf=Path(trajopt_robots.__file__).parent / "panda" / "panda.srdf",
        package_dirs=[share_folder()],
    )
    assert tool_of(to.Scene(robot), "panda_arm") == "panda_hand_tcp"


def test_without_groups_one_chain_ends_where_no_joint_follows(tmp_path: Path) -> None:
    """Before, the last link of the file was taken, whatever moved it."""
    glued = '<joint name="glued" type="fixed"><parent link="slide"/><child link="label"/></joint></robot>'
    (tmp_path / "arm.urdf").write_text(ODD_ARM.replace("</robot>", f'<link name="label"/>{glued}'))
    assert to.load(tmp_path / "arm.urdf").group("all").tip == "finger"
    assert odd_arm(tmp_path).group("all").tip == "finger"


def test_without_groups_the_arm_ends_before_its_gripper(tmp_path: Path) -> None:
    follows = '<mimic joint="wrist" multiplier="-0.5" offset="0.2"/>'
    assert follows in ODD_ARM
    (tmp_path / "arm.urdf").write_text(ODD_ARM.replace(follows, ""))
    assert to.load(tmp_path / "arm.urdf").group("all").tip == "tip"


def test_without_groups_two_arms_have_no_single_end(tmp_path: Path) -> None:
    robot = two_arms(tmp_path)
    (tmp_path / "bare.urdf").write_text(robot.urdf_xml)
    bare = to.Scene(to.load(tmp_path / "bare.urdf"))
    assert bare.robot.group("all").tip is None
    with pytest.raises(ProblemError, match="its ends are left_hand, right_hand"):
        tool_of(bare, "all")


def test_degrees_in_a_script_for_moveit_are_likely_meant(by_joints: to.Scene) -> None:
    with commander.World(by_joints.robot):
        group = commander.MoveGroupCommander("by_joints")
        with pytest.raises(MoveItCommanderException, match="; were degrees meant\\? Angles are"):
            group.set_joint_value_target({"elbow": 90.0})


def test_one_link_is_the_end_of_a_group_that_has_joints(by_joints: to.Scene) -> None:
    assert end_link(by_joints.robot, "by_joints") == "tip"
    assert end_link(by_joints.robot, "still") == ""


def test_a_group_without_joints_is_printed(by_joints: to.Scene) -> None:
    assert repr(by_joints.robot.group("still")) == "Group('still', 0 joints)"
