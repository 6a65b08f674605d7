"""OMPL: RRT-Connect and its path simplifier, with Pinocchio and Coal behind a Python callback."""

from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from ompl import base, geometric, util
from toppra_timing import time_path
from worker import Planned, cpu, work

util.setLogLevel(util.LogLevel.LOG_NONE)


class Geometry:
    """Geometry with its broad phase, which refers to it."""

    def __init__(self, model: pin.Model, geometry: pin.GeometryModel) -> None:
        self.geometry, self.data = geometry, pin.GeometryData(geometry)
        self.manager = pin.BroadPhaseManager_DynamicAABBTreeCollisionManager(model, geometry, self.data)


class Ompl:
    def __init__(self, robot: dict[str, Any], variant: str) -> None:
        self.robot, self.step = robot, float(variant)
        self.urdf = str(Path(robot["folder"]) / "robot.urdf")
        self.model = pin.buildModelFromUrdf(self.urdf)
        self.data = self.model.createData()
        util.RNG.setSeed(1)

    def prepare(self, problem: dict[str, Any]) -> Geometry:
        geometry = pin.buildGeomFromUrdf(self.model, self.urdf, pin.COLLISION)
        links = [self.model.frames[item.parentFrame].name for item in geometry.geometryObjects]
        pairs = {frozenset(pair) for pair in self.robot["checked_links"]}
        for second, b in enumerate(links):
            for first, a in enumerate(links[:second]):
                if frozenset((a, b)) in pairs:
                    geometry.addCollisionPair(pin.CollisionPair(first, second))
        for item in problem["objects"]:
            placement = pin.SE3(np.array(item["placement"]))
            shape = pin.GeometryObject(item["name"], 0, placement, _shape(item))
            place = geometry.addGeometryObject(shape)
            for first, link in enumerate(links):
                if link not in self.robot["static_links"]:
                    geometry.addCollisionPair(pin.CollisionPair(first, place))
        return Geometry(self.model, geometry)

    def plan(self, scene: Geometry, problem: dict[str, Any]) -> Planned:
        def free(q: np.ndarray) -> bool:
            return not pin.computeCollisions(self.model, self.data, scene.manager, q, True)

        path, path_cpu = cpu(self._path, free, problem)
        if path is None:
            return Planned(False, path_cpu=path_cpu, message="no path")
        motion, timing_cpu = cpu(time_path, self.robot, path, free, self.step)
        return Planned(True, path.tolist(), motion, path_cpu, timing_cpu)

    def _path(self, free: Any, problem: dict[str, Any]) -> np.ndarray | None:
        count = len(problem["start"])
        space = base.RealVectorStateSpace(count)
        bounds = base.RealVectorBounds(count)
        for joint in range(count):
            bounds.setLow(joint, self.robot["lower"][joint])
            bounds.setHigh(joint, self.robot["upper"][joint])
        space.setBounds(bounds)
        setup = geometric.SimpleSetup(space)
        setup.setStateValidityChecker(lambda state: free(np.array([state[i] for i in range(count)])))
        information = setup.getSpaceInformation()
        information.setStateValidityCheckingResolution(self.step / space.getMaximumExtent())
        start, goal = space.allocState(), space.allocState()
        for joint in range(count):
            start[joint], goal[joint] = problem["start"][joint], problem["goal"][joint]
        setup.setStartAndGoalStates(start, goal)
        setup.setPlanner(geometric.RRTConnect(information))
        setup.solve(self.robot["time_limit"])
        if not setup.haveExactSolutionPath():
            return None
        setup.simplifySolution()
        states = setup.getSolutionPath().getStates()
        return np.array([[state[i] for i in range(count)] for state in states])


def _shape(item: dict[str, Any]) -> coal.ShapeBase:
    match item["kind"]:
        case "box":
            return coal.Box(*item["size"])
        case "cylinder":
            return coal.Cylinder(*item["size"])
        case _:
            return coal.Sphere(*item["size"])


work(Ompl)
