"""Groups proposed from the tree: an arm and its gripper, two arms on a torso, tips by name."""

from pathlib import Path
from xml.etree import ElementTree

import pytest
from trajopt_robots._example_robot_data import share_folder

import trajopt as to
from tests.robots_for_tests import odd_arm, two_arms
from trajopt.lab.srdf import ProposedGroup, propose_groups
from trajopt.lab.srdf.groups import LinkTree
from trajopt.lab.srdf.proposal import gripper_findings


def proposed(robot: to.Robot) -> dict[str, ProposedGroup]:
    return {group.name: group for group in propose_groups(LinkTree.of(robot))}


def joint(name: str, kind: str, parent: str, child: str, *, upper: float = 1.0, mimic: str = "") -> str:
    """A link and the joint above it, 0.3 m up (a finger's 0.05 m)."""
    height = 0.3 if kind == "revolute" else 0.05 if kind == "prismatic" else 0.0
    return (
        f'<link name="{child}"/><joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="0 0 {height}"/><axis xyz="0 1 0"/>'
        f'<limit lower="0" upper="{upper}" effort="1" velocity="1"/>{mimic}</joint>'
    )


def arm(prefix: str, base: str, *, fingers: int = 2, tool: str = "") -> str:
    """Four joints of 0.3 m, a palm fixed to the last link, and fingers on it."""
    above = [base, *(f"{prefix}link{number}" for number in range(4))]
    text = "".join(
        joint(f"{prefix}joint{number}", "revolute", above[number], above[number + 1]) for number in range(4)
    )
    for name in (f"{prefix}palm", *([tool] if tool else [])):
        text += joint(f"{name}_mount", "fixed", above[-1], name)
    for number in range(fingers):
        mimic = f'<mimic joint="{prefix}finger_joint0"/>' if number else ""
        finger, slide = f"{prefix}finger{number}", f"{prefix}finger_joint{number}"
        text += joint(slide, "prismatic", f"{prefix}palm", finger, upper=0.04, mimic=mimic)
    return text


def loaded(folder: Path, text: str) -> to.Robot:
    (folder / "robot.urdf").write_text(f'<robot name="robot"><link name="base"/>{text}</robot>')
    return to.load(folder / "robot.urdf")


def test_an_arm_and_its_gripper(tmp_path: Path) -> None:
    groups = proposed(loaded(tmp_path, arm("", "base")))
    assert list(groups) == ["arm", "gripper"]
    assert (groups["arm"].base, groups["arm"].tip) == ("base", "link3")
    assert groups["arm"].driven == ("joint0", "joint1", "joint2", "joint3")
    gripper = groups["gripper"]
    assert gripper.is_gripper and gripper.links == ("palm", "finger0", "finger1")
    assert gripper.joints == ("finger_joint0", "finger_joint1") and gripper.driven == ("finger_joint0",)
    assert (gripper.parent_link, gripper.parent_group) == ("link3", "arm")


def test_a_disc_that_turns_without_end_is_not_a_finger(tmp_path: Path) -> None:
    disc = joint("motor", "continuous", "palm", "disc")
    gripper = proposed(loaded(tmp_path, arm("", "base") + disc))["gripper"]
    assert gripper.links == ("palm", "finger0", "finger1")
    assert gripper.joints == ("finger_joint0", "finger_joint1")
    two = arm("", "base", fingers=0) + disc + joint("other", "continuous", "palm", "other_disc")
    assert proposed(loaded(tmp_path, two))["gripper"].driven == ("motor", "other")


def test_two_arms_with_grippers(tmp_path: Path) -> None:
    groups = proposed(loaded(tmp_path, arm("left_", "base") + arm("right_", "base")))
    assert list(groups) == ["left_arm", "left_gripper", "right_arm", "right_gripper"]
    assert groups["right_gripper"].parent_group == "right_arm"
    assert groups["left_arm"].driven == tuple(f"left_joint{number}" for number in range(4))


def test_arms_on_a_torso_are_not_a_gripper(tmp_path: Path) -> None:
    groups = proposed(two_arms(tmp_path))
    assert [(group.base, group.tip) for group in groups.values()] == [
        ("torso", "left_hand"),
        ("torso", "right_hand"),
    ]


def test_a_chain_alone(tmp_path: Path) -> None:
    groups = proposed(odd_arm(tmp_path))
    (only,) = groups.values()
    assert (only.name, only.base, only.tip) == ("arm", "base", "finger")
    assert only.driven == ("pan", "reach", "elbow", "wrist") and only.joints[-1] == "follow"


