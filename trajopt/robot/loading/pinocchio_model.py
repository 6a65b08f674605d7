"""Pinocchio's model: parts, pickles, descriptions, notes on its physics."""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import cast

import coal
import numpy as np
import pinocchio as pin

from trajopt.robot.joints import JointLimits, configuration, draw_positions, effort_unit
from trajopt.robot.loading.srdf import GroupElement
from trajopt.robot.loading.urdf import LinkGeometry, Urdf
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import FrameNotFound, JointNotFound, ModelError, UnsupportedJoint, listed, shown
from trajopt.values.placement import Placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Cylinder, Shape, Sphere, convex

_JOINTS = (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT)
_NO_NAME = "\x01"  # XML holds no such character, so no name does


def link_names(model: pin.Model) -> tuple[str, ...]:
    return tuple(frame.name for frame in model.frames if frame.type == pin.FrameType.BODY)


def joint_frame_names(model: pin.Model) -> tuple[str, ...]:
    """Return the names of all joints, fixed ones included, in the tree's order."""
    return tuple(frame.name for frame in list(model.frames)[1:] if frame.type in _JOINTS)


def fixed_joint_names(model: pin.Model) -> frozenset[str]:
    return frozenset(joint_frame_names(model)) - frozenset(model.names[1:])


def link_frame(model: pin.Model, link: str) -> int:
    """Return the frame index of a link."""
    return int(model.getFrameId(link, pin.FrameType.BODY))


def joint_above(model: pin.Model, link: str) -> str:
    """Return the name of a link's parent joint ("universe" for the root)."""
    return str(model.frames[model.frames[link_frame(model, link)].parentFrame].name)


def link_joint(model: pin.Model, link: str) -> int:
    """Return the index of the joint that moves a link; 0 without one."""
    return int(model.frames[link_frame(model, link)].parentJoint)


def chain_lengths(model: pin.Model, slides: Mapping[str, float]) -> Floats:
    """Bound the distance of joints from the first joint of their chain, shape (model.njoints,) [m].

    Args:
        slides: Joint -> how far it slides [m]; others turn.
    """
    lengths = np.zeros(model.njoints)
    for joint in range(1, model.njoints):
        before = model.parents[joint]
        if before:
            lengths[joint] = lengths[before] + np.linalg.norm(model.jointPlacements[joint].translation)
        lengths[joint] += slides.get(model.names[joint], 0.0)
    return lengths


def link_above(model: pin.Model, link: str) -> str:
    """Return the name of a link's parent link; the joint between them may be fixed."""
    joint = model.frames[model.frames[link_frame(model, link)].parentFrame]
    return str(model.frames[joint.parentFrame].name)


def distinct_links(model: pin.Model) -> pin.Model:
    """Return the model, or a copy in which no link has the name of a joint."""
    names = [frame.name for frame in model.frames]
    if len(set(names)) == len(names):
        return model
    renamed = model.copy()
    for frame in renamed.frames:
        if frame.type == pin.FrameType.BODY:
            frame.name = _NO_NAME + frame.name
    return renamed


def named_again(model: pin.Model) -> pin.Model:
    """Undo `distinct_links`; return the model."""
    for frame in model.frames:
        frame.name = frame.name.removeprefix(_NO_NAME)
    return model


ENDLESS = 1e4
"""A range of at least this to both sides states that a joint has no limits [rad | m]."""


def described_limits(model: pin.Model) -> JointLimits:
    """Read the limits of the URDF: position, velocity, effort; acceleration is NaN, jerk inf."""
    count = model.njoints - 1
    lower, upper = np.full(count, -np.inf), np.full(count, np.inf)
    for place, joint in enumerate(list(model.joints)[1:]):
        if joint.nq == 1:
            lower[place] = model.lowerPositionLimit[joint.idx_q]
            upper[place] = model.upperPositionLimit[joint.idx_q]
    endless = (lower <= -ENDLESS) & (upper >= ENDLESS)
    lower[endless], upper[endless] = -np.inf, np.inf
    effort = np.array(model.effortLimit)
    effort[effort <= 0.0] = np.inf
    return JointLimits(
        tuple(model.names[1:]),
        lower,
        upper,
        np.array(model.velocityLimit),
        np.full(count, np.nan),
        np.full(count, np.inf),
        effort,
    )


def links_of_the_world(model: pin.Model, shaped: Collection[str]) -> frozenset[str]:
    """Return the links that belong to the world: tables and floors of the robot's description.

    They carry no joint, and no link with a shape is between them and the root, which has none itself.
    """
    frames, carriers = model.frames, set[int]()
    for frame in frames:
        if frame.type == pin.FrameType.JOINT:
            carriers.update(_links_above(model, int(frame.parentFrame)))
    found: set[str] = set()
    for place, frame in enumerate(frames):
        if frame.type == pin.FrameType.BODY and frame.parentJoint == 0 and place not in carriers:
            above = _links_above(model, int(frame.parentFrame))
            if above and not any(frames[each].name in shaped for each in above):
                found.add(str(frame.name))
    return frozenset(found)


def _links_above(model: pin.Model, place: int) -> list[int]:
    found: list[int] = []
    while place > 0:
        if model.frames[place].type == pin.FrameType.BODY:
            found.append(place)
        place = int(model.frames[place].parentFrame)
    return found


