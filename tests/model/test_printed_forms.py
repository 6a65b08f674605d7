"""What is printed is short and in the units that people speak in."""

import numpy as np
import pytest

import trajopt as to
from trajopt.cartesian import follows_curve, polyline
from trajopt.errors import ProblemError
from trajopt.infeasibility.reasons import unreachable
from trajopt.kinematics import self_motion
from trajopt.model.curve import joined
from trajopt.model.requirements import Requirement
from trajopt.model.requirements.requirement import missed_by

INF = np.inf
AT = to.placement((0.41, 0.3, 0.14))


def test_a_placement() -> None:
    assert str(AT) == "(0.41, 0.3, 0.14) m"
    assert str(to.placement((0, 0, 1), rpy=(np.pi, 0, 0))) == "(0, 0, 1) m turned by rpy (180, 0, 0) deg"
    assert repr(AT).startswith("placement(xyz=")


@pytest.mark.parametrize(
    ("tolerances", "said"),
    [
        ({}, "within 0.1 mm and 0.0573 deg"),
        (
            {"position_tolerance": 1e-3, "rotation_tolerance": (np.deg2rad(5), np.deg2rad(5), INF)},
            "within 1 mm and 5 deg, free about z",
        ),
        (
            {"position_tolerance": (INF, 1e-3, 2e-3), "rotation_tolerance": INF},
            "within y 1, z 2 mm, free along x, free about x, y, z",
        ),
    ],
)
def test_a_frame_at_a_placement(tolerances: dict[str, object], said: str) -> None:
    goal = to.frame_placement("cup", AT, **tolerances)  # type: ignore[arg-type]
    assert str(goal) == f"cup at (0.41, 0.3, 0.14) m, {said}"
    seen = to.frame_placement("cup", AT, reference="tray")
    assert str(seen).startswith("cup at (0.41, 0.3, 0.14) m from tray, ")


def test_a_problem_says_its_goal_so() -> None:
    robot = to.load("planar2")
    goal = to.frame_placement(robot.links[-1], AT)
    problem = to.Problem(scene=to.Scene(robot), start={}, goal=goal)
    assert f"at the end   {goal}" in str(problem)


THREE = to.placement((0.5, 0, 0.2))
RISING = {"a": 1.0, "b": -1.0, "c": 0.5}
LINE = polyline([to.placement((0.4, 0, 0.5)), to.placement((0.4, 0.3, 0.5))])


@pytest.mark.parametrize(
    ("required", "said"),
    [
        (to.axis_alignment("cup", tolerance=np.deg2rad(5)), "z of cup along z of world, within 5 deg"),
        (
            to.axis_alignment("cup", axis=(0, -1, 0), direction=(3, 4, 0), tolerance=0.1, reference="tray"),
            "-y of cup along (0.6, 0.8, 0) of tray, within 5.73 deg",
        ),
        (to.coupled_joints(RISING, tolerance=0.01), "a - b + 0.5 c = 0, within 0.01"),
        (to.distance_between("a", "b", lower=0.05), "a and b at least 50 mm apart"),
        (to.distance_between("a", "b", upper=0.4), "a and b at most 0.4 m apart"),
        (to.distance_between("a", "b", lower=0.05, upper=0.4), "a and b 50 mm to 0.4 m apart"),
        (to.gaze("eye", (0.5, 0, 0.2), angle=np.pi / 6), "eye looks at (0.5, 0, 0.2) m, within 30 deg"),
        (
            to.gaze("eye", (0, 0, 0), angle=np.pi / 6, nearest=0.05, farthest=2, reference="cup"),
            "eye looks at (0, 0, 0) m from cup, within 30 deg, at least 50 mm away, at most 2 m away",
        ),
        (to.gravity_torque(0.5), "gravity takes at most 50% of the effort limits"),
        (to.joint_positions({"a": 0.5, "b": -1}), "a = 0.5, b = -1, within 0.0001"),
        (
            to.joint_positions({"a": 0.5, "b": 1}, tolerance=0.1, above={"a": 0.2}),
            "a = 0.5 (-0.1, +0.2), b = 1 (-0.1, +0.1)",
        ),
        (
            to.point_on_arc("tip", THREE, radius=0.2, tolerance=1e-3),
            "tip on a circle of radius 0.2 m about (0.5, 0, 0.2) m, within 1 mm",
        ),
        (
            to.point_on_arc("tip", THREE, radius=0.05, sweep=np.pi / 2, tolerance=1e-3, reference="tray"),
            "tip on an arc of 90 deg of radius 50 mm about (0.5, 0, 0.2) m from tray, within 1 mm",
        ),
        (
            to.line_of_sight("eye", (0.5, 0, 0.2)),
            "eye sees (0.5, 0, 0.2) m, its line of sight clear by 10 mm",
        ),
        (
            to.position_in_region("tip", to.Sphere(0.05), THREE),
            "tip in a sphere of radius 50 mm at (0.5, 0, 0.2) m",
        ),
        (
            to.position_in_region("tip", to.Box(0.05, 0.2, 0.3), THREE, reference="tray"),
            "tip in a box of 50 mm x 0.2 m x 0.3 m at (0.5, 0, 0.2) m from tray",
        ),
        (
            to.position_in_region("tip", [(to.Cylinder(0.05, 0.2), THREE), (to.Plane(), THREE)]),
            "tip in a cylinder of radius 50 mm and length 0.2 m along z at (0.5, 0, 0.2) m "
            "or below the plane through (0.5, 0, 0.2) m with normal z",
        ),
        (
            to.point_on_line("tip", (0.5, 0, 0.2), (1, 0, 0), tolerance=1e-3),
            "tip on the line through (0.5, 0, 0.2) m along x, within 1 mm",
        ),
        (
            to.point_on_plane("tip", (0.5, 0, 0.2), (0, 0, -1), tolerance=1e-3),
            "tip on the plane through (0.5, 0, 0.2) m with normal -z, within 1 mm",
        ),
        (to.singularity_distance("hand", 0.05), "smallest singular value of hand at least 0.05"),
        (
            follows_curve("tip", LINE, spin=(0, 0, 1)),
            "tip along a curve of 0.3 m from (0.4, 0, 0.5) m to (0.4, 0.3, 0.5) m, "
            "within 0.1 mm and 0.1 deg, free about z",
        ),
        (
            follows_curve("tip", LINE, until=0.05, rotation_tolerance=INF, reference="tray"),
            "tip along the first 50 mm of a curve of 0.3 m from (0.4, 0, 0.5) m to (0.4, 0.3, 0.5) m in "
            "tray, within 0.1 mm",
        ),
        (
            to.during(to.gravity_torque(0.5), after="via"),
            "gravity takes at most 50% of the effort limits, from via to the end",
        ),
        (to.any_of({"top": to.gravity_torque(0.5), "side": to.gravity_torque(0.4)}), "any of top, side"),
        (
            to.tool_speed("tip", linear=0.05, angular=np.pi, steady=0.1),
            "tip at most 50 mm/s and 180 deg/s, steady within 10%",
        ),
        (to.tool_speed("tip", linear=0.25), "tip at most 0.25 m/s"),
    ],
)
def test_a_requirement(required: object, said: str) -> None:
    assert str(required) == said


