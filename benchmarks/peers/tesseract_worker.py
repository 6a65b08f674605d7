"""Tesseract's TrajOpt (sco) with OSQP and continuous collision checks, from the straight line."""

import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from tesseract_robotics import tesseract_command_language as language
from tesseract_robotics import tesseract_motion_planners_trajopt as trajopt
from tesseract_robotics.tesseract_collision import (
    CollisionEvaluatorType,
    ContactRequest,
    ContactResultMap,
    ContactTestType,
)
from tesseract_robotics.tesseract_common import (
    AllowedCollisionMatrix,
    FilesystemPath,
    GeneralResourceLocator,
    Isometry3d,
    ManipulatorInfo,
)
from tesseract_robotics.tesseract_environment import (
    AddLinkCommand,
    Environment,
    ModifyAllowedCollisionsCommand,
    ModifyAllowedCollisionsType,
)
from tesseract_robotics.tesseract_geometry import Box, Cylinder, Geometry, Sphere
from tesseract_robotics.tesseract_motion_planners import PlannerRequest
from tesseract_robotics.tesseract_scene_graph import Collision, Joint, JointType, Link
from tesseract_robotics.trajopt_ifopt import TrajOptCollisionConfig
from toppra_timing import time_path
from worker import Planned, cpu, work

NAMESPACE = "TrajOptMotionPlannerTask"
PROFILE = "DEFAULT"
STEPS = 20
LONGEST_SEGMENT = 0.1
TESTED = 0.02
CONTACTS = """contact_manager_plugins:
  search_libraries: [tesseract_collision_bullet_factories]
  discrete_plugins:
    default: BulletDiscreteBVHManager
    plugins: {BulletDiscreteBVHManager: {class: BulletDiscreteBVHManagerFactory}}
  continuous_plugins:
    default: BulletCastBVHManager
    plugins: {BulletCastBVHManager: {class: BulletCastBVHManagerFactory}}
"""


class Tesseract:
    def __init__(self, robot: dict[str, Any], _: str) -> None:
        self.robot = robot
        self.folder = Path(robot["folder"])
        plugins = self.folder / "tesseract_contacts.yaml"
        plugins.write_text(CONTACTS)
        semantics = ET.parse(self.folder / "robot.srdf")
        ET.SubElement(semantics.getroot(), "contact_managers_plugin_config", filename=f"file://{plugins}")
        semantics.write(self.folder / "tesseract.srdf")
        self.locator = GeneralResourceLocator()
        self.profiles = _profiles(robot["time_limit"])

    def prepare(self, problem: dict[str, Any]) -> Environment:
        environment = Environment()
        files = (FilesystemPath(str(self.folder / name)) for name in ("robot.urdf", "tesseract.srdf"))
        if not environment.init(*files, self.locator):
            raise RuntimeError("the environment was refused")
        (base,) = self.robot["static_links"]
        allowed = AllowedCollisionMatrix()
        for item in problem["objects"]:
            if not environment.applyCommand(_added(item, base)):
                raise RuntimeError(f"object {item['name']} was refused")
            allowed.addAllowedCollision(base, item["name"], "Never")
        if problem["objects"]:
            command = ModifyAllowedCollisionsCommand(allowed, ModifyAllowedCollisionsType.ADD)
            environment.applyCommand(command)
        environment.setState(self.robot["joints"], np.array(problem["start"]))
        return environment

    def plan(self, scene: Environment, problem: dict[str, Any]) -> Planned:
        path, path_cpu = cpu(self._path, scene, problem)
        if isinstance(path, str):
            return Planned(False, path_cpu=path_cpu, message=path)
        motion, timing_cpu = cpu(time_path, self.robot, path, self._checker(scene), TESTED)
        return Planned(True, path.tolist(), motion, path_cpu, timing_cpu)

    def _checker(self, scene: Environment) -> Callable[[np.ndarray], bool]:
        """Return a function that decides whether a configuration is free."""
        group = scene.getJointGroup(self.robot["group"])
        manager = scene.getDiscreteContactManager()
        manager.setActiveCollisionObjects(group.getActiveLinkNames())
        manager.setDefaultCollisionMargin(0.0)

        def free(q: np.ndarray) -> bool:
            manager.setCollisionObjectsTransform(group.calcFwdKin(q))
            found = ContactResultMap()
            manager.contactTest(found, ContactRequest(ContactTestType.FIRST))
            return found.empty()

        return free

    def _path(self, scene: Environment, problem: dict[str, Any]) -> np.ndarray | str:
        request = PlannerRequest()
        request.env, request.profiles = scene, self.profiles
        request.instructions = self._program(np.linspace(problem["start"], problem["goal"], STEPS + 1))
        response = trajopt.TrajOptMotionPlanner(NAMESPACE).solve(request)
        if not response.successful:
            return str(response.message)
        return np.array([_positions(item) for item in response.results.getInstructions()])

    def _program(self, seed: np.ndarray) -> language.CompositeInstruction:
        """Return the seed as a program of which the ends are fixed."""
        program = language.CompositeInstruction(PROFILE)
        manipulator = ManipulatorInfo()
        manipulator.manipulator = self.robot["group"]
        program.setManipulatorInfo(manipulator)
        for place, positions in enumerate(seed):
            fixed = place in (0, len(seed) - 1)
            waypoint = language.JointWaypoint(self.robot["joints"], positions, fixed)
            move = language.MoveInstruction(
                language.JointWaypointPoly_wrap_JointWaypoint(waypoint),
                language.MoveInstructionType_FREESPACE,
                PROFILE,
            )
            program.appendMoveInstruction(language.MoveInstructionPoly_wrap_MoveInstruction(move))
        return program


