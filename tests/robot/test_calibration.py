"""Calibrations of arms of Universal Robots, by forward kinematics of the DH parameters in plain numpy."""

import pickle
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from trajopt.robot.loading.pinocchio_model import link_placement
from trajopt.values.errors import FileFormatError, FrameNotFound, JointNotFound, ModelError, ProblemError

LINKS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
TURNED = np.deg2rad((90.0, 0.0, 0.0, 90.0, -90.0, 0.0))
NOMINAL = {
    "ur5": ((0.089159, 0.0, 0.0, 0.10915, 0.09465, 0.0823), (0.0, -0.425, -0.39225, 0.0, 0.0, 0.0)),
    "ur10": ((0.1273, 0.0, 0.0, 0.163941, 0.1157, 0.0922), (0.0, -0.612, -0.5723, 0.0, 0.0, 0.0)),
}
"""d and a [m], from the page of Universal Robots."""
REAL = """[mounting]
delta_theta = [ -8.20642406610186392e-05, -0.103609197138685979, 0.673631891251821102, -0.57016974724960845, -4.59636351675856217e-05, 9.74999561134540574e-07]
delta_a = [ -0.000161187342296687116, 0.00304003843792177708, 0.0916468555721788314, -9.62964975953143595e-05, -2.97595340762196176e-05, 0]
delta_d = [ 0.000505390894843998906, 11.1984514757821039, -92.5270326908668181, 81.3282683520703529, -0.000212852818740727479, -0.000126145560998547346]
delta_alpha = [ -0.00032142399895862539, -0.00565024518540147101, -0.00378922621833689211, -0.00106533274011644252, 0.000999586303470856308, 0]
joint_checksum = [ 0x6e0f7bf, 0xa32a713f, 0xf636a50, 0x9ec2338a, 0xa1afded8, 0xb29b2979]
calibration_status = 2 # 0 == notInitialized / 1 == notLinearised / 2 == Linearised
"""  # noqa: E501
"""Of a UR10: https://forum.universal-robots.com/t/calibrated-kinamatics-info/18921."""


def rotation(axis: int, angle: float) -> np.ndarray:
    c, s, found = np.cos(angle), np.sin(angle), np.eye(4)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found[i, i] = found[j, j] = c
    found[i, j], found[j, i] = -s, s
    return found


def shift(axis: int, length: float) -> np.ndarray:
    found = np.eye(4)
    found[axis, 3] = length
    return found


