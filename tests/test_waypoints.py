"""Waypoints: where the planner puts them, what the judge makes of their order, and whole plans."""

import numpy as np
import pytest

import trajopt as to
from tests.test_requirement_plans import GOAL, START, TCP, tcp
from trajopt.optimise.transcription import transcribe
from trajopt.planning import Plan
from trajopt.planning.seeds import line_through
from trajopt.problem.requirements import Requirement
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.errors import ProblemError
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Check, Evidence, verify


@pytest.fixture(scope="module")
def planar() -> ReducedModel:
    robot = to.load("planar2")
    return reduce_model(to.Scene(robot), next(iter(robot.groups)), robot.positions())


@pytest.fixture(scope="module")
def panda() -> to.Robot:
    return to.load("panda")


def judged(reduced: ReducedModel, *waypoints: Requirement | tuple[Requirement, ...]) -> list[Check]:
    """Judge a motion of the first joint from 0 to 1 and back to 0.5, the second standing."""
    knots = np.array(((0.0, 0.1), (1.0, 0.1), (0.5, 0.1)))
    still = np.zeros_like(knots)
    motion = Trajectory(reduced.joint_names, np.array((0.0, 1.0, 2.0)), knots, still, still)
    stops = [(item,) if isinstance(item, Requirement) else item for item in waypoints]
    certificate = verify(
        reduced, motion, goals=(), waypoints={str(n): stop for n, stop in enumerate(stops, start=1)}
    )
    return [check for check in certificate.checks if check.name.startswith("waypoint")]


def at(reduced: ReducedModel, value: float, tolerance: float = 1e-4) -> Requirement:
    return to.joint_positions({reduced.joint_names[0]: value}, tolerance=tolerance)


def test_waypoints_count_in_order_only(planar: ReducedModel) -> None:
    """Half way is passed on the way there and again at the end; a quarter only on the way there."""
    found = judged(planar, at(planar, 0.25), at(planar, 0.5), at(planar, 1.0), at(planar, 0.5))
    assert all(check.holds and check.evidence is Evidence.PROVEN for check in found)
    times = [check.time or 0.0 for check in found]
    assert times == sorted(times)
    assert times[1] == pytest.approx(0.5, abs=0.01)
    assert times[2] == pytest.approx(1.0, abs=0.05)
    first, second = judged(planar, at(planar, 1.0), at(planar, 0.25))
    assert first.holds
    assert not second.holds
    assert second.slack == pytest.approx(-0.25, abs=1e-3)


def test_a_waypoint_between_two_samples_is_found(planar: ReducedModel) -> None:
    """So tight that the motion is within the tolerance for microseconds only."""
    (found,) = judged(planar, at(planar, 0.431234567, tolerance=2e-6))
    assert found.holds
    (missed,) = judged(planar, at(planar, 1.01, tolerance=5e-3))
    assert not missed.holds
    assert missed.slack == pytest.approx(-5e-3, abs=1e-6)
    assert "nearest moment" in missed.detail


def test_all_of_a_waypoint_must_hold_together(planar: ReducedModel) -> None:
    tip = planar.scene.robot.links[-1]
    where = planar.scene.placement_of(tip, planar.all_positions(np.array((0.5, 0.1))))
    here = to.frame_placement(tip, where, position_tolerance=1e-3, rotation_tolerance=1e-3)
    along = to.axis_alignment(tip, axis=(1, 0, 0), direction=where.rotation[:, 0], tolerance=0.01)
    (found,) = judged(planar, (here, along, at(planar, 0.5, 0.01)))
    assert found.holds
    (never,) = judged(planar, (here, at(planar, 0.9, 0.01)))
    assert not never.holds


def test_legs_get_knots_by_their_length(planar: ReducedModel) -> None:
    stops = [np.array(stop) for stop in ((0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (1.0, 3.0))]
    line = line_through(planar, stops, 21)
    assert line.knots.shape == (21, 2)
    assert len(line.places) == 2
    assert line.places[1] == line.places[0] + 1, "a leg of no length still has a knot"
    for place, stop in zip((0, *line.places, 20), stops, strict=True):
        assert line.knots[place] == pytest.approx(stop)
    crowded = line_through(planar, stops, 4)
    assert crowded.places == (1, 2)


def problem(panda: to.Robot, *waypoints: object, **more: object) -> to.Problem:
    return to.Problem(
        scene=to.Scene(panda),
        group="panda_arm",
        start=START,
        goal=to.joint_positions(GOAL),
        waypoints=waypoints,  # type: ignore[arg-type]
        **more,  # type: ignore[arg-type]
    )


def test_a_plan_passes_a_configuration_and_a_placement(panda: to.Robot) -> None:
    up = to.joint_positions({**START, "panda_joint1": 0.2, "panda_joint4": -2.0}, tolerance=0.01)
    above = tcp(panda, GOAL) + np.array((0.0, 0.0, 0.15))
    over = to.frame_placement(
        TCP,
        to.placement(above, rpy=(np.pi, 0, 0)),
        position_tolerance=0.01,
        rotation_tolerance=(0.1, 0.1, np.inf),
    )
    asked = problem(panda, up, [over])
    assert str(asked).count("on the way") == 2
    plan = to.plan(asked).require()
    found = [check for check in plan.certificate.checks if check.name.startswith("waypoint")]
    assert [check.name.split(":")[0] for check in found] == ["waypoint 1", "waypoint 2"]
    assert all(check.holds for check in found)
    first, second = (check.time or 0.0 for check in found)
    assert 0.0 < first < second < plan.trajectory.duration
    tip = panda_tip(plan, second)
    assert np.abs(tip - above).max() <= 0.01 + 1e-6


def panda_tip(plan: Plan, time: float) -> np.ndarray:
    reduced = plan.problem.reduced
    full = reduced.all_positions(plan.trajectory(np.array((time,)))[0])
    return reduced.scene.placement_of(TCP, full).translation


def test_an_unreachable_waypoint_is_reported(panda: to.Robot) -> None:
    far = to.frame_placement(TCP, to.placement((3.0, 0.0, 0.5)))
    result = to.plan(problem(panda, far))
    assert result.status is to.Status.NO_WAYPOINT
    assert "waypoint 1" in result.message
    blocked = problem(panda, to.joint_positions(START))
    wall = blocked.scene.add("wall", to.Sphere(0.05), to.placement(tuple(tcp(panda, GOAL))))
    everything = {**GOAL, "panda_joint3": 0.0, "panda_joint5": 0.0}
    inside = to.Problem(
        scene=wall,
        group="panda_arm",
        start=START,
        goal=to.joint_positions(START),
        waypoints=[to.joint_positions(everything)],
    )
    result = to.plan(inside)
    assert result.status is to.Status.NO_WAYPOINT
    assert "wall" in result.message


def test_bad_input_is_refused(panda: to.Robot) -> None:
    for call in (
        lambda: problem(panda, 3.0),
        lambda: problem(panda, []),
        lambda: problem(panda, *[to.joint_positions(START)] * 5, knots=6),
        lambda: transcribe(problem(panda, to.joint_positions(START)), np.zeros((24, 7))),
        lambda: transcribe(problem(panda, to.joint_positions(START)), np.zeros((24, 7)), (23,)),
    ):
        with pytest.raises(ProblemError):
            call()
