"""What holds between waypoints only: in the program, by the judge, and on no more of the motion than that."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.test_requirement_plans import GOAL, START, TCP, tcp
from trajopt.problem.requirements import During, Requirement
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.errors import ProblemError, ShapeError, WaypointNotFound
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Certificate, Evidence, verify


@pytest.fixture(scope="module")
def planar() -> ReducedModel:
    robot = to.load("planar2")
    return reduce_model(to.Scene(robot), next(iter(robot.groups)), robot.positions())


def turned(reduced: ReducedModel, partial: During[Requirement]) -> Certificate:
    """Judge a motion of the first joint from 0 to 1 and back to 0, which passes 0.5 on the way there."""
    knots = np.array(((0.0, 0.1), (1.0, 0.1), (0.0, 0.1)))
    still = np.zeros_like(knots)
    motion = Trajectory(reduced.joint_names, np.array((0.0, 1.0, 2.0)), knots, still, still)
    name = reduced.joint_names[0]
    waypoints = {
        "half": [to.joint_positions({name: 0.5}, tolerance=0.01)],
        "turn": [to.joint_positions({name: 1.0}, tolerance=0.01)],
    }
    return verify(reduced, motion, goals=(), waypoints=waypoints, partial=[partial])


def within(reduced: ReducedModel, low: float, high: float) -> Requirement:
    return to.joint_positions({reduced.joint_names[0]: (low + high) / 2}, tolerance=(high - low) / 2)


@pytest.mark.parametrize(
    ("low", "high", "after", "until", "holds"),
    [
        (0.45, 1.05, "half", "turn", True),
        (0.55, 1.05, "half", "turn", False),  # fails only where the part begins
        (0.45, 0.95, "half", "turn", False),  # fails only where it ends
        (-0.05, 0.55, None, "half", True),
        (-0.05, 0.45, None, "half", False),
        (0.45, 1.05, "half", None, False),  # the way back is beyond
        (-0.05, 1.05, "turn", None, True),
    ],
)
def test_the_part_is_judged_and_nothing_else(
    planar: ReducedModel, low: float, high: float, after: str | None, until: str | None, holds: bool
) -> None:
    certificate = turned(planar, to.during(within(planar, low, high), after=after, until=until))
    checks = [check for check in certificate.checks if check.name.startswith("path")]
    assert checks
    assert all(check.holds for check in checks) is holds
    if holds:
        assert all(check.evidence is Evidence.PROVEN for check in checks)
        assert all(f"from {after or 'the start'} to {until or 'the end'}" in check.name for check in checks)


def test_times_are_those_of_the_whole_motion(planar: ReducedModel) -> None:
    certificate = turned(planar, to.during(within(planar, -2.0, 1.1), after="turn"))
    (check,) = (check for check in certificate.checks if check.name.startswith("path"))
    assert check.time == pytest.approx(1.0, abs=0.15)


def test_a_part_of_a_trajectory_is_the_trajectory(planar: ReducedModel) -> None:
    rng = np.random.default_rng(3)
    values = [rng.normal(size=(5, 2)) for _ in range(3)]
    times = np.array((0.0, 0.3, 1.1, 1.5, 2.0))
    for orders in (1, 2, 3):
        whole = Trajectory(planar.joint_names, times, *values[:orders])
        for begin, end in ((0.0, 2.0), (0.1, 0.2), (0.3, 1.5), (0.2, 1.7)):
            part = whole.between(begin, end)
            at = np.linspace(0.0, end - begin, 37)[:-1]
            assert part.duration == pytest.approx(end - begin)
            for order in range(orders):
                assert part(at, order) == pytest.approx(whole(at + begin, order), abs=1e-9)
        with pytest.raises(ShapeError):
            whole.between(0.5, 2.5)


def test_a_plan_holds_a_line_from_a_waypoint_to_the_end() -> None:
    """Freely to a place above, then straight down: the line must not be asked of the way there."""
    panda = to.load("panda")
    there = tcp(panda, GOAL)
    above = there + np.array((0.0, 0.0, 0.12))
    down = to.placement(there, rpy=(np.pi, 0, 0))
    high = to.placement(above, rpy=(np.pi, 0, 0))
    line = to.point_on_line(TCP, above, (0.0, 0.0, -1.0), tolerance=0.004)
    problem = to.Problem(
        scene=to.Scene(panda),
        group="panda_arm",
        start=START,
        goal=to.frame_placement(TCP, down, position_tolerance=0.002, rotation_tolerance=0.02),
        waypoints={"above": to.frame_placement(TCP, high, position_tolerance=0.004, rotation_tolerance=0.05)},
        constraints=[to.during(line, after="above")],
    )
    assert "from above to the end" in str(problem)
    plan = to.plan(problem).require()
    checks = {check.name: check for check in plan.certificate.checks}
    (held,) = (check for name, check in checks.items() if "from above to the end" in name)
    assert held.holds and held.evidence is Evidence.PROVEN
    passed = next(check.time for name, check in checks.items() if name.startswith("waypoint above"))
    assert passed is not None
    times = np.linspace(0.0, plan.trajectory.duration, 200)
    reduced = problem.reduced
    tips = np.array(
        [
            reduced.scene.placement_of(TCP, reduced.all_positions(q)).translation
            for q in plan.trajectory(times)
        ]
    )
    off = np.linalg.norm((tips - above)[:, :2], axis=1)
    assert off[times >= passed].max() <= 0.004 + 1e-6
    assert off.max() > 0.05, "the way there is free"


def test_a_constraint_between_missing_waypoints_is_refused() -> None:
    panda = to.load("panda")

    def ask(*parts: During[Requirement]) -> to.Problem:
        return to.Problem(
            scene=to.Scene(panda),
            group="panda_arm",
            start=START,
            goal=to.joint_positions(GOAL),
            waypoints={"first": to.joint_positions(START), "second": to.joint_positions(START)},
            constraints=parts,
        )

    upright = to.axis_alignment(TCP, direction=(0, 0, -1), tolerance=0.2)
    with pytest.raises(WaypointNotFound, match="first"):
        ask(to.during(upright, after="frist"))
    with pytest.raises(ProblemError, match="ends before it begins"):
        ask(to.during(upright, after="second", until="first"))
    with pytest.raises(ProblemError, match="name the waypoint"):
        to.during(upright)
    kept = ask(to.during(upright, until="second"))
    assert [len(kept.requirements_at(stop)) for stop in range(4)] == [1, 1, 1, 0]


def test_two_motions_as_one() -> None:
    whole = to.plan(to.named_problem("past_pillar_ur5")).require().trajectory
    half = whole.duration / 2.0
    first, second = whole.between(0.0, half), whole.between(half, whole.duration)
    again = first.followed_by(second)
    times = np.linspace(0.0, whole.duration, 500)
    for order in range(3):
        assert again(times, order) == pytest.approx(whole(times, order), abs=1e-6)
    with pytest.raises(ShapeError, match="first positions are off by"):
        second.followed_by(first)
    with pytest.raises(ShapeError, match="same joints"):
        first.followed_by(replace(second, joint_names=tuple(f"{name}_" for name in second.joint_names)))
    with pytest.raises(ShapeError, match="same derivatives"):
        first.followed_by(replace(second, accelerations=None))