def test_a_waist_below_one_arm_is_a_joint_of_the_arm(tmp_path: Path) -> None:
    """Interbotix's arms name their first joint so; it was apart, and the arm could not turn about z."""
    text = joint("waist", "revolute", "base", "shoulder") + arm("", "shoulder")
    groups = proposed(loaded(tmp_path, text))
    assert list(groups) == ["arm", "gripper"]
    assert groups["arm"].driven == ("waist", *(f"joint{number}" for number in range(4)))


def test_the_tip_is_a_tool_frame_by_name(tmp_path: Path) -> None:
    (group,) = proposed(loaded(tmp_path, arm("", "base", fingers=0, tool="tool0"))).values()
    assert group.tip == "tool0"


def chain(*above: tuple[str, str, str]) -> str:
    """Links one on the other below "base": joint, kind and link of each."""
    parents = ["base", *(link for _, _, link in above)]
    return "".join(
        joint(name, kind, parent, link) for parent, (name, kind, link) in zip(parents, above, strict=False)
    )


WRIST = tuple((f"joint{number}", "revolute", f"link{number}") for number in range(6))
STATOR = ("stator_mount", "fixed", "gripperStator")


def said(robot: to.Robot) -> list[str]:
    tree = LinkTree.of(robot)
    return [str(finding) for finding in gripper_findings(tree, propose_groups(tree))]


@pytest.mark.parametrize(
    ("last", "palm"),
    [
        ((STATOR, ("jointGripper", "revolute", "gripperMover")), "gripperStator"),
        ((STATOR, ("joint6", "revolute", "mover")), "gripperStator"),
        ((("hand_mount", "fixed", "left_hand"), ("joint6", "prismatic", "slider")), "left_hand"),
        ((("joint6", "revolute", "jaw"),), ""),
        ((("gripper", "revolute", "part"),), ""),
        ((("finger_1", "prismatic", "proximal"), ("finger_2", "prismatic", "distal")), ""),
    ],
)
def test_a_gripper_on_a_chain_without_branches_ends_the_arm(
    tmp_path: Path, last: tuple[tuple[str, str, str], ...], palm: str
) -> None:
    robot = loaded(tmp_path, chain(*WRIST, *last))
    groups, name = proposed(robot), "hand" if palm == "left_hand" else "gripper"
    assert list(groups) == ["arm", name]
    assert groups["arm"].driven == tuple(name for name, _, _ in WRIST) and groups["arm"].tip == "link5"
    gripper = groups[name]
    assert gripper.driven == tuple(name for name, kind, _ in last if kind != "fixed")
    assert gripper.links == tuple(link for _, _, link in last)
    assert (gripper.tip, gripper.parent_link, gripper.parent_group) == (palm or "link5", "link5", "arm")
    (only,) = said(robot)
    assert (
        only.startswith(f"note: {gripper.driven[0]}") and f"taken for a gripper's: in group '{name}'" in only
    )


def test_fingers_on_the_last_link_itself_are_its_gripper(tmp_path: Path) -> None:
    fingers = "".join(
        joint(f"joint_finger_{number}", "prismatic", "link5", f"link_finger_{number}")
        + joint(f"joint_tip_{number}", "prismatic", f"link_finger_{number}", f"tip_{number}")
        for number in (1, 2)
    )
    groups = proposed(loaded(tmp_path, chain(*WRIST) + fingers))
    assert list(groups) == ["arm", "gripper"]
    assert groups["arm"].driven == tuple(name for name, _, _ in WRIST)
    assert groups["gripper"].driven == ("joint_finger_1", "joint_tip_1", "joint_finger_2", "joint_tip_2")


@pytest.mark.parametrize(
    "last",
    [
        (("gripper_roll_joint", "revolute", "gripper"),),
        (("wrist_joint", "revolute", "left_hand"),),
        (("joint6", "revolute", "handle"),),
        (("joint6", "revolute", "link6"), ("mount", "fixed", "gripper")),
    ],
)
def test_a_wrist_that_turns_a_whole_gripper_is_the_arms(
    tmp_path: Path, last: tuple[tuple[str, str, str], ...]
) -> None:
    robot = loaded(tmp_path, chain(*WRIST, *last))
    (only,) = proposed(robot).values()
    assert only.driven == (*(name for name, _, _ in WRIST), last[0][0])
    assert said(robot) == []


