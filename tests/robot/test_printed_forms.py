"""What is printed is short and in the units that people speak in."""

import re

import numpy as np
import pytest

import trajopt as to
from tests.problem.requirements.kind import kinds
from trajopt.optimise.kinematics import self_motion
from trajopt.planning.infeasibility.reasons import unreachable
from trajopt.tasks.cartesian import polyline
from trajopt.values.curve import joined
from trajopt.values.errors import ProblemError

AT = to.placement((0.41, 0.3, 0.14))


def test_a_placement() -> None:
    assert str(AT) == "(0.41, 0.3, 0.14) m"
    assert str(to.placement((0, 0, 1), rpy=(np.pi, 0, 0))) == "(0, 0, 1) m turned by rpy (180, 0, 0) deg"
    assert repr(AT).startswith("placement(xyz=")


def test_a_printed_problem_contains_its_goal() -> None:
    robot = to.load("planar2")
    goal = to.frame_placement(robot.links[-1], AT)
    problem = to.Problem(scene=to.Scene(robot), start={}, goal=goal)
    assert f"at the end   {goal}" in str(problem)


@pytest.mark.parametrize(
    ("required", "said"),
    [
        *(pair for kind in kinds() for pair in kind.printed),
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


def test_a_curve_reports_the_unit_of_a_gap_between_its_pieces() -> None:
    begin, middle, end = (to.placement((0.1 * k, 0, 0)) for k in range(3))
    away = to.placement((0.112, 0, 0))
    turned = to.placement((0.1, 0, 0), rpy=(0, 0, np.pi / 6))
    with pytest.raises(ProblemError, match=r"do not meet: 12 mm apart$"):
        joined((polyline((begin, middle)), polyline((away, end))))
    with pytest.raises(ProblemError, match=r"do not meet: turned by 30 deg$"):
        joined((polyline((begin, middle)), polyline((turned, end))))


def test_messages_give_the_violation_in_the_unit_of_the_requirement() -> None:
    robot = to.load("planar2")
    far = to.position_in_region(robot.links[-1], to.Sphere(0.01), to.placement((0.1, 0, 5.0)))
    goal = to.joint_positions(dict.fromkeys(robot.joint_names, 0.1))
    problem = to.Problem(scene=to.Scene(robot), start={}, goal=goal, constraints=[far])
    with pytest.raises(ProblemError, match=r"missed by [0-9.]+ m$"):
        self_motion(problem.reduced, far, problem.reduced.start_positions)
    reason = to.plan(problem).reason
    assert f"{far}: missed by " in reason and reason.endswith(" m)")
    begin = problem.reduced.start_positions
    assert re.search(r"misses the goal by [0-9.]+ m$", unreachable(problem.reduced, (), begin, (far,)))
    assert unreachable(problem.reduced, (), begin, (goal,)).endswith("misses the goal by 5.72 deg")
    bent = problem.reduced.limits.upper * (0.0, 1.0)
    joint, degrees = robot.joint_names[1], np.rad2deg(bent[1])
    assert unreachable(problem.reduced, (), bent, (far,)).endswith(
        f" m, with {joint} at its limit of {degrees:.4g} deg"
    )


def test_a_finger_is_no_reason_to_miss_a_pose() -> None:
    far = to.frame_placement("panda_hand", to.placement((0.6, 0.5, 0.8)))
    start = {"panda_finger_joint1": 0.04, "panda_joint4": -0.0698}
    problem = to.Problem(scene=to.Scene(to.load("panda")), group="panda_arm_hand", start=start, goal=far)
    words = unreachable(problem.reduced, (), problem.reduced.start_positions, (far,))
    assert words.endswith("with panda_joint4 at its limit of -3.999 deg")
    fingers = to.joint_positions({"panda_finger_joint1": 0.02})
    assert "panda_finger_joint1 at its limit" in unreachable(
        problem.reduced, (), problem.reduced.start_positions, (far, fingers)
    )
