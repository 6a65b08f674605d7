"""Cartesian paths, picking and placing through MoveIt's interface."""

from collections.abc import Callable

import numpy as np
import pytest
from trajopt.ros.commander.moveit_msgs.msg import (
    Constraints,
    Grasp,
    JointConstraint,
    MoveItErrorCodes,
    PlaceLocation,
)
from trajopt.ros.commander.trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from trajopt import placement
from trajopt.ros.commander import MoveGroupCommander, MoveItCommanderException, PlanningSceneInterface, World
from trajopt.ros.commander.conversions import placement_of, pose_of, stamped
from trajopt.tasks import grasping
from trajopt.values.errors import MissingExtra


@pytest.fixture
def arm(jumping: World) -> MoveGroupCommander:
    return MoveGroupCommander("arm", world=jumping)


def line(arm: MoveGroupCommander, far: float) -> list[object]:
    """Where the hand is, and so far beside: at the start and at the end of a straight line along y."""
    here = placement_of(arm.get_current_pose().pose)
    end = placement(here.translation + np.array((0.0, far, 0.0)), rotation=here.rotation)
    return [pose_of(here), pose_of(end)]


def test_a_line_is_followed(arm: MoveGroupCommander, jumping: World) -> None:
    begin, end = (placement_of(pose) for pose in line(arm, 0.3))
    trajectory, fraction = arm.compute_cartesian_path([pose_of(begin), pose_of(end)], 0.01)
    assert fraction == 1.0
    assert arm.get_last_followed().complete
    for point in trajectory.joint_trajectory.points:
        joints = dict(zip(trajectory.joint_trajectory.joint_names, point.positions, strict=True))
        at = jumping.scene.placement_of("hand", jumping.robot.positions(joints))
        assert np.allclose(at.translation[[0, 2]], begin.translation[[0, 2]], atol=2e-3)
        assert np.allclose(at.rotation, begin.rotation, atol=2e-2)
    assert np.allclose(at.translation, end.translation, atol=2e-3)
    assert arm.execute(trajectory)


@pytest.mark.parametrize(
    ("words", "named"),
    [((0.0,), {}), ((5.0, True), {}), ((0, True, None), {}), ((), {"jump_threshold": 0.0}), ((True,), {})],
)
def test_a_jump_threshold_is_accepted(
    arm: MoveGroupCommander, words: tuple[object, ...], named: dict[str, float]
) -> None:
    """Scripts of before 2023 have it as the third argument, where later ones have avoid_collisions."""
    assert arm.compute_cartesian_path(line(arm, 0.1), 0.01, *words, **named)[1] == 1.0


@pytest.mark.parametrize(("words", "reached"), [((0.0, False), True), ((0.0,), False), ((False,), True)])
def test_after_a_jump_threshold_comes_whether_to_avoid(
    arm: MoveGroupCommander, jumping: World, words: tuple[object, ...], reached: bool
) -> None:
    scene = PlanningSceneInterface(world=jumping)
    x, y = arm.get_current_pose().pose.position.x, arm.get_current_pose().pose.position.y
    scene.add_box("wall", stamped(placement((x, y + 0.3, 0.1)), "base"), (0.4, 0.05, 0.3))
    assert (arm.compute_cartesian_path(line(arm, 0.35), 0.01, *words)[1] == 1.0) is reached


def test_a_line_ends_where_its_path_constraints_fail(arm: MoveGroupCommander) -> None:
    whole, _ = arm.compute_cartesian_path(line(arm, 0.3), 0.01)
    names, points = whole.joint_trajectory.joint_names, whole.joint_trajectory.points
    joint = int(np.argmax(np.abs(np.subtract(points[-1].positions, points[0].positions))))
    off = 0.5 * abs(points[-1].positions[joint] - points[0].positions[joint])
    near = JointConstraint(names[joint], points[0].positions[joint], off, off, 1.0)
    kept = Constraints(joint_constraints=[near])
    part, fraction = arm.compute_cartesian_path(line(arm, 0.3), 0.01, path_constraints=kept)
    assert 0.2 < fraction < 0.8
    assert "path constraints" in arm.get_last_followed().reason
    last = part.joint_trajectory.points[-1].positions[joint]
    assert abs(last - points[0].positions[joint]) <= off + 1e-4
    assert arm.compute_cartesian_path(line(arm, 0.3), 0.01, path_constraints=Constraints())[1] == 1.0


def test_a_blocked_line_names_its_obstacle(arm: MoveGroupCommander, jumping: World) -> None:
    scene = PlanningSceneInterface(world=jumping)
    x, y = arm.get_current_pose().pose.position.x, arm.get_current_pose().pose.position.y
    scene.add_box("wall", stamped(placement((x, y + 0.3, 0.1)), "base"), (0.4, 0.05, 0.3))
    trajectory, fraction = arm.compute_cartesian_path(line(arm, 0.35), 0.01)
    assert 0.0 < fraction < 1.0
    assert trajectory.joint_trajectory.points
    assert "wall" in arm.get_last_followed().reason
    assert arm.compute_cartesian_path(line(arm, 0.35), 0.01, avoid_collisions=False)[1] == 1.0


def test_a_path_to_the_present_pose_is_a_rest(arm: MoveGroupCommander, jumping: World) -> None:
    trajectory, fraction = arm.compute_cartesian_path(line(arm, 0.0), 0.01)
    assert fraction == 1.0
    assert arm.get_last_followed().verified
    assert arm.execute(trajectory)
    where = arm.get_current_pose().pose.position
    PlanningSceneInterface(world=jumping).add_sphere(
        "ball", stamped(placement((where.x, where.y, where.z)), "base"), 0.1
    )
    trajectory, fraction = arm.compute_cartesian_path(line(arm, 0.0), 0.01)
    assert (fraction, trajectory.joint_trajectory.points) == (0.0, [])
    assert "ball" in arm.get_last_followed().reason


