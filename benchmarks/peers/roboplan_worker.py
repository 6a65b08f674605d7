"""roboplan: RRT-Connect with shortcutting in C++, on Pinocchio and Coal, and its own TOPP-RA."""

from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from roboplan import core, rrt, toppra
from worker import Motion, Planned, cpu, work

COLOUR = np.array((0.5, 0.5, 0.5, 1.0))
CONNECTION = 1.0
NODES = 10_000
SAMPLE_TIME = 0.005
BLENDS = (0.1, 0.03, 0.01)
NEARLY = 0.02


class Roboplan:
    def __init__(self, robot: dict[str, Any], variant: str) -> None:
        self.robot, self.step = robot, float(variant)
        self.folder = Path(robot["folder"])
        self.srdf = (self.folder / "robot.srdf").read_text()
        self.group = robot["group"]

    def prepare(self, problem: dict[str, Any]) -> core.Scene:
        description = core.loadUrdfSceneDescription(self.folder / "robot.urdf", [])
        scene = core.Scene("scene", description)
        scene.importSrdf(self.srdf)
        scene.importJointLimitsFromConfig(core.loadJointLimitsConfig(self.folder / "roboplan_limits.yaml"))
        for item in problem["objects"]:
            self._add(scene, item)
        names = [item["name"] for item in problem["objects"]]
        unmoved = [(link, name) for link in self.robot["static_links"] for name in names]
        scene.setCollisions([*unmoved, *combinations(names, 2)], False)
        return scene

    def _add(self, scene: core.Scene, item: dict[str, Any]) -> None:
        where = np.asfortranarray(item["placement"])
        match item["kind"]:
            case "box":
                scene.addBoxGeometry(item["name"], "universe", core.Box(*item["size"]), where, COLOUR)
            case "cylinder":
                shape = core.Cylinder(*item["size"])
                scene.addCylinderGeometry(item["name"], "universe", shape, where, COLOUR)
            case "sphere":
                shape = core.Sphere(*item["size"])
                scene.addSphereGeometry(item["name"], "universe", shape, where, COLOUR)

    def plan(self, scene: core.Scene, problem: dict[str, Any]) -> Planned:
        path, path_cpu = cpu(self._path, scene, problem)
        if isinstance(path, str):
            return Planned(False, path_cpu=path_cpu, message=path)
        motion, timing_cpu = cpu(self._motion, scene, path)
        points = [point.tolist() for point in path.positions]
        return Planned(True, points, motion, path_cpu, timing_cpu)

    def _path(self, scene: core.Scene, problem: dict[str, Any]) -> core.JointPath | str:
        options = rrt.RRTOptions(
            group_name=self.group,
            max_nodes=NODES,
            max_connection_distance=CONNECTION,
            collision_check_step_size=self.step,
            max_planning_time=self.robot["time_limit"],
            rrt_connect=True,
        )
        planner = rrt.RRT(scene, options)
        planner.setRngSeed(problem["seed"])
        ends = [
            core.JointConfiguration(self.robot["joints"], np.array(problem[key])) for key in ("start", "goal")
        ]
        try:
            path = planner.plan(*ends)
        except RuntimeError as error:
            return str(error)
        shortening = core.PathShortcuttingOptions(
            group_name=self.group, max_step_size=self.step, seed=problem["seed"]
        )
        return core.PathShortcutter(scene, shortening).shortcut(path)

    def _motion(self, scene: core.Scene, path: core.JointPath) -> Motion | None:
        """Time the path, its corners rounded more and less; keep the shortest motion inside its limits."""
        motions = [timed for timed in (self._rounded(scene, path, size) for size in BLENDS) if timed]
        if not motions:
            return None
        timed = min(motions, key=lambda motion: (self._excess(motion) > NEARLY, motion.times[-1]))
        positions, velocities = (np.array(rows).tolist() for rows in (timed.positions, timed.velocities))
        return Motion(list(timed.times), positions, velocities)

    def _rounded(
        self, scene: core.Scene, path: core.JointPath, deviation: float
    ) -> core.JointTrajectory | None:
        options = toppra.TOPPRAOptions(
            dt=SAMPLE_TIME,
            mode=toppra.SplineFittingMode.LinearBlend,
            max_adaptive_step_size=self.step,
            max_blend_deviation=deviation,
        )
        try:
            return toppra.PathParameterizerTOPPRA(scene, self.group).generate(path, options)
        except RuntimeError:
            return None

    def _excess(self, motion: core.JointTrajectory) -> float:
        """Return the share by which the accelerations that a motion states are too large."""
        return float((np.abs(motion.accelerations) / self.robot["acceleration"]).max()) - 1.0


work(Roboplan)
