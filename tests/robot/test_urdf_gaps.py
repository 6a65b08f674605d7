"""What many URDFs lack is filled in, and what cannot be read is named, not told on standard error."""

import re
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import ODD_ARM
from trajopt.values.errors import FileFormatError

LIMIT = '<limit lower="-1" upper="1" velocity="2" effort="30"/>'
MASS = '<mass value="1"/>'
INERTIA = '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>'
ARM = f"""<robot name="arm">
  <link name="base"/>
  <joint name="swing" type="revolute"><parent link="base"/><child link="boom"/>
    <axis xyz="0 0 1"/>{LIMIT}</joint>
  <link name="boom"><inertial>{MASS}{INERTIA}</inertial>
    <collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.1 0.1"/></geometry></collision></link>
</robot>"""
SECOND = '<link name="lid"/><joint name="hinge" type="fixed"><parent link="boom"/><child link="lid"/></joint>'


def loaded(folder: Path, old: str, new: str) -> to.Robot:
    """Return the arm with a part of its file replaced."""
    assert old in ARM
    (folder / "arm.urdf").write_text(ARM.replace(old, new))
    return to.load(folder / "arm.urdf")


FILLED = {
    "no velocity": (' velocity="2"', "", ("swing velocity 57.3 deg/s (no limit stated)",), ()),
    "no effort": (
        ' effort="30"',
        "",
        (),
        ("no effort limit is stated, or 0, so torque is not limited: swing",),
    ),
    "an empty limit of a continuous joint": (
        f'type="revolute"><parent link="base"/><child link="boom"/>\n    <axis xyz="0 0 1"/>{LIMIT}',
        'type="continuous"><parent link="base"/><child link="boom"/><axis xyz="0 0 1"/><limit/>',
        ("swing velocity 57.3 deg/s (no limit stated)",),
        ("no effort limit is stated, or 0, so torque is not limited: swing",),
    ),
    "no products of inertia": (' ixy="0" ixz="0" iyz="0"', "", (), ()),
    "an empty <dynamics>": (LIMIT, f"{LIMIT}<dynamics/>", (), ()),
    "an empty <safety_controller>": (LIMIT, f"{LIMIT}<safety_controller/>", (), ()),
    "a material twice": (
        '<link name="base"/>',
        '<material name="a"/><material name="a"/><link name="base"/>',
        (),
        (),
    ),
    "another version": ('<robot name="arm">', '<robot name="arm" version="1.2">', (), ()),
    "no mass": (MASS, "", (), ("inertias without a mass or moments are left out of torques: boom",)),
    "a mass without a value": (
        MASS,
        "<mass/>",
        (),
        ("inertias without a mass or moments are left out of torques: boom",),
    ),
    "no moments": (INERTIA, "", (), ("inertias without a mass or moments are left out of torques: boom",)),
    "no lower, no upper": (
        ' lower="-1" upper="1"',
        "",
        (),
        ("no lower and upper limits are stated, which URDF takes as 0, so that nothing moves: swing",),
    ),
}


@pytest.mark.parametrize("old,new,chosen,notes", FILLED.values(), ids=FILLED)
def test_missing_values_are_filled_in_and_noted_once(
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    old: str,
    new: str,
    chosen: tuple[str, ...],
    notes: tuple[str, ...],
) -> None:
    robot = loaded(tmp_path, old, new)
    velocities = tuple(each for each in robot.limits.defaulted if "velocity" in each)
    assert velocities == chosen and robot.notes == notes
    assert capfd.readouterr().err == ""


def test_an_arm_without_stated_rates_is_planned_with_defaults(tmp_path: Path) -> None:
    robot = loaded(tmp_path, ' velocity="2" effort="30"', "")
    found = to.plan(to.Problem(scene=to.Scene(robot), start={}, goal={"swing": 0.8}))
    speeds = found.require().trajectory(np.linspace(0.0, found.require().trajectory.duration, 50), 1)
    assert found.verified and 0.5 < np.abs(speeds).max() <= 1.0 + 1e-6


