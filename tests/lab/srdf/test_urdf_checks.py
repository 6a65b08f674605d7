"""Each oddity of a URDF is told, and a good one has none."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.conftest import PLANAR_ARM
from tests.robot.test_mimics import planar
from trajopt.lab.srdf import Confidence, Finding, Severity, check_urdf, propose_srdf

GOOD = """<robot name="good">
  <link name="base"><visual><geometry><box size="0.2 0.2 0.2"/></geometry></visual>
    <collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="arm"><inertial><mass value="2"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.02" ixy="0.001" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.1 0.1"/></geometry></visual>
    <collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.1 0.1"/></geometry></collision></link>
  <link name="finger"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="10" velocity="1"/></joint>
  <joint name="follow" type="revolute"><parent link="arm"/><child link="finger"/><origin xyz="0.4 0 0"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="5" velocity="1"/>
    <mimic joint="turn" multiplier="0.5"/></joint>
</robot>"""

Check = Callable[[str, str], tuple[Finding, ...]]


@pytest.fixture
def changed(tmp_path: Path) -> Check:
    """Look at the good robot with one text in place of another."""

    def check(old: str, new: str) -> tuple[Finding, ...]:
        assert old in GOOD
        (tmp_path / "robot.urdf").write_text(GOOD.replace(old, new, 1))
        return check_urdf(to.load(tmp_path / "robot.urdf"))

    return check


def test_a_good_robot_has_no_findings(changed: Check) -> None:
    assert changed("good", "better") == ()


@pytest.mark.parametrize(
    ("old", "new", "severity", "subject", "told"),
    [
        ('<mass value="2"/>', '<mass value="0"/>', Severity.WARNING, "arm", "mass of zero"),
        ('iyy="0.03"', 'iyy="0.05"', Severity.ERROR, "arm", "moments of inertia that no body has"),
        ('iyy="0.03"', 'iyy="-0.03"', Severity.ERROR, "arm", "negative moment of inertia"),
        ('ixy="0.001"', 'ixy="0.1"', Severity.ERROR, "arm", "negative moment of inertia"),
        ('lower="-2" upper="2"', "", Severity.ERROR, "turn", "cannot move: both limits are 0"),
        ('lower="-2" upper="2"', 'lower="-180" upper="180"', Severity.WARNING, "turn", "degrees"),
        ('lower="-2" upper="2"', 'lower="-1e6" upper="1e6"', Severity.NOTE, "turn", "without limits"),
        ('effort="10"', 'effort="0"', Severity.WARNING, "turn", "or one of zero, on its effort"),
        ('velocity="1"', 'velocity="0"', Severity.WARNING, "turn", "or one of zero, on its velocity"),
        ('xyz="0 0 0.3"', 'xyz="0 0 300"', Severity.ERROR, "turn", "300 m from its parent: millimetres"),
        ('xyz="0 0 1"', 'xyz="0 0 2"', Severity.WARNING, "turn", "not a unit vector: 0 0 2"),
        ('multiplier="0.5"', 'multiplier="1"', Severity.WARNING, "follow", "beyond its own range [-1, 1]"),
        (
            '<collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.1 0.1"/></geometry></collision>',
            "",
            Severity.WARNING,
            "arm",
            "no collision shape",
        ),
        (
            '<collision><origin xyz="0.2 0 0"/><geometry><box size="0.4',
            '<collision><origin xyz="0.2 0 0"/><geometry><box size="0.9',
            Severity.WARNING,
            "arm",
            "a box of 900 x 100 x 100 mm, visual shapes one of 400 x 100 x 100 mm",
        ),
        (
            '<collision><origin xyz="0.2 0 0"/>',
            '<collision><origin xyz="-0.2 0 0"/>',
            Severity.WARNING,
            "arm",
            "displaced from the visual shapes",
        ),
        (
            '<collision><geometry><box size="0.2 0.2 0.2"/>',
            '<collision><geometry><box size="20 20 20"/>',
            Severity.ERROR,
            "base",
            "20 m: millimetres",
        ),
    ],
)
def test_an_implausible_value_is_reported(
    changed: Check, old: str, new: str, severity: Severity, subject: str, told: str
) -> None:
    found = changed(old, new)
    assert any(
        item.severity is severity and item.subject == subject and told in item.problem for item in found
    ), [str(item) for item in found]


def test_a_urdf_that_pinocchio_cannot_parse_raises_a_typed_error(changed: Check) -> None:
    with pytest.raises(to.TrajoptError, match="does not contain a valid URDF model"):
        changed("<limit", '<dynamics damping="much"/><limit')


def test_a_missing_limit_is_reported(changed: Check) -> None:
    told = Finding(Severity.WARNING, "turn", "has no limit, or one of zero, on its velocity")
    assert told in changed(' effort="10" velocity="1"', ' effort="10"')


def test_missing_inertias_and_continuous_joints(tmp_path: Path) -> None:
    text = PLANAR_ARM.replace('name="elbow" type="revolute"', 'name="elbow" type="continuous"')
    (tmp_path / "arm.urdf").write_text(text)
    found = check_urdf(to.load(tmp_path / "arm.urdf"))
    assert Finding(Severity.NOTE, "elbow", "is continuous: it turns without limits") in found
    assert any(item.subject == "upper" and "no <inertial>" in item.problem for item in found)
    order = [list(Severity).index(item.severity) for item in found]
    assert order == sorted(order)


def test_an_unreachable_mimic_range_is_reported_and_not_fatal(tmp_path: Path) -> None:
    """No position of j1 keeps m1 within its limits: an error among the findings, and an SRDF all the same."""
    robot = planar(
        tmp_path, {"m1": ("j1", 0.1, 0.0)}, limits={"m1": 'lower="1" upper="2" velocity="1" effort="1"'}
    )
    (finding,) = (item for item in check_urdf(robot) if item.severity is Severity.ERROR)
    assert finding.subject == "m1" and "no position of j1" in finding.problem
    proposal = propose_srdf(robot, rng=np.random.default_rng(0), confidence=Confidence(share=0.1, level=0.9))
    assert proposal.groups


def test_a_robot_of_a_pinocchio_model_is_not_passed_over(tmp_path: Path) -> None:
    """It has no URDF: the model's own inertias and limits are looked at, and that is said."""
    (tmp_path / "arm.urdf").write_text(PLANAR_ARM.replace('<mimic joint="left_slide"/>', ""))
    model = pin.buildModelFromUrdf(str(tmp_path / "arm.urdf"))
    impossible = np.diag((1.0, 0.1, 0.1))
    model.inertias[1] = pin.Inertia(1.0, np.zeros(3), impossible)
    model.lowerPositionLimit[1] = model.upperPositionLimit[1] = 0.2
    found = check_urdf(to.Robot.from_pinocchio(model))
    said = {(item.severity, item.subject, item.problem.split(" (")[0]) for item in found}
    first, second = list(model.names)[1:3]
    assert (Severity.ERROR, first, "has moments of inertia that no body has") in said
    assert (Severity.ERROR, second, "cannot move: both limits are 0.2") in said
    assert any(item.severity is Severity.NOTE and "there is no URDF" in item.problem for item in found)
    assert any("carries no mass" in item.problem for item in found)
