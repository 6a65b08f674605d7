"""A whole SRDF: written, read back, and right."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.cli.test_commands import trajopt
from tests.conftest import PLANAR_ARM
from trajopt.lab.srdf import Confidence, PairVerdict, SrdfProposal, propose_srdf
from trajopt.optimise.kinematics import reduce_model, validity

QUICK = Confidence(share=2e-3, level=0.95)


def proposal_of(robot: to.Robot) -> SrdfProposal:
    return propose_srdf(robot, rng=np.random.default_rng(0), confidence=QUICK)


@pytest.fixture(scope="module")
def panda() -> to.Robot:
    try:
        return to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def proposal(panda: to.Robot) -> SrdfProposal:
    return proposal_of(panda)


def read_back(robot: to.Robot, proposal: SrdfProposal, folder: Path) -> to.Robot:
    (folder / "robot.srdf").write_text(proposal.xml)
    dirs = [parent for parent in robot.urdf_path.parents if (parent / "example-robot-data").is_dir()]
    return to.load(robot.urdf_path, srdf=folder / "robot.srdf", package_dirs=dirs)


def test_a_written_srdf_is_read_back(panda: to.Robot, proposal: SrdfProposal, tmp_path: Path) -> None:
    again = read_back(panda, proposal, tmp_path)
    assert again.groups["panda_arm"].joints == panda.groups["panda_arm"].joints
    assert again.groups["panda_arm"].tip == "panda_link8"
    assert again.groups["hand"].joints == panda.groups["hand"].joints
    assert {frozenset(pair) for pair in proposal.disabled} <= again.disabled_pairs
    effector = again.end_effectors["hand_eef"]
    assert (effector.group, effector.parent_link, effector.parent_group) == (
        "hand",
        "panda_link8",
        "panda_arm",
    )
    for (group, state), values in proposal.states.items():
        assert again.state(state, group=group) == pytest.approx(values, abs=1e-9)


def test_home_is_valid_and_the_gripper_opens(panda: to.Robot, proposal: SrdfProposal, tmp_path: Path) -> None:
    again = read_back(panda, proposal, tmp_path)
    for fingers in ("open", "close"):
        home = again.positions({**again.state("home"), **again.state(fingers)})
        arm = reduce_model(to.Scene(again), "panda_arm", home)
        assert validity(arm, arm.start_positions).valid, fingers
    assert again.state("open")["panda_finger_joint1"] == pytest.approx(0.04)
    assert again.state("close")["panda_finger_joint1"] == pytest.approx(0.0)


def test_a_plan_can_be_made_with_it(panda: to.Robot, proposal: SrdfProposal, tmp_path: Path) -> None:
    again = read_back(panda, proposal, tmp_path)
    goal = {joint: value + 0.4 for joint, value in again.state("home").items()}
    problem = to.Problem(
        scene=to.Scene(again), start="home", goal=to.joint_positions(goal), group="panda_arm"
    )
    assert to.plan(problem).verified


def test_fingers_may_meet_and_others_are_named(proposal: SrdfProposal) -> None:
    assert proposal.disabled["panda_leftfinger", "panda_rightfinger"] == "Default"
    assert ("panda_link5", "panda_hand") not in proposal.disabled
    named = {item.pair for item in proposal.with_verdict(PairVerdict.DEFAULT)}
    assert {"panda_link5", "panda_hand"} in named
    text = str(proposal)
    assert "not checked: inside one gripper" in text and "panda_arm: panda_link0 to panda_link8" in text
    json.dumps(proposal.as_dict(), allow_nan=False)


def test_a_long_list_of_pairs_is_cut_and_a_pair_that_always_collides_does_so_in_all_samples(
    proposal: SrdfProposal,
) -> None:
    one = proposal.with_verdict(PairVerdict.SOMETIMES)[0]
    many = replace(proposal, evidence=(one,) * 25)
    assert str(many).count(str(one)) == 20
    assert "  and 5 more: --json, or as_dict(), has all" in str(many)
    always = replace(one, collisions=one.samples, descended=False)
    assert f"in collision in 100 % of {one.samples} samples" in str(always)


def test_home_is_zero_where_zero_is_valid(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(PLANAR_ARM)
    found = proposal_of(to.load(tmp_path / "arm.urdf"))
    assert found.states["arm", "home"] == {"shoulder": 0.0, "elbow": 0.0}
    assert found.states["hand", "open"] == {"left_slide": 0.04}
    assert found.states["hand", "close"] == {"left_slide": 0.0}


def single_jaw() -> str:
    """An arm of two joints, and a jaw that turns up from what is fixed to the arm."""

    def link(name: str) -> str:
        shape = '<origin xyz="0.06 0 0"/><geometry><box size="0.1 0.02 0.02"/></geometry>'
        return f'<link name="{name}"><collision>{shape}</collision></link>'

    def joint(name: str, kind: str, parent: str, child: str, along: float, lower: float, upper: float) -> str:
        return (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{along} 0 0"/><axis xyz="0 1 0"/>'
            f'<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/></joint>'
        )

    return (
        f'<robot name="z">{"".join(map(link, ("base", "upper", "fore", "gripperStator", "gripperMover")))}'
        + joint("shoulder", "revolute", "base", "upper", 0.3, -1, 1)
        + joint("elbow", "revolute", "upper", "fore", 0.3, -1, 1)
        + joint("mount", "fixed", "fore", "gripperStator", 0.2, 0, 0)
        + joint("jointGripper", "revolute", "gripperStator", "gripperMover", 0.0, -1.5, 0)
        + "</robot>"
    )


def test_an_arms_motion_leaves_a_single_jaw_where_it_is(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(single_jaw())
    robot = to.load(tmp_path / "arm.urdf")
    found = proposal_of(robot)
    # Which end of its range is open is not to be known from one finger, and is not guessed.
    assert all(group != "gripper" for group, _ in found.states)
    assert "name its open and closed states" in str(found)
    again = read_back(robot, found, tmp_path)
    problem = to.Problem(
        scene=to.Scene(again),
        group="arm",
        start={"shoulder": 0.1, "elbow": 0.2, "jointGripper": -0.1},
        goal=to.joint_positions({"shoulder": 0.5, "elbow": -0.2}),
    )
    assert to.plan(problem).require().trajectory.joint_names == ("shoulder", "elbow")
    assert "jointGripper: taken for a gripper's" in str(found)


def test_on_the_command_line(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(PLANAR_ARM)
    out = tmp_path / "arm.srdf"
    done = trajopt("srdf", tmp_path / "arm.urdf", "--out", out, "--share", 0.002, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["file"] == str(out) and told["robot"] == "planar_arm"
    robot = to.load(tmp_path / "arm.urdf", srdf=out)
    assert {frozenset(item["links"]) for item in told["disabled"]} <= robot.disabled_pairs
    refused = trajopt("srdf", tmp_path / "arm.urdf", "--share", 0)
    assert refused.returncode == 2 and "must lie in (0, 1)" in refused.stderr


INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
ON_WHEELS = """<robot name="mobile"><link name="base_link"/>{}</robot>""".format(
    "".join(
        f'<link name="{child}">{INERTIAL}</link><joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{at}"/><axis xyz="0 0 1"/>'
        f'<limit lower="-1" upper="1" effort="900" velocity="1"/></joint>'
        for parent, child, name, kind, at in (
            ("base_link", "left_wheel", "left_wheel_joint", "continuous", "0 0.3 0"),
            ("base_link", "right_wheel", "right_wheel_joint", "continuous", "0 -0.3 0"),
            ("base_link", "chest", "torso_lift_joint", "prismatic", "0 0 0.5"),
            ("chest", "face", "head_pan_joint", "revolute", "0 0 0.4"),
            ("chest", "upper", "shoulder_joint", "revolute", "0.2 0 0"),
            ("upper", "fore", "elbow_joint", "revolute", "0.4 0 0"),
            ("fore", "palm", "hand_mount", "fixed", "0.4 0 0"),
            ("palm", "finger", "finger_joint", "prismatic", "0.05 0 0"),
        )
    )
)


def test_robots_on_wheels_have_groups_with_torso_and_base(tmp_path: Path) -> None:
    (tmp_path / "mobile.urdf").write_text(ON_WHEELS)
    found = proposal_of(to.load(tmp_path / "mobile.urdf"))
    names = [group.name for group in found.groups]
    assert names == ["torso", "head", "arm", "gripper", "arm_torso", "base", "arm_torso_base"]
    assert "base: base_link in the plane, if to.load gets base=to.bases.planar_base(...)" in str(found)
    (tmp_path / "mobile.srdf").write_text(found.xml)
    standing = to.load(tmp_path / "mobile.urdf", srdf=tmp_path / "mobile.srdf")
    whole = ("torso_lift_joint", "shoulder_joint", "elbow_joint")
    assert standing.groups["arm_torso_base"].joints == standing.groups["arm_torso"].joints == whole
    base = to.bases.planar_base((-2, -2), (2, 2), velocity=(1, 1), acceleration=(1, 1))
    moving = to.load(tmp_path / "mobile.urdf", srdf=tmp_path / "mobile.srdf", base=base)
    driven = tuple(f"world_joint/{each}" for each in ("x", "y", "theta"))
    assert moving.groups["base"].joints == driven
    assert moving.groups["arm_torso_base"].joints == (*driven, *whole)
    goal = {"world_joint/x": 0.5, "torso_lift_joint": 0.3, "elbow_joint": 0.4}
    problem = to.Problem(scene=to.Scene(moving), group="arm_torso_base", start="home", goal=goal)
    assert to.plan(problem).verified


def test_a_robot_without_moving_joints_has_no_states(tmp_path: Path) -> None:
    box = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    (tmp_path / "post.urdf").write_text(
        f'<robot name="post"><link name="foot">{box}</link><link name="head">{box}</link>'
        '<joint name="weld" type="fixed"><parent link="foot"/><child link="head"/></joint></robot>'
    )
    found = proposal_of(to.load(tmp_path / "post.urdf"))
    assert not found.states and list(found.disabled) == [("foot", "head")]
