"""A check of motions that shares nothing with planner and judge: exact meshes, small steps, Coal by itself.

It reads URDF and SRDF with pinocchio's own readers, keeps collision meshes as triangles, and looks at
configurations so near to each other that nothing moves farther than a step between two of them.
"""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import trajopt_robots
from trajopt_robots._example_robot_data import share_folder

import trajopt as to
from trajopt.planning import Plan
from trajopt.values.arrays import Floats

SHARE = "example-robot-data/robots"
FILES = {
    "panda": (f"{SHARE}/panda_description/urdf/panda.urdf", "panda/panda.srdf"),
    "ur5": (f"{SHARE}/ur_description/urdf/ur5_robot.urdf", "ur5/ur5.srdf"),
    "xarm7": (f"{SHARE}/xarm_description/urdf/xarm7.urdf", "xarm7/xarm7.srdf"),
    "planar2": ("", "planar2/planar2.srdf"),
}
"""URDF below the folder of shared descriptions, and SRDF below that of the robots."""
POINTS = 200
"""Configurations from which the levers of the joints are taken."""


@dataclass(frozen=True, eq=False)
class Exact:
    """A robot as pinocchio reads it.

    Attributes:
        model: Its joints.
        geometry: Its collision bodies, meshes as triangles, and the pairs that its SRDF leaves.
        lever: How far the farthest point of the robot is from each joint's axis, about, shape (nv,) [m].
    """

    model: pin.Model
    geometry: pin.GeometryModel
    lever: Floats


@cache
def exact(robot: str) -> Exact:
    """Read a robot."""
    urdf, srdf = FILES[robot]
    robots = Path(trajopt_robots.__file__).parent
    share = Path(share_folder()) if urdf else robots
    file = share / urdf if urdf else robots / "planar2" / "planar2.urdf"
    model = pin.buildModelFromUrdf(str(file))
    geometry = pin.buildGeomFromUrdf(model, str(file), pin.GeometryType.COLLISION, package_dirs=[str(share)])
    geometry.addAllCollisionPairs()
    pin.removeCollisionPairs(model, geometry, str(robots / srdf), False)
    return Exact(model, geometry, _levers(model, geometry))


def _levers(model: pin.Model, geometry: pin.GeometryModel) -> Floats:
    """Return the reach of every joint, a tenth more than found at random configurations."""
    rng, data, geometry_data = np.random.default_rng(0), model.createData(), geometry.createData()
    low, high = np.maximum(model.lowerPositionLimit, -3.0), np.minimum(model.upperPositionLimit, 3.0)
    lever = np.zeros(model.nv)
    for _ in range(POINTS):
        pin.updateGeometryPlacements(model, data, geometry, geometry_data, rng.uniform(low, high))
        for joint in range(1, model.njoints):
            for place, body in zip(geometry_data.oMg, geometry.geometryObjects, strict=True):
                if joint in model.supports[body.parentJoint]:
                    body.geometry.computeLocalAABB()
                    far = place.act(body.geometry.aabb_center) - data.oMi[joint].translation
                    reach = float(np.linalg.norm(far)) + body.geometry.aabb_radius
                    at = model.idx_vs[joint]
                    lever[at] = max(lever[at], 1.0 if _slides(model, joint) else 1.1 * reach)
    return lever


def _slides(model: pin.Model, joint: int) -> bool:
    return model.joints[joint].shortname().startswith("JointModelP")


def first_contact(robot: str, plan: Plan, *, step: float) -> str:
    """Return the first contact that a motion makes, in words; empty if it makes none.

    Args:
        robot: Name of the robot.
        plan: The motion and its problem.
        step: How far a point moves between two looks, at most [m].
    """
    at = exact(robot)
    reduced, trajectory = plan.problem.reduced, plan.trajectory
    geometry = _with_scene(at, plan.problem.scene)
    data, geometry_data = at.model.createData(), geometry.createData()
    columns = [reduced.scene.robot.joint_names.index(name) for name in list(at.model.names)[1:]]
    fine = np.linspace(0.0, trajectory.duration, 2000)
    moved = np.abs(np.diff([reduced.all_positions(q)[columns] for q in trajectory(fine)], axis=0)) @ at.lever
    far = np.concatenate(([0.0], np.cumsum(moved)))
    looks = np.interp(np.linspace(0.0, far[-1], 2 + int(far[-1] / step)), far, fine)
    for time, positions in zip(looks, trajectory(looks), strict=True):
        q = reduced.all_positions(positions)[columns]
        if pin.computeCollisions(at.model, data, geometry, geometry_data, q, True):
            for result, pair in zip(geometry_data.collisionResults, geometry.collisionPairs, strict=True):
                if result.isCollision():
                    first, second = (geometry.geometryObjects[at].name for at in (pair.first, pair.second))
                    return f"{first} touches {second} at {time:.4f} s"
    return ""


def _with_scene(at: Exact, scene: to.Scene) -> pin.GeometryModel:
    """Return the robot's bodies with the scene's things, each on the joint of the link that holds it."""
    geometry, links = at.geometry.copy(), at.geometry.ngeoms
    for name, thing in scene.objects.items():
        held = scene.holder(name)
        joint, place = 0, pin.SE3(held.placement.rotation, held.placement.translation)
        if held.link != "world":
            frame = at.model.frames[at.model.getFrameId(held.link)]
            joint, place = frame.parentJoint, frame.placement * place
        ((shape, _),) = thing.parts
        index = geometry.addGeometryObject(pin.GeometryObject(name, joint, 0, place, _coal(shape)))
        for body in range(index):
            other = geometry.geometryObjects[body]
            if other.parentJoint == joint:
                continue  # they cannot move against each other
            owner = at.model.frames[other.parentFrame].name if body < links else other.name
            if not scene.may_touch(owner, name):
                geometry.addCollisionPair(pin.CollisionPair(body, index))
    return geometry


def _coal(shape: object) -> coal.CollisionGeometry:
    match shape:
        case to.Box():
            return coal.Box(shape.x, shape.y, shape.z)
        case to.Sphere():
            return coal.Sphere(shape.radius)
        case to.Cylinder():
            return coal.Cylinder(shape.radius, shape.length)
        case to.Capsule():
            return coal.Capsule(shape.radius, shape.length)
        case _:
            raise AssertionError(f"no scenario has a {shape!r}")