REFUSED = {
    "no limit": (LIMIT, "", r"joint 'swing' is revolute and has no <limit>: state lower and upper"),
    "mimics nothing": (LIMIT, f"{LIMIT}<mimic/>", r"joint 'swing': its <mimic> names no joint"),
    "no child": ('<child link="boom"/>', "", r"joint 'swing' has no <child link=\.\.\.>"),
    "no parent": ('<parent link="base"/>', "<parent/>", r"joint 'swing' has no <parent link=\.\.\.>"),
    "an unknown child": (
        'child link="boom"',
        'child link="bom"',
        r"'swing': no child link named 'bom'; did you mean 'boom'",
    ),
    "a joint without a name": ('name="swing" ', "", "a <joint> has no name"),
    "a link without a name": ('<link name="base"/>', "<link/>", "a <link> has no name"),
    "a name twice": ("</robot>", '<link name="boom"/></robot>', "more than one <link> is named 'boom'"),
    "a joint's name twice": (
        "</robot>",
        f"{SECOND.replace('hinge', 'swing')}</robot>",
        "more than one <joint> is named 'swing'",
    ),
    "two roots": ("</robot>", '<link name="lid"/></robot>', "one alone may be: base, lid"),
    "two parents": (
        "</robot>",
        f"{SECOND}{SECOND[SECOND.index('<joint') :].replace('hinge', 'latch')}</robot>",
        "link 'lid' is the child of two joints, 'hinge' and 'latch'",
    ),
    "a circle": (
        "</robot>",
        '<joint name="back" type="fixed"><parent link="boom"/><child link="base"/></joint></robot>',
        "in a circle: base, boom",
    ),
    "itself": ('parent link="base"', 'parent link="boom"', "in a circle: boom"),
}


@pytest.mark.parametrize("old,new,reason", REFUSED.values(), ids=REFUSED)
def test_a_link_graph_that_is_not_a_tree_is_reported(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], old: str, new: str, reason: str
) -> None:
    with pytest.raises(FileFormatError, match=reason):
        loaded(tmp_path, old, new)
    assert capfd.readouterr().err == ""


VISIBLE = '<visual><geometry><sphere radius="0.1"/></geometry></visual>'


def test_links_that_are_seen_and_not_solid_are_named(tmp_path: Path) -> None:
    seen = loaded(tmp_path, '<link name="base"/>', f'<link name="base">{VISIBLE}</link>')
    assert seen.notes == (
        "links are visible and have no collision shape, so nothing keeps clear of them: base",
    )
    solid = ARM[ARM.index("<collision>") : ARM.index("</link>", ARM.index("<collision>"))]
    ghost = loaded(tmp_path, solid, VISIBLE)
    assert ghost.notes[-1].startswith("links are visible and have no collision shape, so nothing")
    assert ghost.notes[-1].endswith("boom")
    scene = to.Scene(ghost).add("wall", to.Box(0.1, 0.1, 0.1), to.placement((0.2, 0.0, 0.0)))
    plan = to.plan(to.Problem(scene=scene, start={}, goal={"swing": 0.8})).require()
    assert "no moving link has a collision shape: no clearance is checked" in plan.certificate.notes


def test_negative_moments_of_inertia_are_noted(tmp_path: Path) -> None:
    robot = loaded(tmp_path, 'ixx="0.1"', 'ixx="-0.1"')
    (said,) = (note for note in robot.notes if "inertia" in note)
    assert said.startswith("bodies on swing have negative moments of inertia, which is impossible")
    assert not any("inertia" in note for note in loaded(tmp_path, MASS, MASS).notes)


def changed_arm(folder: Path, old: str, new: str) -> to.Robot:
    """Load the odd arm with one part of its URDF replaced."""
    assert old in ODD_ARM
    (folder / "odd.urdf").write_text(ODD_ARM.replace(old, new, 1))
    return to.load(folder / "odd.urdf")


@pytest.mark.parametrize("limit", ['effort="60" velocity="-1"', 'effort="-60" velocity="2.5"'])
def test_notes_negative_limits(limit: str, tmp_path: Path) -> None:
    robot = changed_arm(tmp_path, 'effort="60" velocity="2.5"', limit)
    assert "negative limits of velocity or effort count as not stated: elbow" in robot.notes
    assert (robot.limits.velocity > 0.0).all()


def test_notes_soft_limits_that_are_narrower(tmp_path: Path) -> None:
    limit = '<limit lower="-2.5" upper="2.5" effort="60" velocity="2.5"/>'
    soft = '<safety_controller soft_lower_limit="{}" soft_upper_limit="2.5" k_velocity="1"/>'
    (tmp_path / "narrow").mkdir()
    narrow = changed_arm(tmp_path / "narrow", limit, limit + soft.format(-2.4))
    assert any("soft limits of a <safety_controller>" in note and "elbow" in note for note in narrow.notes)
    equal = changed_arm(tmp_path, limit, limit + soft.format(-2.5))
    assert not any("safety_controller" in note for note in equal.notes)


def test_notes_elements_that_are_repeated(tmp_path: Path) -> None:
    limit = '<limit lower="-2.5" upper="2.5" effort="60" velocity="2.5"/>'
    robot = changed_arm(tmp_path, limit, limit + limit.replace("2.5", "0.5"))
    assert "of elements that URDF has once, the first counts: <limit> of elbow" in robot.notes
    assert robot.limits.upper[robot.joint_names.index("elbow")] == 2.5


