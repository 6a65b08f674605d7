"""Reported clouds: the rest of the motion is judged against the newest."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.driving.test_supervisor import CYCLE, in_the_way, kinds, problem, run, supervised
from trajopt.driving import EventKind
from trajopt.values.errors import ModelError, ProblemError
from trajopt.verify import examine

__all__ = ["problem"]  # a fixture
SPACING = 0.02


def seen(scene: to.Scene, name: str) -> to.Points:
    """Return points on the surface of a box, and balls that cover it."""
    item = scene.objects[name]
    ((box, where),) = item.parts
    assert isinstance(box, to.Box)
    half = np.array((box.x, box.y, box.z)) / 2.0
    axes = [np.linspace(-1.0, 1.0, 1 + round(2.0 * side / SPACING)) for side in half.tolist()]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[np.abs(points).max(axis=1) > 1.0 - 1e-9] * half
    return to.Points((item.placement * where) * points, SPACING * np.sqrt(0.5))


def test_stops_or_replans_for_a_cloud_in_the_way(problem: to.Problem) -> None:
    world = in_the_way(problem)
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    assert supervisor.see_cloud("camera", seen(world, "surprise"), arm.now())
    driven = [arm.state().positions]
    while supervisor.busy and arm.now() < 10.0:
        supervisor.cycle()
        for _ in range(4):
            arm.advance(CYCLE / 4)
            driven.append(arm.state().positions)
    assert kinds(supervisor)[-1] is EventKind.REACHED
    assert EventKind.UNPROVEN_STOP not in kinds(supervisor) and EventKind.STILL_CLEAR not in kinds(supervisor)
    columns = problem.scene.robot.index(problem.reduced.joint_names)
    for scene in (world, supervisor.scene):  # of the thing itself, and of every ball
        clear = replace(problem, scene=scene).reduced
        assert all(examine(clear, positions[columns]).clear for positions in driven)


def test_cloud_elsewhere_does_not_slow_the_robot_and_is_replaced(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    away = to.Points(np.array(((0.0, -0.8, 0.3), (0.0, -0.8, 0.31))), 0.01)
    assert supervisor.see_cloud("camera", away)
    run(arm, supervisor, 0.3)
    assert supervisor.see_cloud("camera", to.Points(away.points[:1], 0.01))
    assert len(supervisor.scene.objects["camera"].parts[0][0]) == 1
    assert {*supervisor.scene.objects} == {*problem.scene.objects, "camera"}
    run(arm, supervisor, 10.0)
    seen = [EventKind.WORLD_CHANGED, EventKind.STILL_CLEAR]
    assert kinds(supervisor) == [EventKind.STARTED, *seen, *seen, EventKind.REACHED]


def test_older_cloud_does_not_replace_a_newer_one(problem: to.Problem) -> None:
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    newest = seen(in_the_way(problem), "surprise")
    assert supervisor.see_cloud("camera", newest, 0.19)
    assert not supervisor.see_cloud("camera", None, 0.15)
    assert supervisor.scene.objects["camera"].parts[0][0] is newest
    assert supervisor.see_cloud("other camera", None, 0.15)  # each camera has a clock of its own
    assert supervisor.see_cloud("camera", None, 0.2)
    assert supervisor.scene.objects["camera"].parts == ()
    run(arm, supervisor, 10.0)
    assert kinds(supervisor)[-1] is EventKind.REACHED


def test_robot_resumes_when_the_blocking_cloud_disappears(problem: to.Problem) -> None:
    columns = problem.scene.robot.index(problem.reduced.joint_names)
    end = np.array(problem.start_positions)
    end[columns] = to.plan(problem).require().trajectory.positions[-1]
    there = problem.scene.placement_of("panda_hand", end).translation
    arm, supervisor = supervised(problem)
    run(arm, supervisor, 0.2)
    supervisor.see_cloud(
        "camera", to.Points(there + np.zeros((1, 3)), 0.1)
    )  # where the hand has to be at last
    run(arm, supervisor, 2.0)
    assert not supervisor.moving and EventKind.REACHED not in kinds(supervisor)
    supervisor.see_cloud("camera", None)
    run(arm, supervisor, 12.0)
    assert kinds(supervisor)[-1] is EventKind.REACHED


def test_refused_clouds_do_not_change_the_world(problem: to.Problem) -> None:
    _, supervisor = supervised(problem)
    name = next(iter(problem.scene.objects))
    with pytest.raises(ModelError, match="is not a cloud"):
        supervisor.see_cloud(name, to.Points(np.zeros((1, 3)), 0.01))
    with pytest.raises(ModelError, match="taken by a frame"):
        supervisor.see_cloud("panda_hand", None)
    with pytest.raises(ProblemError, match="cloud must be"):
        supervisor.see_cloud("camera", np.zeros((3, 3)))
    assert supervisor.scene is problem.scene