def test_a_wrist_that_turns_a_fixed_jaw_is_the_arms(tmp_path: Path) -> None:
    last = ("wrist_roll", "revolute", "fixed_jaw"), ("joint6", "revolute", "moving_jaw")
    groups = proposed(loaded(tmp_path, chain(*WRIST, *last)))
    assert groups["arm"].driven == (*(name for name, _, _ in WRIST), "wrist_roll")
    assert groups["gripper"].driven == ("joint6",)


@pytest.mark.parametrize(
    ("links", "why"),
    [
        ((*WRIST, ("joint6", "revolute", "hand")), "by its name or a neighbouring link's"),
        (
            (*WRIST, ("mount", "fixed", "tool"), ("joint6", "revolute", "mover")),
            "tool, which it hangs on, is",
        ),
        # As long as half of the arm: too large to be surely a gripper.
        ((*WRIST[:2], ("joint6", "revolute", "finger")), "by its name or a neighbouring link's"),
    ],
)
def test_a_possible_gripper_joint_is_reported(
    tmp_path: Path, links: tuple[tuple[str, str, str], ...], why: str
) -> None:
    robot = loaded(tmp_path, chain(*links))
    (only,) = proposed(robot).values()
    assert only.driven[-1] == "joint6"
    (note,) = said(robot)
    assert note.startswith(f"note: joint6: may be a gripper's ({why}")
    assert note.endswith(f"let the group's chain end at {links[-2][2]}")


def test_a_finger_alone_is_a_finger(tmp_path: Path) -> None:
    robot = loaded(tmp_path, chain(*((f"finger_{n}", "revolute", f"finger_link{n}") for n in range(3))))
    assert list(proposed(robot)) == ["finger"] and said(robot) == []


@pytest.mark.parametrize("name", ["panda", "two_pandas"])
def test_installed_robots(name: str) -> None:
    try:
        robot = to.load(name)
    except to.MissingExtra as error:
        pytest.skip(str(error))
    groups = proposed(robot)
    arms = [group for group in groups.values() if not group.is_gripper]
    grippers = [group for group in groups.values() if group.is_gripper]
    assert len(arms) == len(grippers) == (1 if name == "panda" else 2)
    assert all(len(group.driven) == 7 and group.tip.endswith("link8") for group in arms)
    assert all(len(group.driven) == 1 and len(group.joints) == 2 for group in grippers)


def without_shapes(path: Path, folder: Path) -> to.Robot:
    """Load a robot without its meshes, which its groups do not depend on."""
    tree = ElementTree.parse(path)
    for link in tree.getroot().iter("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
    tree.write(folder / "robot.urdf")
    return to.load(folder / "robot.urdf")


@pytest.mark.parametrize(
    ("file", "names"),
    [
        ("panda_description/urdf/panda.urdf", "panda_arm hand"),
        ("ur_description/urdf/ur5_robot.urdf", "arm"),
        ("baxter_description/urdf/baxter.urdf", "head left_arm left_gripper right_arm right_gripper"),
        ("tiago_description/robots/tiago.urdf", "torso arm hand head arm_torso base arm_torso_base"),
        (
            "pr2_description/urdf/pr2.urdf",
            "torso head left_arm left_gripper laser_tilt_mount right_arm right_gripper left_arm_torso "
            "right_arm_torso base left_arm_torso_base right_arm_torso_base",
        ),
        (
            "talos_data/robots/talos_reduced.urdf",
            "left_leg right_leg torso left_arm left_gripper right_arm right_gripper head left_arm_torso "
            "right_arm_torso",
        ),
    ],
)
def test_groups_have_the_names_that_a_person_gives(tmp_path: Path, file: str, names: str) -> None:
    try:
        path = share_folder() / "example-robot-data" / "robots" / file
    except to.MissingExtra as error:
        pytest.skip(str(error))
    assert list(proposed(without_shapes(path, tmp_path))) == names.split()


def test_a_torso_in_one_chain_with_an_arm_is_apart(shared_data: Path, tmp_path: Path) -> None:
    robot = without_shapes(shared_data / "motionbenchmaker" / "fetch" / "robot" / "fetch.urdf", tmp_path)
    groups = proposed(robot)
    assert list(groups) == ["torso", "arm", "arm_torso"]
    assert (groups["torso"].tip, groups["arm"].base) == ("torso_lift_link", "torso_lift_link")
    assert len(groups["arm"].driven) == 7 and groups["arm_torso"].driven[0] == "torso_lift_joint"
