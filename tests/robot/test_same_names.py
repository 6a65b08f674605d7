"""A link and a joint of the same name, as URDF allows: a frame by name is the link, a joint the joint."""

import re
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.robots_for_tests import ODD_ARM, odd_arm
from trajopt.lab.srdf import propose_srdf
from trajopt.robot.loading.pinocchio_model import link_placement
from trajopt.ros.commander.robot_states import joint_names, link_names
from trajopt.values.errors import ModelError

NEW = {"pan": "turret", "reach": "fore", "elbow": "base", "wrist": "tip", "follow": "slide"}
"""New names of the odd arm's joints: one is that of its own link, others those of links elsewhere."""
SRDF = """<robot name="odd">
  <group name="arm"><chain base_link="base" tip_link="tip"/></group>
  <group name="listed"><joint name="{elbow}"/><link name="slide"/></group>
  <group_state name="bent" group="arm"><joint name="{wrist}" value="0.7"/></group_state>
</robot>
"""


def robots(folder: Path) -> tuple[to.Robot, to.Robot]:
    """Return the odd arm, and the same with its joints named like links."""
    odd_arm(folder)
    text = re.sub(r'joint(.*?)="(\w+)"', lambda m: f'joint{m[1]}="{NEW.get(m[2], m[2])}"', ODD_ARM)
    assert 'joint name="fore"' in text and 'mimic joint="tip"' in text
    (folder / "same.urdf").write_text(text)
    (folder / "odd.srdf").write_text(SRDF.format(**{name: name for name in NEW}))
    (folder / "same.srdf").write_text(SRDF.format(**NEW))
    odd, same = (to.load(folder / f"{name}.urdf", srdf=folder / f"{name}.srdf") for name in ("odd", "same"))
    return odd, same


def test_groups_and_states_mean_the_joint_where_a_joint_is_meant(tmp_path: Path) -> None:
    odd, same = robots(tmp_path)
    assert same.joint_names == tuple(NEW[name] for name in odd.joint_names)
    for name, group in odd.groups.items():
        assert same.group(name).joints == tuple(NEW[joint] for joint in group.joints)
        assert same.group(name).links == group.links and same.group(name).tip == group.tip
        assert joint_names(same, same.group(name)) == [NEW[j] for j in joint_names(odd, group)]
        assert link_names(same, same.group(name)) == link_names(odd, group)
    assert same.positions("bent") == pytest.approx(odd.positions("bent"))
    assert same.links == odd.links and same.disabled_pairs == odd.disabled_pairs


def test_frames_by_name_are_links(tmp_path: Path) -> None:
    odd, same = robots(tmp_path)
    positions = np.array((0.3, 0.1, -0.4, 0.7, -0.15))
    for link in odd.links:
        assert link_placement(same.model, link, positions) == link_placement(odd.model, link, positions)
        assert same.frame(link) == odd.frame(link)


def test_the_motion_does_not_depend_on_names(tmp_path: Path) -> None:
    plans: list[to.Result] = []
    for robot in robots(tmp_path):
        scene = to.Scene(robot).add("post", to.Sphere(0.05), to.placement((0.3, 0.55, 0.4)))
        names = robot.group("listed").joints
        goal = to.joint_positions({robot.joint_names[0]: 1.2, names[-1]: -0.4})
        plans.append(to.plan(to.Problem(scene=scene, group="arm", start={}, goal=goal)))
        reduced = plans[-1].problem.reduced
        assert {frame.name for frame in reduced.model.frames} >= {*robot.links, *robot.joint_names}
    one, other = plans
    assert other.require().trajectory.positions == pytest.approx(one.require().trajectory.positions)


def test_a_robot_without_an_srdf(tmp_path: Path) -> None:
    odd, same = robots(tmp_path)
    groups = [propose_srdf(robot, rng=np.random.default_rng(0)).groups for robot in (odd, same)]
    assert [group.name for group in groups[0]] == [group.name for group in groups[1]]


def test_a_quadruped_whose_links_are_named_like_its_joints() -> None:
    share = Path(pin.__file__).parents[4] / "share" / "example-robot-data" / "robots"
    urdf = share / "anymal_c_simple_description" / "urdf" / "anymal.urdf"
    if not urdf.is_file():
        pytest.skip("example-robot-data is not installed")
    robot = to.load(urdf, package_dirs=[share.parents[1]])
    assert "LF_HAA" in robot.links and "LF_HAA" in robot.joint_names
    scene = to.Scene(robot)
    for link in robot.links:
        scene = scene.allow(link)  # without an SRDF all its links that overlap would be in collision
    problem = to.Problem(
        scene=scene,
        group="all",
        start={},
        goal=to.joint_positions({"LF_HAA": 0.2, "RH_KFE": 0.3}),
    )
    assert to.plan(problem).require()


def test_a_tool_frame_with_the_name_of_a_link_is_refused(tmp_path: Path) -> None:
    odd_arm(tmp_path)
    for name in ("tip", "world"):
        with pytest.raises(ModelError, match=name):
            to.Robot.from_urdf(tmp_path / "odd.urdf", frames={name: ("fore", to.placement())})


def test_a_state_holds_no_link(tmp_path: Path) -> None:
    odd_arm(tmp_path)
    text = SRDF.format(**{**{name: name for name in NEW}, "wrist": "turret"})
    (tmp_path / "odd.srdf").write_text(text)
    robot = to.load(tmp_path / "odd.urdf", srdf=tmp_path / "odd.srdf")
    assert robot.state("bent") == {}
    assert robot.notes == ("state 'bent' is without turret: the robot has no such joint",)
