"""Judge one motion with a cloud, and with its balls as separate shapes."""

from math import exp, log
from time import process_time
from typing import Any

import numpy as np

import trajopt as to
from benchmarks.workers import Row
from trajopt.problem.requirements import JointPositions
from trajopt.values.arrays import one_of
from trajopt.verify import CheckKind

FEWEST, MOST = 5, 400
"""Balls of a room: among few half of the motions pass."""


def parity(number: int) -> Row:
    """Judge a random motion of a Panda in a random room both ways."""
    random = np.random.default_rng(number)
    count = int(exp(float(random.uniform(log(FEWEST), log(MOST)))))
    room = random.uniform((-0.8, -0.8, 0.0), (0.8, 0.8, 1.1), (count, 3))
    room = room[np.linalg.norm(room[:, :2], axis=1) > 0.25]
    cloud = to.Points(np.concatenate((room, [(0.0, 0.0, 1.6)])), float(random.uniform(0.005, 0.04)))
    single = [(to.Sphere(cloud.radius), to.placement(point)) for point in cloud.points]
    robot = to.load("panda")
    row: Row = {"points": len(cloud)}
    shapes: dict[str, Any] = {"cloud": cloud, "balls": single}
    for name, shape in shapes.items():
        scene = to.Scene(robot).add("room", shape)
        problem = to.Problem(scene=scene, group="panda_arm", start="ready", goal=_goal(number, robot))
        motion = _motion(problem)
        begin = process_time()
        certificate = to.judge(problem, motion)
        row[name] = {
            "cpu": round(process_time() - begin, 5),
            "holds": [check.holds for check in certificate.checks],
            "clear": all(check.holds for check in certificate.checks if check.kind is CheckKind.CLEARANCE),
            "slack": next(check.slack for check in certificate.checks if check.kind is CheckKind.CLEARANCE),
        }
    return row


def _goal(number: int, robot: to.Robot) -> JointPositions:
    drawn = np.random.default_rng(10_000 + number)
    joints = robot.groups["panda_arm"].joints
    limits = robot.limits.take(robot.index(joints))
    middle, half = (limits.upper + limits.lower) / 2.0, (limits.upper - limits.lower) / 2.0
    goal = middle + 0.6 * half * drawn.uniform(-1.0, 1.0, len(joints))
    return to.joint_positions(dict(zip(joints, goal.tolist(), strict=True)))


def _motion(problem: to.Problem) -> to.Trajectory:
    """Return the straight way to the goal, at rest at both ends."""
    reduced, stated = problem.reduced, one_of("goal", problem.goals[0], JointPositions).positions
    ends = np.stack((reduced.start_positions, np.array([stated[name] for name in reduced.joint_names])))
    rest = np.zeros_like(ends)
    return to.Trajectory(reduced.joint_names, np.array((0.0, 4.0)), ends, rest, rest)
