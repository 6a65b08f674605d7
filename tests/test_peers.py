"""What the comparison exports for other planners is the same robot."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from benchmarks.peers.export import Asked, write_problems
from benchmarks.peers.judging import judge_result
from trajopt.lab.suite import Instance
from trajopt.verify import Judge


def test_exported_robot_keeps_its_distances(tmp_path: Path) -> None:
    try:
        panda = to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    fingers = {"panda_finger_joint1": 0.03, "panda_finger_joint2": 0.02}
    goal = np.array([0.3, -0.5, 0.2, -2.0, 0.1, 1.6, 0.5])
    joints = panda.group("panda_arm").joints
    problem = to.Problem(
        scene=to.Scene(panda),
        group="panda_arm",
        start={**panda.state("ready"), **fingers},
        goal=to.joint_positions(dict(zip(joints, goal.tolist(), strict=True))),
    )
    files = (tmp_path / "scene.yaml", tmp_path / "request.yaml")
    instance = Instance("set/1", lambda: problem, files=files)
    write_problems(tmp_path, [Asked(instance, problem, goal)], time_limit=1.0)

    model = pin.buildModelFromUrdf(str(tmp_path / "robot.urdf"))
    geometry = pin.buildGeomFromUrdf(model, str(tmp_path / "robot.urdf"), pin.COLLISION)
    assert tuple(model.names[1:]) == problem.reduced.joint_names
    assert len(geometry.geometryObjects) == len(panda.bodies)
    kinds = {item.geometry.getNodeType().name for item in geometry.geometryObjects}
    assert kinds == {"GEOM_CONVEX", "GEOM_BOX"}
    links = [model.frames[item.parentFrame].name for item in geometry.geometryObjects]
    checked = {frozenset(problem.reduced.owners(pair)) for pair in range(len(problem.reduced.pairs.first))}
    for second, b in enumerate(links):
        for first, a in enumerate(links[:second]):
            if frozenset((a, b)) in checked:
                geometry.addCollisionPair(pin.CollisionPair(first, second))
    data = pin.GeometryData(geometry)
    judge = Judge(problem.reduced)
    rng = np.random.default_rng(0)
    for q in rng.uniform(problem.limits.lower, problem.limits.upper, (20, len(joints))):
        pin.computeDistances(model, model.createData(), geometry, data, q)
        nearest = min(result.min_distance for result in data.distanceResults)
        smallest = judge.examine(q).smallest
        assert smallest is not None
        assert nearest == pytest.approx(smallest.distance, abs=1e-5)

    nothing = {"claimed": False, "message": "no path", "setup_cpu": 0.0, "path_cpu": 1.0, "timing_cpu": 0.0}
    record = judge_result(Asked(instance, problem, goal), {**nothing, "path": None, "motion": None})
    assert (record["set"], record["index"], record["message"]) == ("set", 1, "no path")
