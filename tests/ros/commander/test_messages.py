"""Messages: the stand-ins, and those of ROS by the look of them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from trajopt.ros.commander.geometry_msgs.msg import Pose, Quaternion
from trajopt.ros.commander.moveit_msgs.msg import AllowedCollisionMatrix

import trajopt as to
from trajopt.files.messages import document_of
from trajopt.ros.commander import (
    MoveGroupCommander,
    MoveItCommanderException,
    PlanningSceneInterface,
    World,
    rospy,
    tf,
)
from trajopt.ros.commander.conversions import (
    list_to_pose,
    list_to_pose_stamped,
    placement_of,
    pose_of,
    pose_to_list,
)
from trajopt.values.errors import ShapeError


class Ros1:
    """A message as ROS 1 generates it: fields in `__slots__`, and a type."""

    __slots__: tuple[str, ...] = ()
    _type = "any"


def ros1(**members: object) -> Ros1:
    kind = type("Message", (Ros1,), {"__slots__": tuple(members)})
    message = kind()
    for name, value in members.items():
        setattr(message, name, value)
    return message


class Ros2:
    """A message as ROS 2 generates it: properties, and a class method that names them."""

    def __init__(self, **members: object) -> None:
        self.__dict__.update(members)

    def get_fields_and_field_types(self) -> dict[str, str]:
        return dict.fromkeys(self.__dict__, "any")


@pytest.mark.parametrize("make", [ros1, Ros2])
def test_messages_of_ros_are_taken(lab_arm: to.Robot, make: type) -> None:
    world = World(lab_arm)
    arm, scene = MoveGroupCommander("arm", world=world), PlanningSceneInterface(world=world)
    header = make(stamp=make(secs=1, nsecs=2), frame_id="base")
    pose = make(position=make(x=0.6, y=0.5, z=0.1), orientation=make(x=0.0, y=0.0, z=0.4, w=0.9))
    arm.set_pose_target(make(header=header, pose=pose))
    assert arm.plan()[0]
    constraint = make(joint_name="wrist", position=0.2, tolerance_above=0.5, tolerance_below=0.5, weight=1.0)
    arm.set_path_constraints(
        make(
            name="",
            joint_constraints=[constraint],
            position_constraints=[],
            orientation_constraints=(),
            visibility_constraints=[],
        )
    )
    arm.set_joint_value_target(
        make(header=header, name=["elbow"], position=np.array([0.3]), velocity=[], effort=[])
    )
    success, trajectory, _, _ = arm.plan()
    assert success
    points = [
        make(
            positions=tuple(point.positions),
            velocities=np.array(point.velocities),
            accelerations=point.accelerations,
            effort=[],
            time_from_start=make(secs=point.time_from_start.secs, nsecs=point.time_from_start.nsecs),
        )
        for point in trajectory.joint_trajectory.points
    ]
    joints = trajectory.joint_trajectory.joint_names
    assert arm.execute(make(header=header, joint_names=joints, points=points))
    scene.add_box("box", make(header=header, pose=pose), (0.1, 0.1, 0.1))
    assert scene.get_known_object_names() == ["box"]


def test_refuses_values_that_are_not_messages() -> None:
    with pytest.raises(to.TrajoptError, match="set_path_constraints: 3j is not a message"):
        document_of([3j], "set_path_constraints")


def test_a_misspelt_field_is_refused() -> None:
    pose = Pose()
    with pytest.raises(AttributeError):
        pose.postion = 1.0


def test_poses() -> None:
    pose = list_to_pose([0.1, 0.2, 0.3, 0.1, 0.2, 0.3])
    turned = Rotation.from_euler("xyz", (0.1, 0.2, 0.3)).as_quat()
    assert pose_to_list(pose) == pytest.approx([0.1, 0.2, 0.3, *turned])
    assert pose_to_list(list_to_pose(pose_to_list(pose))) == pytest.approx(pose_to_list(pose))
    assert list_to_pose_stamped([0] * 6, "base").header.frame_id == "base"
    where = to.placement((1, 2, 3), rpy=(0.3, 0.2, 0.1))
    assert np.allclose(placement_of(pose_of(where)).homogeneous, where.homogeneous)
    assert placement_of(Pose()).rotation.tolist() == np.eye(3).tolist()
    with pytest.raises(MoveItCommanderException, match="a pose is"):
        list_to_pose([1.0] * 5)
    with pytest.raises(MoveItCommanderException, match="a pose is"):
        placement_of("ready")


@pytest.mark.parametrize("axes", ["sxyz", "rxyz", "szyx", "rzyx", "szxz"])
def test_euler_angles(axes: str) -> None:
    angles = (0.3, 0.7, -0.4)
    quaternion = tf.transformations.quaternion_from_euler(*angles, axes=axes)
    turn = np.eye(3)
    for axis, angle in zip(axes[1:], angles, strict=True):
        step = Rotation.from_rotvec(angle * np.eye(3)["xyz".index(axis)]).as_matrix()
        turn = turn @ step if axes[0] == "r" else step @ turn
    assert np.allclose(Rotation.from_quat(quaternion).as_matrix(), turn)
    assert tf.transformations.euler_from_quaternion(quaternion, axes) == pytest.approx(angles)


def test_the_same_as_rpy_by_default() -> None:
    assert tf.transformations.quaternion_from_euler(0.1, 0.2, 0.3) == pytest.approx(
        to.placement(rpy=(0.1, 0.2, 0.3)).quaternion
    )
    with pytest.raises(ShapeError, match="such as 'sxyz'"):
        tf.transformations.quaternion_from_euler(0, 0, 0, axes="xyz")


def test_quaternions_and_matrices() -> None:
    turn = tf.transformations
    first, second = turn.quaternion_from_euler(0.1, 0.2, 0.3), turn.quaternion_about_axis(0.5, (0, 0, 2))
    assert second == pytest.approx(turn.quaternion_from_euler(0, 0, 0.5))
    both = turn.quaternion_matrix(turn.quaternion_multiply(first, second))
    assert np.allclose(both, turn.quaternion_matrix(first) @ turn.quaternion_matrix(second))
    back = turn.quaternion_multiply(first, turn.quaternion_inverse(first))
    assert np.abs(back) == pytest.approx([0, 0, 0, 1])
    matrix = turn.translation_matrix((1, 2, 3)) @ turn.euler_matrix(0.1, 0.2, 0.3)
    assert turn.euler_from_matrix(matrix) == pytest.approx((0.1, 0.2, 0.3))
    assert turn.quaternion_from_matrix(matrix) == pytest.approx(first)
    assert turn.translation_from_matrix(matrix).tolist() == [1, 2, 3]


def test_products_of_matrices() -> None:
    turn = tf.transformations
    first, second = turn.translation_matrix((1, 2, 3)), turn.euler_matrix(0.1, 0.2, 0.3)
    both = turn.concatenate_matrices(first, second)
    assert np.allclose(both, first @ second)
    assert np.allclose(turn.concatenate_matrices(both, turn.inverse_matrix(both)), turn.identity_matrix())
    about = turn.rotation_matrix(np.pi / 2, (0, 0, 2), np.array((1.0, 0.0, 0.0)))
    assert np.allclose(about @ (2, 0, 0, 1), (1, 1, 0, 1))
    assert np.allclose(turn.rotation_matrix(0.5, (1, 0, 0)), turn.euler_matrix(0.5, 0, 0))
    assert turn.unit_vector((0, 3, 4)) == pytest.approx((0, 0.6, 0.8))


def test_turns_between_quaternions() -> None:
    turn = tf.transformations
    first, second = turn.quaternion_from_euler(0, 0, 0.2), turn.quaternion_from_euler(0, 0, 0.6)
    assert turn.quaternion_slerp(first, -second, 0.25) == pytest.approx(turn.quaternion_from_euler(0, 0, 0.3))
    assert np.allclose(turn.quaternion_conjugate(first), turn.quaternion_inverse(first))


def test_moments_and_spans(monkeypatch: pytest.MonkeyPatch) -> None:
    moment, span = rospy.Time(10.5), rospy.Duration(0.75)
    assert moment + span == rospy.Time(11, 250_000_000)
    assert moment - rospy.Time.from_sec(9.75) == span and moment - span == rospy.Time(9.75)
    assert span + span == rospy.Duration(1.5) and span - rospy.Duration(1) == rospy.Duration(-0.25)
    assert rospy.Duration(1) > span and moment < rospy.Time(11)
    assert span * 2 == 2.0 * span == rospy.Duration(1.5) and span / 3 == rospy.Duration(0.25)
    assert span / rospy.Duration(0.25) == 3.0 and abs(-span) == span
    now = [100.0]
    monkeypatch.setattr("trajopt.ros.commander.rospy.time.monotonic", lambda: now[0])
    monkeypatch.setattr(
        "trajopt.ros.commander.rospy.time.sleep", lambda seconds: now.append(now.pop() + seconds)
    )
    rate = rospy.Rate(10)
    now[0] += 0.04
    assert rate.remaining().to_sec() == pytest.approx(0.06)
    rate.sleep()
    assert now[0] == pytest.approx(100.1)
    now[0] += 5.0  # A round that took too long: the next begins now, and is whole.
    rate.sleep()
    assert now[0] == pytest.approx(105.1)
    rate.sleep()
    assert now[0] == pytest.approx(105.2)


def test_the_rospy_stand_in_has_the_calls_of_scripts(monkeypatch: pytest.MonkeyPatch) -> None:
    slept: list[float] = []
    monkeypatch.setattr(rospy.time, "sleep", slept.append)
    rospy.init_node("script", anonymous=True)
    assert not rospy.is_shutdown()
    rospy.sleep(0.5)
    rospy.sleep(rospy.Duration(1.5))
    assert slept == [0.5, 1.5]
    assert rospy.Time.now().to_sec() == pytest.approx(rospy.get_time(), abs=60.0)
    assert rospy.Duration.from_sec(2.25) == rospy.Duration(2, 250_000_000)


def test_texts_are_logged_once_or_seldom(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    now = [100.0]
    monkeypatch.setattr("trajopt.ros.commander.rospy.time.monotonic", lambda: now[0])
    caplog.set_level("INFO", "trajopt.ros.commander")
    for now[0] in (100.0, 101.0, 103.0):
        rospy.loginfo_once("a first %s", "time")
        rospy.logwarn_throttle(2.0, "seldom")
    assert caplog.messages == ["a first time", "seldom", "seldom"]


def test_collision_matrix() -> None:
    matrix = AllowedCollisionMatrix()
    matrix.set_allowed("a", "b")
    matrix.set_allowed("c", "a", allow=False)
    matrix.set_allowed("d")
    assert matrix.entry_names == ["a", "b", "c"]
    assert [row.enabled for row in matrix.entry_values] == [
        [False, True, False],
        [True, False, False],
        [False] * 3,
    ]
    assert (matrix.default_entry_names, matrix.default_entry_values) == (["d"], [True])
    matrix.set_default("d", False)
    assert matrix.default_entry_values == [False]


def test_quaternions_start_with_zeros_as_in_ros() -> None:
    assert Quaternion() == Quaternion(0.0, 0.0, 0.0, 0.0)