def _positions(instruction: Any) -> np.ndarray:
    waypoint = language.InstructionPoly_as_MoveInstructionPoly(instruction).getWaypoint()
    if waypoint.isStateWaypoint():
        return language.WaypointPoly_as_StateWaypointPoly(waypoint).getPosition()
    return language.WaypointPoly_as_JointWaypointPoly(waypoint).getPosition()


def _profiles(time_limit: float) -> language.ProfileDictionary:
    """Return the settings of Tesseract's car seat example."""
    composite = trajopt.TrajOptDefaultCompositeProfile()
    composite.collision_constraint_config = _collision(margin=0.0, coefficient=10.0)
    composite.collision_cost_config = _collision(margin=0.005, coefficient=50.0)
    composite.smooth_velocities = True
    composite.smooth_accelerations = False
    composite.smooth_jerks = False
    solver = trajopt.TrajOptOSQPSolverProfile()
    solver.opt_params.max_iter = 200
    solver.opt_params.min_approx_improve = 1e-3
    solver.opt_params.min_trust_box_size = 1e-3
    solver.opt_params.max_time = time_limit
    move = trajopt.TrajOptDefaultMoveProfile()
    move.joint_cost_config.enabled = False
    move.joint_constraint_config.enabled = True
    profiles = language.ProfileDictionary()
    trajopt.ProfileDictionary_addTrajOptCompositeProfile(profiles, NAMESPACE, PROFILE, composite)
    trajopt.ProfileDictionary_addTrajOptMoveProfile(profiles, NAMESPACE, PROFILE, move)
    trajopt.ProfileDictionary_addTrajOptSolverProfile(profiles, NAMESPACE, PROFILE, solver)
    return profiles


def _collision(*, margin: float, coefficient: float) -> TrajOptCollisionConfig:
    config = TrajOptCollisionConfig(margin, coefficient)
    config.collision_check_config.type = CollisionEvaluatorType.LVS_CONTINUOUS
    config.collision_check_config.longest_valid_segment_length = LONGEST_SEGMENT
    config.collision_margin_buffer = 0.01
    return config


def _added(item: dict[str, Any], base: str) -> AddLinkCommand:
    """Return the command that adds an object, fixed to the base, which stands in the world's origin."""
    collision = Collision()
    collision.geometry = _geometry(item)
    link = Link(item["name"])
    link.addCollision(collision)
    joint = Joint(f"{item['name']}_joint")
    joint.parent_link_name, joint.child_link_name = base, item["name"]
    joint.type = JointType.FIXED
    joint.parent_to_joint_origin_transform = Isometry3d(np.asfortranarray(item["placement"]))
    return AddLinkCommand(link, joint)


def _geometry(item: dict[str, Any]) -> Geometry:
    match item["kind"]:
        case "box":
            return Box(*item["size"])
        case "cylinder":
            return Cylinder(*item["size"])
        case _:
            return Sphere(*item["size"])


work(Tesseract)
