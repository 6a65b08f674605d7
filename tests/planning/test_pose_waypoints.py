"""Waypoints of the hand at their default tolerance."""

import numpy as np
import pytest

import trajopt as to

DOWN = (np.pi, 0.0, 0.0)


def around(count: int) -> dict[str, to.Placement]:
    turns = 2.0 * np.pi * np.arange(count) / count
    return {
        f"p{i}": to.placement((0.5 + 0.1 * np.cos(a), 0.1 * np.sin(a), 0.4), rpy=DOWN)
        for i, a in enumerate(turns)
    }


@pytest.mark.parametrize("count", [2, 5, 12])
def test_passes_waypoints_on_a_circle_at_the_first_attempt(count: int) -> None:
    scene = to.Scene(robot=to.load("panda"))
    problem = to.Problem(
        scene=scene, group="panda_manipulator", start="ready", goal="ready", waypoints=around(count)
    )
    result = to.plan(problem)
    assert result.verified
    assert len(result.attempts) == 1


def test_passing_takes_less_time_than_stopping_at_each() -> None:
    scene, group = to.Scene(robot=to.load("panda")), "panda_manipulator"
    passing = to.plan(
        to.Problem(scene=scene, group=group, start="ready", goal="ready", waypoints=around(12))
    ).require()
    duration, start = 0.0, passing.trajectory.positions[0]
    for goal in (*around(12).values(), "ready"):
        leg = to.plan(to.Problem(scene=scene, group=group, start=start, goal=goal)).require()
        duration, start = duration + leg.trajectory.duration, leg.trajectory.positions[-1]
    assert passing.trajectory.duration < duration


def test_stops_at_a_waypoint_on_a_joint_limit() -> None:
    robot = to.load("planar2")
    lowest = float(robot.limits.lower[0])
    problem = to.Problem(
        scene=to.Scene(robot=robot),
        start={"joint1": -2.5, "joint2": 0.5},
        goal={"joint1": -2.5, "joint2": 1.5},
        waypoints={"limit": {"joint1": lowest, "joint2": 1.0}},
    )
    result = to.plan(problem)
    motion = result.require().trajectory
    assert any("stops at each waypoint" in remark for remark in result.remarks)
    times = np.linspace(0.0, motion.duration, 20001)
    nearest = np.abs(motion(times) - np.array((lowest, 1.0))).max(axis=1).argmin()
    assert np.abs(motion(times, 1)[nearest]).max() < 1e-2