def flange(kind: str, deltas: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Return the flange in the controller's base frame; deltas are theta, d, a, alpha."""
    d, a = NOMINAL[kind]
    found = np.eye(4)
    for (theta, more_d, more_a, more_alpha), q, d_i, a_i, alpha in zip(
        deltas.T, joints, d, a, TURNED, strict=True
    ):
        found = found @ rotation(2, q + theta) @ shift(2, d_i + more_d)
        found = found @ shift(0, a_i + more_a) @ rotation(0, alpha + more_alpha)
    return found


def random_deltas(rng: np.random.Generator) -> np.ndarray:
    deltas = rng.uniform(-1e-3, 1e-3, (4, 6))
    deltas[2:, 5] = 0.0
    return deltas


def conf(deltas: np.ndarray) -> str:
    rows = zip(("theta", "d", "a", "alpha"), deltas.tolist(), strict=True)
    return "[mounting]\n" + "".join(f"delta_{name} = {row}\n" for name, row in rows)


def yaml(kind: str, deltas: np.ndarray) -> str:
    """Return the file as ur_calibration writes it: angles of Rx Ry Rz, as Eigen's eulerAngles(0, 1, 2)."""
    (d, a), before, text = NOMINAL[kind], np.eye(4), "kinematics:\n"
    for i, link in enumerate(LINKS):
        there = before @ rotation(2, deltas[0, i]) @ shift(2, d[i] + deltas[1, i])
        before = shift(0, a[i] + deltas[2, i]) @ rotation(0, TURNED[i] + deltas[3, i])
        roll, pitch = np.arctan2(-there[1, 2], there[2, 2]), np.arcsin(there[0, 2])
        yaw = np.arctan2(-there[0, 1], there[0, 0])
        values = dict(zip(("x", "y", "z"), there[:3, 3], strict=True), roll=roll, pitch=pitch, yaw=yaw)
        text += f"  {link}:\n" + "".join(f"    {name}: {value:.17g}\n" for name, value in values.items())
    return text + "  hash: calib_1\n"


def ur10(folder: Path) -> to.Robot:
    """Return a UR10 with the frames of ur_description."""
    d, a = NOMINAL["ur10"]
    places, before = list[np.ndarray](), np.eye(4)
    for i in range(6):
        places.append(before @ shift(2, d[i]))
        before = shift(0, a[i]) @ rotation(0, TURNED[i])
    names = ("base_link", "base_link_inertia", *(f"{link}_link" for link in LINKS), "tool0")
    joints = ("fixed", *("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"), "mount")
    text = '<robot name="ur10">' + "".join(f'<link name="{name}"/>' for name in names)
    for place, (joint, there) in enumerate(
        zip(joints, (rotation(2, np.pi), *places, np.eye(4)), strict=True)
    ):
        xyz, rpy = there[:3, 3].tolist(), pin.rpy.matrixToRpy(there[:3, :3]).tolist()
        kind = "fixed" if place in (0, 7) else "revolute"
        text += f'<joint name="{joint}_joint" type="{kind}"><parent link="{names[place]}"/>'
        text += f'<child link="{names[place + 1]}"/><axis xyz="0 0 1"/>'
        text += f'<origin xyz="{" ".join(map(repr, xyz))}" rpy="{" ".join(map(repr, rpy))}"/>'
        text += '<limit lower="-6.3" upper="6.3" velocity="2" effort="100"/></joint>'
    (folder / "ur10.urdf").write_text(text + "</robot>")
    return to.load(folder / "ur10.urdf")


def farthest(robot: to.Robot, kind: str, deltas: np.ndarray) -> float:
    """Return the largest deviation of the flange from the DH parameters at random positions [m | 1]."""
    rng, found, base = np.random.default_rng(1), 0.0, rotation(2, np.pi)
    for _ in range(20):
        joints = rng.uniform(-3.0, 3.0, 6)
        ours = link_placement(robot.model, "tool0", joints).homogeneous
        found = max(found, float(np.abs(base @ flange(kind, deltas, joints) - ours).max()))
    return found


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ["ur5", "ur10"])
def test_the_flange_is_at_the_pose_of_the_dh_parameters(tmp_path: Path, kind: str, seed: int) -> None:
    robot = to.load("ur5") if kind == "ur5" else ur10(tmp_path)
    deltas = random_deltas(np.random.default_rng(seed))
    assert farthest(robot, kind, np.zeros((4, 6))) < 1e-9
    assert farthest(robot, kind, deltas) > 1e-4
    for name, text in (("calibration.conf", conf(deltas)), ("my_ur.yaml", yaml(kind, deltas))):
        (tmp_path / name).write_text(text)
        calibrated = robot.with_calibration(tmp_path / name)
        assert farthest(calibrated, kind, deltas) < 1e-9
        assert farthest(pickle.loads(pickle.dumps(calibrated)), kind, deltas) < 1e-9
        assert "calibrated" in calibrated.notes[-1] and calibrated.urdf_path == Path()
        rebuilt = pin.buildModelFromXML(calibrated.urdf_xml)
        for one, other in zip(rebuilt.jointPlacements, calibrated.model.jointPlacements, strict=True):
            np.testing.assert_allclose(one.homogeneous, other.homogeneous, atol=1e-9)


def test_a_real_calibration_keeps_the_links_at_their_places(tmp_path: Path) -> None:
    robot = ur10(tmp_path)
    (tmp_path / "calibration.conf").write_text(REAL)
    calibrated = robot.with_calibration(tmp_path / "calibration.conf")
    lines = [line.partition("=")[2] for line in REAL.splitlines() if line.startswith("delta")]
    theta, a, d, alpha = (np.array(eval(line)) for line in lines)
    assert farthest(calibrated, "ur10", np.array((theta, d, a, alpha))) < 1e-9
    for link in robot.links:  # although the elbow of these parameters is 11 m away
        one, other = (link_placement(each.model, link, np.zeros(6)) for each in (robot, calibrated))
        assert np.abs(one.translation - other.translation).max() < 4e-3
        assert np.abs(one.rotation - other.rotation).max() < 0.02
    assert calibrated.notes[-1].endswith("which moves tool0 by 3.24 mm at zero positions")


