"""trajopt: the whole `plan`, from the straight line to the judged motion."""

from typing import Any

from worker import Motion, Planned, cpu, work

import trajopt as to
from trajopt.files.moveit import read_request, read_scene

AFTER_THE_PATH = ("retime", "verify")


class Trajopt:
    def __init__(self, robot: dict[str, Any], _: str) -> None:
        self.robot = to.load(robot["name"])

    def prepare(self, problem: dict[str, Any]) -> to.Problem:
        return read_request(problem["request"], read_scene(problem["scene"], self.robot)).problem()

    def plan(self, scene: to.Problem, _: dict[str, Any]) -> Planned:
        result, total = cpu(to.plan, scene)
        timing = sum(result.cpu_seconds.get(stage, 0.0) for stage in AFTER_THE_PATH)
        path = None if result.path is None else result.path.knots.tolist()
        motion = None if result.trajectory is None else _motion(result.trajectory)
        return Planned(result.verified, path, motion, total - timing, timing, result.reason)


def _motion(trajectory: to.Trajectory) -> Motion:
    accelerations = trajectory.accelerations
    return Motion(
        trajectory.times.tolist(),
        trajectory.positions.tolist(),
        trajectory.velocities.tolist(),
        None if accelerations is None else accelerations.tolist(),
    )


work(Trajopt)