@pytest.mark.parametrize("between", ["</geometry><geometry>", ""])
def test_rejects_a_collision_of_two_shapes(between: str, tmp_path: Path) -> None:
    two = f'<geometry><box size="0.1 0.1 0.1"/>{between}<sphere radius="0.3"/></geometry>'
    with pytest.raises(FileFormatError, match="link 'base': a <collision> has 2 shapes"):
        changed_arm(tmp_path, '<geometry><box size="0.1 0.1 0.1"/></geometry>', two)


@pytest.mark.parametrize(
    ("old", "new", "offender"),
    [
        ('<box size="0.1 0.1 0.1"/>', '<box size="0.1 0 0.1"/>', "link 'base': Box.y: must be positive"),
        ('<box size="0.1 0.1 0.1"/>', "<donut/>", "link 'base': a <geometry> has no known shape"),
        ('ixx="0.0001"', 'ixx="nan"', "link 'finger': <inertia ixx='nan'> holds"),
        ('lower="0" upper="0.3"', 'lower="-inf" upper="0.3"', "joint 'reach': <limit lower='-inf'> holds"),
        ('multiplier="-0.5"', 'multiplier="half"', "joint 'follow': <mimic multiplier='half'> is not a list"),
    ],
)
def test_errors_name_the_link_or_joint(old: str, new: str, offender: str, tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=re.escape(offender)):
        changed_arm(tmp_path, old, new)


def test_limits_of_acceleration_and_jerk_are_read(tmp_path: Path) -> None:
    new = LIMIT.replace("/>", ' acceleration="4" deceleration="3" jerk="50"/>')
    limits = loaded(tmp_path, LIMIT, new).limits
    assert limits.acceleration.tolist() == [3.0] and limits.jerk.tolist() == [50.0]
    assert not limits.defaulted


def test_a_file_of_limits_replaces_those_of_the_urdf(tmp_path: Path) -> None:
    (tmp_path / "joint_limits.yaml").write_text(
        "joint_limits:\n  swing: {has_acceleration_limits: true, max_acceleration: 2.5}\n"
    )
    (tmp_path / "arm.urdf").write_text(ARM.replace('velocity="2"', 'velocity="2" acceleration="4" jerk="50"'))
    limits = to.load(tmp_path / "arm.urdf", limits=tmp_path / "joint_limits.yaml").limits
    assert limits.acceleration.tolist() == [2.5] and limits.jerk.tolist() == [50.0]


@pytest.mark.parametrize("stated", ['acceleration="0"', 'deceleration="-1"', 'jerk="-5"'])
def test_rates_that_are_not_positive_are_refused(tmp_path: Path, stated: str) -> None:
    with pytest.raises(FileFormatError, match=f"swing.*{stated.split('=', maxsplit=1)[0]}.*not positive"):
        loaded(tmp_path, LIMIT, LIMIT.replace("/>", f" {stated}/>"))


def test_quaternions_of_origins_are_read(tmp_path: Path) -> None:
    half = np.sqrt(0.5)
    old = '<collision><origin xyz="0.2 0 0"/>'
    new = f'<collision><origin xyz="0.2 0 0" quat_xyzw="0 0 {2 * half} {2 * half}"/>'
    origin = f'<child link="boom"/><origin xyz="0 0 1" quat_xyzw="{half} 0 0 {half}"/>'
    turned = loaded(tmp_path, '<child link="boom"/>', origin)
    np.testing.assert_allclose(
        turned.model.jointPlacements[1].rotation,
        to.placement((0, 0, 0), rpy=(np.pi / 2, 0, 0)).rotation,
        atol=1e-12,
    )
    box = loaded(tmp_path, old, new).bodies[0]
    np.testing.assert_allclose(
        box.placement.rotation, to.placement((0, 0, 0), rpy=(0, 0, np.pi / 2)).rotation, atol=1e-12
    )


@pytest.mark.parametrize(
    ("origin", "words"),
    [
        ('quat_xyzw="0 0 0 0"', "is zero"),
        ('quat_xyzw="0 0 0 1" rpy="0 0 0"', "also has rpy"),
        ('quat_xyzw="1 2"', "4"),
    ],
)
def test_invalid_quaternions_are_refused(tmp_path: Path, origin: str, words: str) -> None:
    with pytest.raises(FileFormatError, match=words):
        loaded(tmp_path, '<origin xyz="0.2 0 0"/>', f'<origin xyz="0.2 0 0" {origin}/>')


@pytest.mark.parametrize(
    ("lower", "upper", "read"),
    [
        (-999999, 999999, (-np.inf, np.inf)),
        (-1e4, 1e5, (-np.inf, np.inf)),
        (0, 1e6, (0, 1e6)),
        (-9, 9, (-9, 9)),
    ],
)
def test_an_endless_range_is_no_limit(
    tmp_path: Path, lower: float, upper: float, read: tuple[float, float]
) -> None:
    limits = loaded(tmp_path, 'lower="-1" upper="1"', f'lower="{lower}" upper="{upper}"').limits
    assert (limits.lower[0], limits.upper[0]) == read