@pytest.mark.parametrize(
    ("required", "said"),
    [
        ((to.distance_between("a", "b", lower=0.05),), "12 mm"),
        ((to.position_in_region("tip", to.Sphere(0.05)), to.distance_between("a", "b", lower=0.1)), "12 mm"),
        ((to.frame_placement("cup", AT, rotation_tolerance=INF),), "12 mm"),
        ((to.frame_placement("cup", AT, position_tolerance=INF),), "0.688 deg"),
        ((to.axis_alignment("cup", tolerance=0.1),), "0.688 deg"),
        ((to.line_of_sight("eye", (0.5, 0, 0.2)),), "12 mm"),
        ((to.gaze("eye", (0.5, 0, 0.2), angle=0.5),), "0.688 deg"),
        ((to.gaze("eye", (0.5, 0, 0.2), angle=0.5, farthest=2.0),), "0.012"),
        ((follows_curve("tip", LINE, rotation_tolerance=INF),), "12 mm"),
        ((follows_curve("tip", LINE),), "0.012"),
        ((to.frame_placement("cup", AT),), "0.012"),
        ((to.frame_placement("cup", AT, rotation_tolerance=INF), to.gravity_torque()), "0.012"),
        ((to.joint_positions({"a": 0.5}),), "0.012"),
    ],
)
def test_what_is_missed_has_its_unit_where_all_share_one(
    required: tuple[Requirement, ...], said: str
) -> None:
    assert missed_by(0.012, required) == said


def test_a_curve_says_in_which_unit_its_pieces_do_not_meet() -> None:
    begin, middle, end = (to.placement((0.1 * k, 0, 0)) for k in range(3))
    away = to.placement((0.112, 0, 0))
    turned = to.placement((0.1, 0, 0), rpy=(0, 0, np.pi / 6))
    with pytest.raises(ProblemError, match=r"do not meet: 12 mm apart$"):
        joined((polyline((begin, middle)), polyline((away, end))))
    with pytest.raises(ProblemError, match=r"do not meet: turned by 30 deg$"):
        joined((polyline((begin, middle)), polyline((turned, end))))


def test_messages_say_by_how_much_in_the_unit_of_the_requirement() -> None:
    robot = to.load("planar2")
    far = to.position_in_region(robot.links[-1], to.Sphere(0.01), to.placement((0.1, 0, 5.0)))
    goal = to.joint_positions(dict.fromkeys(robot.joint_names, 0.1))
    problem = to.Problem(scene=to.Scene(robot), start={}, goal=goal, constraints=[far])
    with pytest.raises(ProblemError, match=r"missed by [0-9.]+ m$"):
        self_motion(problem.reduced, far, problem.reduced.start_positions)
    reason = to.plan(problem).reason
    assert f"{far}: missed by " in reason and reason.endswith(" m)")
    assert unreachable((), 0.012, (far,)).endswith("misses the goal by 12 mm")
    assert unreachable((), 0.012, (goal,)).endswith("misses the goal by 0.012")
