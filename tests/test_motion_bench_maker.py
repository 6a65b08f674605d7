"""Real problems: MotionBenchMaker's scenes and requests, from the straight line alone."""

from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from trajopt.geometry.geometry import collision_geometry
from trajopt.lab.suite import Instance, run
from trajopt.lab.suite.instance import find_instances, summary
from trajopt.values.shapes.shapes import Box, Convex, Cylinder, Shape, Sphere

SETS = (
    "bookshelf_small",
    "bookshelf_tall",
    "bookshelf_thin",
    "box",
    "cage",
    "table_pick",
    "table_under_pick",
)


@pytest.fixture(scope="module")
def panda() -> to.Robot:
    try:
        return to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def problems(shared_data: Path) -> Path:
    return shared_data / "motionbenchmaker" / "panda"


def instance(folder: Path, robot: to.Robot, name: str, index: int = 1) -> Instance:
    return {item.name: item for item in find_instances(folder, robot, [name], limit=index)}[f"{name}/{index}"]


def densely_free(problem: to.Problem, trajectory: to.Trajectory) -> bool:
    """Check at 300 times with the full robot model, on its own: no reduced model, no culling."""
    scene, robot = problem.scene, problem.scene.robot
    data = robot.model.createData()
    shapes: list[tuple[str, str, to.Placement, Shape]] = [
        *((body.owner, body.frame, body.placement, body.shape) for body in robot.bodies),
        *((body.owner, body.frame, body.placement, body.shape) for body in scene.object_bodies()),
    ]
    assert all(isinstance(shape, Box | Sphere | Cylinder | Convex) for *_, shape in shapes)
    geometries = [collision_geometry(shape) for *_, shape in shapes]
    pairs = [
        (i, j)
        for j, b in enumerate(shapes)
        for i, a in enumerate(shapes[:j])
        if a[0] != b[0]
        and not scene.may_touch(a[0], b[0])
        and {a[1], b[1]} != {"world"}
        and {a[1], b[1]} != {"world", robot.links[0]}
    ]
    places = robot.index(trajectory.joint_names)
    for q in trajectory(np.linspace(0.0, trajectory.duration, 300)):
        full = np.array(problem.start_positions)
        full[places] = q
        pin.framesForwardKinematics(robot.model, data, robot.configuration(full))
        where: list[coal.Transform3s] = []
        for _, frame, placement, _ in shapes:
            held = pin.SE3.Identity() if frame == "world" else data.oMf[robot.model.getFrameId(frame)]
            at = held * pin.SE3(placement.rotation, placement.translation)
            where.append(coal.Transform3s(at.rotation, at.translation))
        for i, j in pairs:
            result = coal.CollisionResult()
            if coal.collide(
                geometries[i], where[i], geometries[j], where[j], coal.CollisionRequest(), result
            ):
                return False
    return True


@pytest.mark.parametrize("name", SETS)
def test_first_of_each_set(panda: to.Robot, problems: Path, name: str) -> None:
    outcome = run(instance(problems, panda, name))
    assert outcome.verified, outcome.message
    assert outcome.counts["distance_calls"] > 0


@pytest.mark.parametrize("name", ["box", "cage"])
def test_an_independent_dense_check_agrees(panda: to.Robot, problems: Path, name: str) -> None:
    problem = instance(problems, panda, name, 3).make()
    plan = to.plan(problem).require()
    assert densely_free(problem, plan.trajectory)


def test_goal_beyond_a_limit_is_a_result(panda: to.Robot, problems: Path) -> None:
    outcome = run(instance(problems, panda, "table_under_pick", 3))
    assert outcome.status is to.Status.GOAL_OUT_OF_LIMITS and not outcome.askable
    assert "panda_joint4" in outcome.message


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_success_on_the_whole_panda_sets(panda: to.Robot, problems: Path) -> None:
    outcomes = [run(item) for item in find_instances(problems, panda)]
    assert sum(not outcome.askable for outcome in outcomes) == 3
    assert summary(outcomes)["success"] >= 0.95  # pyright: ignore[reportOperatorIssue]
