"""Drake: KinematicTrajectoryOptimization with SNOPT, from the straight line."""

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import (
    Box,
    CollisionFilterDeclaration,
    Cylinder,
    GeometrySet,
    ProximityProperties,
    SceneGraph,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import MinimumDistanceLowerBoundConstraint
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.planning import KinematicTrajectoryOptimization
from pydrake.solvers import SnoptSolver, SolverOptions
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.trajectories import BsplineTrajectory
from worker import Motion, Planned, cpu, work

ORDER, CONTROL_POINTS = 4, 12
CLEARANCE, INFLUENCE, SAMPLES = 0.01, 0.05, 100
SHORTEST, LONGEST, GUESS = 0.5, 20.0, 3.0
TOLERANCE = 1e-3
PATH_POINTS = 500


@dataclass(frozen=True)
class Scene:
    diagram: Diagram
    plant: MultibodyPlant
    context: Context


class Drake:
    def __init__(self, robot: dict[str, Any], variant: str) -> None:
        self.robot, self.with_acceleration = robot, variant == "acceleration"

    def prepare(self, problem: dict[str, Any]) -> Scene:
        builder = DiagramBuilder()
        plant, graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        (model,) = Parser(plant).AddModels(str(Path(self.robot["folder"]) / "robot.urdf"))
        plant.WeldFrames(plant.world_frame(), plant.get_body(plant.GetBodyIndices(model)[0]).body_frame())
        for item in problem["objects"]:
            placement = RigidTransform(np.array(item["placement"]))
            properties = ProximityProperties()
            plant.RegisterCollisionGeometry(
                plant.world_body(), placement, _shape(item), item["name"], properties
            )
        plant.Finalize()
        self._exclude(plant, graph)
        diagram = builder.Build()
        context = diagram.CreateDefaultContext()
        return Scene(diagram, plant, plant.GetMyMutableContextFromRoot(context))

    def _exclude(self, plant: MultibodyPlant, graph: SceneGraph) -> None:
        """Leave out the pairs of links that need not keep apart; the base and the objects are welded."""
        pairs = {frozenset(pair) for pair in self.robot["checked_links"]}
        bodies = {
            plant.get_body(index).name(): GeometrySet(
                plant.GetCollisionGeometriesForBody(plant.get_body(index))
            )
            for index in plant.GetBodyIndices(plant.GetModelInstanceByName(self.robot["name"]))
        }
        for first, second in combinations(bodies, 2):
            if frozenset((first, second)) not in pairs:
                excluded = CollisionFilterDeclaration().ExcludeBetween(bodies[first], bodies[second])
                graph.collision_filter_manager().Apply(excluded)

    def plan(self, scene: Scene, problem: dict[str, Any]) -> Planned:
        (solved, trajectory, message), path_cpu = cpu(self._solve, scene, problem)
        path = trajectory.vector_values(np.linspace(0.0, trajectory.end_time(), PATH_POINTS)).T
        return Planned(solved, path.tolist(), _motion(trajectory), path_cpu, 0.0, message)

    def _solve(self, scene: Scene, problem: dict[str, Any]) -> tuple[bool, BsplineTrajectory, str]:
        start, goal = np.array(problem["start"]), np.array(problem["goal"])
        still = np.zeros(len(start))
        optimisation = KinematicTrajectoryOptimization(len(start), CONTROL_POINTS, ORDER)
        program = optimisation.get_mutable_prog()
        optimisation.AddDurationCost(1.0)
        optimisation.AddPathLengthCost(1.0)
        optimisation.AddPositionBounds(np.array(self.robot["lower"]), np.array(self.robot["upper"]))
        velocity = np.array(self.robot["velocity"])
        optimisation.AddVelocityBounds(-velocity, velocity)
        if self.with_acceleration:
            acceleration = np.array(self.robot["acceleration"])
            optimisation.AddAccelerationBounds(-acceleration, acceleration)
        optimisation.AddDurationConstraint(SHORTEST, LONGEST)
        for where, positions in ((0.0, start), (1.0, goal)):
            optimisation.AddPathPositionConstraint(positions, positions, where)
            optimisation.AddPathVelocityConstraint(still, still, where)
        apart = MinimumDistanceLowerBoundConstraint(
            scene.plant, CLEARANCE, scene.context, influence_distance_offset=INFLUENCE
        )
        for where in np.linspace(0.0, 1.0, SAMPLES):
            optimisation.AddPathPositionConstraint(apart, where)
        line = np.linspace(start, goal, CONTROL_POINTS)
        optimisation.SetInitialGuess(BsplineTrajectory(optimisation.basis(), list(line[:, :, None])))
        program.SetInitialGuess(optimisation.duration(), GUESS)
        result = SnoptSolver().Solve(program, None, self._options())
        message = f"SNOPT {result.get_solver_details().info}"
        return result.is_success(), optimisation.ReconstructTrajectory(result), message

    def _options(self) -> SolverOptions:
        options = SolverOptions()
        options.SetOption(SnoptSolver.id(), "Major iterations limit", 300)
        options.SetOption(SnoptSolver.id(), "Major optimality tolerance", TOLERANCE)
        options.SetOption(SnoptSolver.id(), "Major feasibility tolerance", TOLERANCE)
        options.SetOption(SnoptSolver.id(), "Time limit", self.robot["time_limit"])
        return options


def _shape(item: dict[str, Any]) -> Shape:
    match item["kind"]:
        case "box":
            return Box(*item["size"])
        case "cylinder":
            return Cylinder(*item["size"])
        case _:
            return Sphere(*item["size"])


def _motion(trajectory: BsplineTrajectory) -> Motion:
    """Return the spline, which is cubic between its knots, exactly."""
    times = np.unique(trajectory.basis().knots())
    positions, velocities = (
        np.array([trajectory.EvalDerivative(time, order)[:, 0] for time in times]) for order in (0, 1)
    )
    return Motion((times - times[0]).tolist(), positions.tolist(), velocities.tolist())


work(Drake)
