"""Robot descriptions from Pinocchio models, instead of a URDF and its meshes."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

import coal
import numpy as np
import pinocchio as pin

from trajopt.robot.loading.pinocchio_model import joint_frame_names, link_frame, link_names
from trajopt.robot.loading.srdf import GroupElement
from trajopt.robot.loading.urdf import LinkGeometry, Urdf
from trajopt.values.arrays import readonly
from trajopt.values.errors import FrameNotFound, JointNotFound, ModelError, UnsupportedJoint, shown
from trajopt.values.placement import Placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Cylinder, Shape, Sphere, convex

_AXES = ("X", "Y", "Z")
_ONE_DEGREE_OF_FREEDOM = frozenset(
    f"JointModel{kind}"
    for kind in (
        *(kind + axis for kind in ("R", "RUB", "P") for axis in _AXES),
        *("RevoluteUnaligned", "RevoluteUnboundedUnaligned", "PrismaticUnaligned"),
    )
)
_TO_FIX = (
    "trajopt plans for arms whose base is fixed: build the model without a root joint, or fix the joint with "
    "pin.buildReducedModel"
)


def check_joints(model: pin.Model) -> None:
    """Check that every joint has one number and valid limits."""
    names = list(model.names)[1:]
    if not names:
        raise ModelError("the pinocchio model has no joint that moves")
    if not link_names(model):
        raise ModelError("the pinocchio model has no link; give each joint one with model.addBodyFrame")
    for name, joint in zip(names, list(model.joints)[1:], strict=True):
        kind = joint.shortname()
        if kind == "JointModelFreeFlyer":
            raise UnsupportedJoint(name, kind, _TO_FIX)
        if kind not in _ONE_DEGREE_OF_FREEDOM:
            raise UnsupportedJoint(name, kind)
        if joint.nq == 1:
            lower, upper = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
            if not lower <= upper:
                limits = f"{lower:g} and {upper:g}"
                raise ModelError(f"joint {shown(name)}: its position limits {limits} leave it no position")
        if not model.velocityLimit[joint.idx_v] >= 0.0:
            raise ModelError(f"joint {shown(name)}: its velocity limit is not a positive number")


def _points(owner: str, geometry: coal.ConvexBase) -> Shape:
    points = np.array([geometry.point(i) for i in range(geometry.num_points)])
    if not len(points):
        raise ModelError(f"collision geometry {shown(owner)} is a convex shape without points")
    return convex(points)


def _mesh(geometry: coal.BVHModelBase) -> Shape:
    vertices = np.array(geometry.vertices()).reshape(-1, 3)
    triangles = [geometry.tri_indices(i) for i in range(geometry.num_tris)]
    return Mesh(vertices, np.array([[corner[k] for k in range(3)] for corner in triangles]).reshape(-1, 3))


def _shape(name: str, geometry: object) -> Shape:
    """Convert a shape of Coal."""
    if isinstance(geometry, coal.ShapeBase) and geometry.getSweptSphereRadius() > 0.0:
        reason = "is swept by a sphere; require a clearance with Scene.with_clearance in its place"
        raise ModelError(f"collision geometry {shown(name)} {reason}")
    match geometry:
        case coal.Box():
            x, y, z = 2.0 * np.array(geometry.halfSide)
            return Box(float(x), float(y), float(z))
        case coal.Sphere():
            return Sphere(geometry.radius)
        case coal.Cylinder():
            return Cylinder(geometry.radius, 2.0 * geometry.halfLength)
        case coal.Capsule():
            return Capsule(geometry.radius, 2.0 * geometry.halfLength)
        case coal.Cone():
            return Cone(geometry.radius, 2.0 * geometry.halfLength)
        case coal.ConvexBase():
            return _points(name, geometry)
        case coal.BVHModelBase():
            return _mesh(geometry)
        case _:
            kind = type(geometry).__name__
            raise ModelError(
                f"collision geometry {shown(name)} is a {kind}, which no link can have; "
                "use a box, sphere, cylinder, capsule, cone, convex hull or triangle mesh"
            )


def _link_of(model: pin.Model, item: pin.GeometryObject) -> str:
    """Return the link of a geometry object: its own, or one on the same joint."""
    if item.parentJoint >= model.njoints:
        raise ModelError(f"collision geometry {shown(item.name)} belongs to another model: no such joint")
    if item.parentFrame < model.nframes:
        frame = model.frames[item.parentFrame]
        if frame.type == pin.FrameType.BODY and frame.parentJoint == item.parentJoint:
            return str(frame.name)
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY and frame.parentJoint == item.parentJoint:
            return str(frame.name)
    raise ModelError(
        f"collision geometry {shown(item.name)} moves with joint {shown(model.names[item.parentJoint])}, "
        "which carries no link; give it one with model.addBodyFrame"
    )


def _collision(model: pin.Model, item: pin.GeometryObject) -> LinkGeometry:
    link = _link_of(model, item)
    at = model.frames[link_frame(model, link)].placement.inverse() * item.placement
    where = Placement(readonly(at.rotation.copy()), readonly(at.translation.copy()))
    return LinkGeometry(link, where, _shape(item.name, item.geometry))


def described(model: pin.Model, collisions: pin.GeometryModel | None, name: str | None) -> Urdf:
    """Return a model as the content of a URDF: its name and collision geometry only."""
    objects = () if collisions is None else tuple(collisions.geometryObjects)
    title = name or str(model.name) or "robot"
    elements = tuple(_collision(model, item) for item in objects)
    from xml.sax.saxutils import quoteattr  # with it comes all of HTTP

    return Urdf(Path(), f"<robot name={quoteattr(title)}/>", title, elements, (), {})


def group_elements(
    model: pin.Model, groups: Mapping[str, Sequence[str]] | None
) -> Mapping[str, GroupElement]:
    """Return groups given as joint names, or as a pair of links: base and tip of a chain."""
    elements: dict[str, GroupElement] = {}
    links, joints = frozenset(link_names(model)), frozenset(joint_frame_names(model))
    for name, members in (groups or {}).items():
        entries = () if isinstance(members, str) else tuple(members)
        if not entries:
            reason = "needs the names of its joints, or a pair (base link, tip link)"
            raise ModelError(f"group {shown(name)} {reason}; it is {shown(cast(object, members))}")
        chain = len(entries) == 2 and links.issuperset(entries)
        if chain and joints.issuperset(entries):
            raise ModelError(f"group {shown(name)}: {entries} are names both of joints and of links")
        half = len(entries) == 2 and not chain and links.intersection(entries) - joints
        for entry in () if chain else entries:
            if half and entry not in links:
                raise FrameNotFound(f"link (in group {name!r})", entry, links)
            if not half and entry not in joints:
                raise JointNotFound(f"joint (in group {name!r})", entry, joints)
        elements[name] = (
            GroupElement(name, ((entries[0], entries[1]),), (), (), ())
            if chain
            else GroupElement(name, (), entries, (), ())
        )
    return elements
