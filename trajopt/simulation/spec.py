"""The MuJoCo model of a reduced model."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.robot.joints import configuration
from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.reduced import ReducedModel, loaded_model
from trajopt.scene.scene_object import SceneObject, uniform_inertia
from trajopt.simulation.dynamic_scene import DynamicScene, MujocoGeom, add_specks, mujoco_geoms
from trajopt.simulation.rollout import Friction
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import ModelError, shown
from trajopt.values.placement import Placement, scalar_first

STIFF = (0.004, 1.0)
"""Time constant [s] and damping ratio of the constraint of a mimicking joint."""
RIGID = (0.9999, 0.9999, 0.001, 0.5, 2.0)
"""Impedance of that constraint (`solimp` of MuJoCo), the largest possible: the default yields by a twentieth,
and a light link between heavy ones becomes unstable.
"""
GEARS = 1e-3
"""Least share of its own link, or else of an armature, in the inertia that a mimicking joint moves at the
start: without it the constraint of a massless link between heavy ones is unstable.
"""
SMALLEST_MASS = 1e-12
"""Mass of moving bodies without mass, which MuJoCo rejects [kg]."""
SMALLEST_INERTIA = 1e-14
"""Least principal moment of inertia [kg m^2]."""
ROUNDING = 1e-9
"""Share of a moment corrected without a note: rounding of the digits in the file."""


@dataclass(frozen=True, eq=False)
class PrincipalInertia:
    """Inertia about the principal axes.

    Attributes:
        placement: Of the principal axes in the frame of the body, with the origin in the centre of mass.
        moments: Principal moments, shape (3,) [kg m^2].
        change: Largest change of a moment relative to the robot file [kg m^2].
    """

    mass: float
    placement: Placement
    moments: Floats
    change: float


@dataclass(frozen=True, eq=False)
class SpecReport:
    """A MuJoCo model, and its differences from the reduced model.

    Attributes:
        owners: Name of a collision geometry -> its link or object.
        notes: A sentence for each shape, inertia or motion that MuJoCo does not represent exactly.
    """

    spec: mujoco.MjSpec
    owners: dict[str, str]
    notes: tuple[str, ...]
    changing: DynamicScene


def describe(reduced: ReducedModel) -> SpecReport:
    """Build the MuJoCo model of a reduced model; see `trajopt.simulation.build_spec`."""
    spec = mujoco.MjSpec()
    spec.modelname = reduced.scene.robot.name
    spec.compiler.degree = False  # MuJoCo's default reads joint ranges as degrees.
    spec.compiler.autolimits = False
    spec.option.gravity = np.array(reduced.model.gravity.linear)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    bodies, notes = add_joints(spec, reduced)
    _add_motors(spec, reduced)
    changing = DynamicScene.of(reduced)
    if changing.timings:
        add_specks(spec)
    frames, whole = changing.add_frames(spec, bodies), changing.whole
    names: list[list[str]] = []
    owners: dict[str, str] = {}
    for body in whole.bodies:
        parts, note = mujoco_geoms(body.shape, moving=body.joint != 0)
        own = [body.name if len(parts) == 1 else f"{body.name}#{k}" for k in range(len(parts))]
        for name, piece in zip(own, parts, strict=True):
            add_geom(spec, frames[body.joint], name, piece, changing.placement(body))
            owners[name] = body.owner
        if note:
            notes.append(f"{body.name}: {note}")
        names.append(own)
    for i, j in zip(whole.pairs.first.tolist(), whole.pairs.second.tolist(), strict=True):
        for a in names[int(i)]:
            for b in names[int(j)]:
                spec.add_pair(geomname1=a, geomname2=b)
    return SpecReport(spec, owners, (*notes, *changing.notes), changing)


def add_joints(spec: mujoco.MjSpec, reduced: ReducedModel) -> tuple[list[mujoco.MjsBody], list[str]]:
    """Add a body for every joint, without shapes; return them by Pinocchio's index, and notes."""
    model, loaded = reduced.model, loaded_model(reduced)
    robot = reduced.scene.robot
    bodies: list[mujoco.MjsBody] = [spec.worldbody]
    notes: list[str] = []
    names = tuple(model.names[1:])
    limits = robot.limits.take(robot.index(names))
    # A joint may start outside its limits. It is held there, so its range includes the start.
    start = reduced.mimic_matrix @ reduced.start_positions + reduced.mimic_offset
    lower, upper = np.minimum(limits.lower, start), np.maximum(limits.upper, start)
    data, q = model.createData(), configuration(model, start)
    moved = np.diag(pin.crba(model, data, q))
    for index, name in enumerate(names, start=1):
        where = model.jointPlacements[index]
        placed = Placement(np.array(where.rotation), np.array(where.translation))
        body = bodies[int(model.parents[index])].add_body(name=_link_of(model, index))
        body.pos, body.quat = placed.translation, scalar_first(placed)
        inertia = principal_inertia(loaded.inertias[index])
        body.explicitinertial = True
        body.mass, body.inertia = inertia.mass, inertia.moments
        body.ipos, body.iquat = inertia.placement.translation, scalar_first(inertia.placement)
        if inertia.change > 0.0:
            notes.append(
                f"{body.name}: the stated inertia is impossible for a rigid body; "
                f"a principal moment was changed by {inertia.change:.1e} kg m^2"
            )
        subspace = _joint_subspace(model, index)
        slides = np.abs(subspace[:3]).max() > np.abs(subspace[3:]).max()
        kind = mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE
        joint = body.add_joint(name=name, type=kind, axis=subspace[:3] if slides else subspace[3:])
        column = model.joints[index].idx_v
        armature = float(model.armature[column])
        if name not in reduced.joint_names:
            needed = GEARS * float(moved[column]) - _inertia_along(model.inertias[index], subspace)
            if needed > armature:
                armature = needed
                notes.append(f"{body.name}: too light for the constraint of {name}, which has an armature")
        joint.armature = armature
        _limit(joint, float(lower[index - 1]), float(upper[index - 1]))
        bodies.append(body)
    return bodies, notes