def test_a_plan_moves_the_calibrated_arm(tmp_path: Path) -> None:
    deltas = random_deltas(np.random.default_rng(5))
    (tmp_path / "calibration.conf").write_text(conf(deltas))
    robot = to.load("ur5").with_calibration(tmp_path / "calibration.conf")
    joints = np.array((0.3, -1.2, 1.5, -1.8, -1.6, 0.2))
    pose = to.Placement(*_parts(rotation(2, np.pi) @ flange("ur5", deltas, joints)))
    start = dict(zip(robot.joint_names, joints + 0.2, strict=True))
    problem = to.Problem(
        scene=to.Scene(robot),
        group="manipulator",
        start=start,
        goal=to.frame_placement("tool0", pose, position_tolerance=1e-6, rotation_tolerance=1e-6),
    )
    end = to.plan(problem).require().trajectory.positions[-1]
    reached = rotation(2, np.pi) @ flange("ur5", deltas, end)
    assert np.abs(reached - pose.homogeneous).max() < 1e-5


def _parts(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return matrix[:3, :3], matrix[:3, 3]


GOOD = conf(np.zeros((4, 6)))
NULL = yaml("ur5", np.zeros((4, 6)))
WRONG = {
    "missing.conf": (None, "cannot be read"),
    "empty.conf": ("", "it lacks delta_theta, delta_d, delta_a"),
    "five.conf": (GOOD.replace("0.0, ", "", 1), "delta_theta must be six finite numbers"),
    "word.conf": (GOOD.replace("0.0", "zero", 1), "delta_theta must be six finite numbers"),
    "nan.conf": (GOOD.replace("0.0", "nan", 1), "delta_theta must be six finite numbers"),
    "twice.conf": (GOOD + GOOD, "delta_theta is there twice"),
    "last.conf": (GOOD.replace("0.0]\ndelta_alpha", "0.1]\ndelta_alpha"), "delta_a of the last joint is 0.1"),
    "far.conf": (GOOD.replace("delta_d = [0.0", "delta_d = [0.1"), "by 100 mm: it belongs to another type"),
    "empty.yaml": ("", "must hold one mapping"),
    "list.yaml": ("kinematics: []", "kinematics: must be a mapping"),
    "link.yaml": (NULL.replace("forearm", "arm"), "kinematics.forearm.x: must be a number, is missing"),
    "number.yaml": (NULL.replace("x: ", "x: no", 1), r"kinematics.shoulder.x: must be a number"),
    "inf.yaml": (NULL.replace("z: 0", "z: .inf #", 1), r"kinematics.shoulder.z: must be finite"),
    "other.yaml": (yaml("ur10", np.zeros((4, 6))), "it belongs to another type of arm"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_file_is_refused(tmp_path: Path, name: str) -> None:
    text, words = WRONG[name]
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(FileFormatError, match=words):
        to.load("ur5").with_calibration(tmp_path / name)


def test_another_robot_is_refused(tmp_path: Path) -> None:
    (tmp_path / "calibration.conf").write_text(GOOD)
    with pytest.raises(JointNotFound, match="shoulder_pan_joint"):
        to.load("panda").with_calibration(tmp_path / "calibration.conf")
    with pytest.raises(JointNotFound, match="left_shoulder_pan_joint"):
        to.load("ur5").with_calibration(tmp_path / "calibration.conf", prefix="left_")
    with pytest.raises(ProblemError, match="prefix must be a name"):
        to.load("ur5").with_calibration(tmp_path / "calibration.conf", prefix=3)  # pyright: ignore
    ur10(tmp_path)
    file = tmp_path / "ur10.urdf"
    written = file.read_text()
    file.write_text(written.replace("tool0", "tip"))
    with pytest.raises(FrameNotFound, match="tool0"):
        to.load(file).with_calibration(tmp_path / "calibration.conf")
    file.write_text(written.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 1 0"/>'))
    with pytest.raises(ModelError, match="do not have the axes of an arm of Universal Robots"):
        to.load(file).with_calibration(tmp_path / "calibration.conf")


def test_an_arm_with_a_prefix_is_calibrated(tmp_path: Path) -> None:
    ur10(tmp_path)
    file, deltas = tmp_path / "ur10.urdf", random_deltas(np.random.default_rng(7))
    for name in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"):
        file.write_text(file.read_text().replace(f'"{name}_joint"', f'"left_{name}_joint"'))
    file.write_text(file.read_text().replace("tool0", "left_tool0"))
    (tmp_path / "calibration.conf").write_text(conf(deltas))
    robot = to.load(file).with_calibration(tmp_path / "calibration.conf", prefix="left_")
    found = link_placement(robot.model, "left_tool0", np.ones(6)).homogeneous
    np.testing.assert_allclose(found, rotation(2, np.pi) @ flange("ur10", deltas, np.ones(6)), atol=1e-9)