def adjacent_links(model: pin.Model, links: tuple[str, ...]) -> frozenset[frozenset[str]]:
    """Return pairs of links joined by one joint or fixed to each other, which touch by construction."""
    by_joint: dict[int, list[str]] = {}
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            by_joint.setdefault(int(frame.parentJoint), []).append(frame.name)
    parent_link = {
        frame.name: model.frames[frame.parentFrame].name
        for frame in model.frames
        if frame.type in (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT)
    }
    pairs: set[frozenset[str]] = set()
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            joint_frame = model.frames[frame.parentFrame].name
            parent = parent_link.get(joint_frame)
            if parent in links:
                pairs.add(frozenset((frame.name, parent)))
    for names in by_joint.values():
        pairs.update(frozenset((a, b)) for a in names for b in names if a < b)
    return frozenset(pairs)


ModelData = tuple[str, Mapping[str, Floats]]
"""The text of Pinocchio's archive, and the vectors with infinities, which it cannot read back."""


def model_data(model: pin.Model) -> ModelData:
    """Return a model as plain data."""
    finite, infinite = model.copy(), dict[str, Floats]()
    for name in dir(model):
        value: object = getattr(model, name)
        if isinstance(value, np.ndarray):
            vector = cast("Floats", value)
            if not np.isfinite(vector).all():
                infinite[name] = vector.copy()
                setattr(finite, name, np.zeros_like(vector))
    return finite.saveToString(), infinite


def model_of(data: ModelData) -> pin.Model:
    """Restore a model from its data."""
    text, infinite = data
    model = pin.Model()
    model.loadFromString(text)
    for name, vector in infinite.items():
        setattr(model, name, vector)
    return model


def root_placement(model: pin.Model) -> Placement:
    """Return the placement of the root link in the world."""
    at = model.frames[link_frame(model, link_names(model)[0])].placement
    return Placement(readonly(at.rotation.copy()), readonly(at.translation.copy()))


def placed_model(model: pin.Model, where: Placement) -> pin.Model:
    """Return a copy of a model displaced as a whole."""
    moved, change = model.copy(), pin.SE3(where.rotation, where.translation)
    for joint in range(1, moved.njoints):
        if moved.parents[joint] == 0:
            moved.jointPlacements[joint] = change * moved.jointPlacements[joint]
    for frame in list(moved.frames)[1:]:
        if frame.parentJoint == 0:
            frame.placement = change * frame.placement
    return moved


def link_placement(model: pin.Model, link: str, positions: Floats) -> Placement:
    """Return the placement of a link in the world at positions of all joints [rad | m]."""
    data = model.createData()
    frame = link_frame(model, link)
    pin.framesForwardKinematics(model, data, configuration(model, positions))
    found = data.oMf[frame]
    return Placement(readonly(found.rotation.copy()), readonly(found.translation.copy()))


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
            raise ModelError(f"joint {shown(name)}: its velocity limit is negative or not a number")


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


POSTURES = 64
"""Random postures: a joint that gravity overloads in 70 % of all postures is reported with a probability
of 99.9 %.
"""


def effort_notes(model: pin.Model, limits: JointLimits, exempt: Collection[str]) -> tuple[str, ...]:
    """Return notes on joints without an effort limit, and on those that gravity mostly overloads."""
    said: list[str] = []
    spoken = [(place, name) for place, name in enumerate(limits.joint_names) if name not in exempt]
    free = [name for place, name in spoken if np.isinf(limits.effort[place])]
    if free:
        said.append(f"no effort limit is stated, or 0, so torque is not limited: {listed(free)}")
    data, still = model.createData(), np.zeros(model.nv)
    torques = np.zeros((POSTURES, model.nv))
    for row, posture in zip(
        torques, draw_positions(limits, POSTURES, rng=np.random.default_rng(0)), strict=True
    ):
        row[:] = pin.rnea(model, data, configuration(model, posture), still, still)
    # The median; numpy's own imports masked arrays for it.
    needed = np.sort(np.abs(torques), axis=0)[POSTURES // 2 - 1 : POSTURES // 2 + 1].mean(axis=0)
    weak = [
        f"{name} ({limits.effort[place]:.4g} of {needed[place]:.4g} {effort_unit(model, name)})"
        for place, name in spoken
        if needed[place] > limits.effort[place]
    ]
    if weak:
        said.append(
            f"effort limits that do not hold the robot still in most postures: {listed(weak)}; "
            "Robot.with_torque_scaling raises limits of torque or turns them off"
        )
    return tuple(said)


ROUNDING = 1e-3
"""Accepted negative moment, as a share of the largest one: files have few digits."""


def inertia_notes(model: pin.Model) -> tuple[str, ...]:
    """Return a note on joints that carry a negative moment of inertia, if there are any."""
    negative: list[str] = []
    for name, inertia in zip(list(model.names)[1:], list(model.inertias)[1:], strict=True):
        moments = np.linalg.eigvalsh(np.asarray(inertia.inertia))
        if moments[0] < -ROUNDING * np.abs(moments).max():
            negative.append(name)
    if not negative:
        return ()
    return (
        f"bodies on {listed(negative)} have negative moments of inertia, which is impossible: torques of "
        "motions and the simulation are wrong; `trajopt srdf` names the links",
    )