def principal_inertia(inertia: pin.Inertia) -> PrincipalInertia:
    """Diagonalise an inertia in the frame of the body, and correct moments impossible for a rigid body.

    A principal moment is at most the sum of the other two; MuJoCo rejects others, which occur in robot files.
    The nearest possible moments replace them (least squares).
    """
    moments, axes = np.linalg.eigh(np.array(inertia.inertia))
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    nearest = np.maximum(moments, SMALLEST_INERTIA)
    excess = nearest[2] - nearest[0] - nearest[1]
    if excess > 0.0:
        nearest = nearest + np.array((1.0, 1.0, -1.0)) * excess / 3.0
    # The inequality is tested in floating point; stay inside by a few units in the last place.
    nearest[:2] *= 1.0 + 4.0 * np.finfo(np.float64).eps
    change = float(np.abs(nearest - moments).max())
    return PrincipalInertia(
        max(float(inertia.mass), SMALLEST_MASS),
        Placement(readonly(axes), readonly(np.array(inertia.lever))),
        readonly(nearest),
        change if change > ROUNDING * abs(float(moments[2])) + 2.0 * SMALLEST_INERTIA else 0.0,
    )


def add_geom(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, name: str, piece: MujocoGeom, where: Placement
) -> mujoco.MjsGeom:
    """Fix a geometry to a body, placed in its frame, without mass and by default without collisions."""
    placed = where * piece.placement
    geom = body.add_geom(name=name, type=piece.kind, size=piece.size)
    geom.pos, geom.quat = placed.translation, scalar_first(placed)
    geom.mass, geom.contype, geom.conaffinity = 0.0, 0, 0
    if piece.kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        mesh.uservert, mesh.userface = piece.vertices.ravel(), piece.faces.ravel()
        geom.meshname = name
    return geom


def _link_of(model: pin.Model, joint: int) -> str:
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY and frame.parentJoint == joint:
            return str(frame.name)
    return f"{model.names[joint]} (no link)"


def _joint_subspace(model: pin.Model, index: int) -> Floats:
    joint = model.joints[index]
    data = joint.createData()
    joint.calc(data, pin.neutral(model))
    return np.array(data.S).ravel()


def _inertia_along(inertia: pin.Inertia, subspace: Floats) -> float:
    linear, axis = subspace[:3], subspace[3:]
    off = linear + np.cross(axis, inertia.lever)
    return float(axis @ inertia.inertia @ axis + inertia.mass * off @ off)