@pytest.mark.parametrize(
    ("misuse", "said"),
    [
        (lambda arm: arm.compute_cartesian_path(line(arm, 0.1), 0.01, "no"), "is True or False, not 'no'"),
        (lambda arm: arm.compute_cartesian_path(line(arm, 0.1), 0.0), "eef_step must be positive"),
        (lambda arm: arm.compute_cartesian_path(line(arm, 0.1), "1 cm"), "eef_step: must be a number"),
        (lambda arm: arm.compute_cartesian_path(line(arm, 0.1)[0], 0.01), "waypoints must be a list"),
        (lambda arm: arm.compute_cartesian_path([], 0.01), "give at least one waypoint"),
        (lambda arm: arm.compute_cartesian_path([[1, 2]], 0.01), "a pose is"),
        (lambda arm: arm.pick("cup"), "names no <end_effector>"),
    ],
)
def test_misuse(arm: MoveGroupCommander, misuse: Callable[..., object], said: str) -> None:
    with pytest.raises(MoveItCommanderException, match=said):
        misuse(arm)


@pytest.fixture
def panda() -> MoveGroupCommander:
    try:
        world = World("panda")
    except MissingExtra:
        pytest.skip("the Panda's meshes are not installed")
    scene = PlanningSceneInterface(world=world)
    scene.add_box("table", stamped(placement((0.5, 0.0, 0.1)), ""), (0.4, 0.8, 0.2))
    scene.add_box("box", stamped(placement((0.45, -0.2, 0.25)), ""), (0.04, 0.05, 0.1))
    arm = MoveGroupCommander("panda_arm", world=world)
    arm.set_end_effector_link("panda_hand_tcp")
    return arm


def fingers(opening: float) -> JointTrajectory:
    names = ["panda_finger_joint1", "panda_finger_joint2"]
    return JointTrajectory(joint_names=names, points=[JointTrajectoryPoint([opening / 2.0] * 2)])


def test_a_grasp_that_a_script_gives(panda: MoveGroupCommander) -> None:
    grasp = Grasp(id="from above", pre_grasp_posture=fingers(0.08), grasp_posture=fingers(0.05))
    grasp.grasp_pose = stamped(placement((0.45, -0.2, 0.28), rpy=(np.pi, 0, 0)), "panda_link0")
    for way, direction in ((grasp.pre_grasp_approach, (0, 0, -1)), (grasp.post_grasp_retreat, (0, 0, 1))):
        way.direction.header.frame_id = "panda_link0"
        way.direction.vector.x, way.direction.vector.y, way.direction.vector.z = map(float, direction)
        way.desired_distance = 0.08
    assert panda.pick("box", grasp, plan_only=True) == MoveItErrorCodes.SUCCESS
    carried = panda.get_last_pick_place()
    assert carried.grasp.name == "from above"
    assert carried.grasp.approach.distance == 0.08
    taken = carried.segment(grasping.Stage.APPROACH)
    tool = taken.scene.placement_of("panda_hand_tcp", taken.end)
    assert np.allclose(tool.translation, (0.45, -0.2, 0.28), atol=1e-3)
    assert panda.get_last_outcome() is None


def test_fingers_told_to_close_wholly_stop_at_the_object_and_open_as_told(panda: MoveGroupCommander) -> None:
    """As in MoveIt's tutorial: the fingers were planned into the box, and opened 2 cm wide at the place."""
    grasp = Grasp(pre_grasp_posture=fingers(0.078), grasp_posture=fingers(0.0))
    grasp.grasp_pose = stamped(placement((0.45, -0.2, 0.28), rpy=(np.pi, 0, 0)), "panda_link0")
    assert panda.pick("box", [grasp]) == MoveItErrorCodes.SUCCESS
    assert panda.get_last_pick_place().grasp.width == pytest.approx(0.05, abs=1e-4)
    spot = PlaceLocation(post_place_posture=fingers(0.074))
    spot.place_pose = stamped(placement((0.45, 0.2, 0.25)), "panda_link0")
    assert panda.place("box", [spot]) == MoveItErrorCodes.SUCCESS
    released = panda.get_last_pick_place().segment(grasping.Stage.RELEASE)
    joint = released.scene.robot.index(["panda_finger_joint1"])
    assert released.end[joint] == pytest.approx(0.037, abs=1e-4)


def test_reports_that_no_path_exists(panda: MoveGroupCommander) -> None:
    far = Grasp(pre_grasp_posture=fingers(0.08), grasp_posture=fingers(0.05))
    far.grasp_pose = stamped(placement((3.0, 0.0, 0.3)), "panda_link0")
    assert panda.pick("box", [far]) == MoveItErrorCodes.PLANNING_FAILED
    assert "pick box: reach" in panda.get_last_outcome().error_code.message


@pytest.mark.parametrize(
    ("misuse", "said"),
    [
        (lambda arm: arm.pick("bxo"), r"did you mean 'box'\?\); there are: box, table"),
        (
            lambda arm: arm.pick("box", Grasp()),
            "grasp_posture: give a position for each of panda_f",
        ),
        (lambda arm: arm.place("box"), "say where 'box' is put"),
        (lambda arm: arm.place("box", PlaceLocation()), "is not in a hand"),
    ],
)
def test_misuse_of_hands(panda: MoveGroupCommander, misuse: Callable[..., object], said: str) -> None:
    with pytest.raises(MoveItCommanderException, match=said):
        misuse(panda)