def _limit(joint: mujoco.MjsJoint, lower: float, upper: float) -> None:
    limited = np.isfinite((lower, upper)).any() and lower < upper
    joint.limited = mujoco.mjtLimited(int(limited))
    if limited:
        joint.range = np.clip((lower, upper), -1e6, 1e6)


def _add_motors(spec: mujoco.MjSpec, reduced: ReducedModel) -> None:
    for name, effort in zip(reduced.joint_names, reduced.limits.effort, strict=True):
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.forcelimited = mujoco.mjtLimited(int(np.isfinite(effort)))
        if np.isfinite(effort):
            motor.forcerange = np.array((-effort, effort))
    for row, name in enumerate(tuple(reduced.model.names[1:])):
        if name in reduced.joint_names:
            continue
        source = int(np.flatnonzero(reduced.mimic_matrix[row])[0]) if reduced.mimic_matrix[row].any() else 0
        follow = reduced.mimic_matrix[row, source], reduced.mimic_offset[row]
        couple(spec, name, reduced.joint_names[source], *map(float, follow))


def couple(spec: mujoco.MjSpec, follower: str, leader: str, factor: float, offset: float) -> None:
    rule = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1=follower)
    rule.name2 = leader
    rule.objtype = mujoco.mjtObj.mjOBJ_JOINT
    rule.data[:2] = offset, factor
    rule.solref, rule.solimp = np.array(STIFF), np.array(RIGID)


CONTACT_TIME = (0.004, 1.0)
"""Time constant [s] and damping ratio of the contacts of a loose object (`solref` of MuJoCo)."""
CONTACT_IMPEDANCE = (0.95, 0.99, 0.0005, 0.5, 2.0)
"""Stiffness of these contacts by depth (`solimp` of MuJoCo)."""
FRICTION_TO_NORMAL = 10.0
"""Ratio of friction impedance to normal impedance (`impratio` of MuJoCo); with 1, objects creep."""
NO_SLIP = 10
"""Iterations that remove the remaining creep (`noslip_iterations` of MuJoCo)."""
ROLLING = 1e-4
"""Rolling friction [m]; the default of MuJoCo."""


def add_loose(
    report: SpecReport,
    item: SceneObject,
    where: Placement,
    *,
    fingers: tuple[str, ...],
    friction: Friction,
) -> SpecReport:
    """Add an object to a MuJoCo model moved by contact and friction only, placed in the world.

    It collides with everything. Its mass is distributed uniformly over its shapes.
    """
    if item.mass <= 0.0:
        raise ModelError(
            f"object {shown(item.name)} has no mass: state it by Scene.add(mass=), or by `masses` in a job"
        )
    if not item.parts:
        raise ModelError(f"object {shown(item.name)} has no shape; add one to grasp it")
    spec = report.spec
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = FRICTION_TO_NORMAL
    spec.option.noslip_iterations = NO_SLIP
    body = spec.worldbody.add_body(name=item.name, pos=where.translation, quat=scalar_first(where))
    body.add_freejoint(name=item.name)
    others = dict(report.owners)
    volumes = [uniform_inertia(shape).mass for shape, _ in item.parts]
    owners, notes = dict(others), list(report.notes)
    for count, (shape, placed) in enumerate(item.parts):
        parts, note = mujoco_geoms(shape, moving=True)
        notes += [f"{item.name}: {note}"] * bool(note)
        for part, piece in enumerate(parts):
            name = f"{item.name}/{count}#{part}"
            geom = add_geom(spec, body, name, piece, placed)
            geom.mass = item.mass * volumes[count] / sum(volumes) / len(parts)
            owners[name] = item.name
            for other, owner in others.items():
                coefficient = friction.pads if owner in fingers else friction.others
                pair = spec.add_pair(geomname1=name, geomname2=other)
                pair.condim = 4
                pair.friction = np.array((coefficient, coefficient, friction.torsional, ROLLING, ROLLING))
                pair.solref, pair.solimp = np.array(CONTACT_TIME), np.array(CONTACT_IMPEDANCE)
                # The shortest time constant that a step allows: MuJoCo omits the centripetal acceleration at
                # a contact, so that objects creep outward in a turning hand, at that acceleration times half
                # of this time.
                pair.solreffriction = np.array((2.0 * spec.option.timestep, 1.0))
    return SpecReport(spec, owners, tuple(notes), report.changing)
