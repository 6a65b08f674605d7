"""A loose object: only contact and friction hold it."""

import numpy as np

from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.scene_object import SceneObject
from trajopt.simulation.options import Friction
from trajopt.simulation.pieces import pieces, scalar_first
from trajopt.simulation.spec import SpecReport, add_piece
from trajopt.values.errors import ModelError, shown
from trajopt.values.placement import Placement
from trajopt.values.shapes.uniform_inertia import uniform_inertia

CONTACT_TIME = (0.004, 1.0)
"""Time constant [s] and damping ratio of the contacts of a loose object (MuJoCo's `solref`)."""
CONTACT_IMPEDANCE = (0.95, 0.99, 0.0005, 0.5, 2.0)
"""Stiffness of those contacts by depth (MuJoCo's `solimp`)."""
FRICTION_TO_NORMAL = 10.0
"""Ratio of friction impedance to normal impedance (MuJoCo's `impratio`): at 1, objects creep."""
NO_SLIP = 10
"""Iterations that remove the remaining creep (MuJoCo's `noslip_iterations`)."""
ROLLING = 1e-4
"""Friction against rolling [m]; MuJoCo's default."""


def add_loose(
    report: SpecReport,
    item: SceneObject,
    where: Placement,
    *,
    fingers: tuple[str, ...],
    friction: Friction,
) -> SpecReport:
    """Add an object that falls, slides and can be held to a MuJoCo model.

    It collides with everything. Its mass is spread evenly over its shapes.

    Args:
        report: The model, without the object; its specification is changed.
        item: The object.
        where: Its placement in the world.
        fingers: Links with rubber on them.
        friction: Of the object.

    Raises:
        ModelError: If its mass is not known, or it has no shape.
    """
    if item.mass <= 0.0:
        raise ModelError(f"object {shown(item.name)} has no mass to simulate it with: add(..., mass=...)")
    if not item.parts:
        raise ModelError(f"object {shown(item.name)} has no shape to take hold of")
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
        parts, note = pieces(shape, moving=True)
        notes += [f"{item.name}: {note}"] * bool(note)
        for part, piece in enumerate(parts):
            name = f"{item.name}/{count}#{part}"
            geom = add_piece(spec, body, name, piece, placed)
            geom.mass = item.mass * volumes[count] / sum(volumes) / len(parts)
            owners[name] = item.name
            for other, owner in others.items():
                coefficient = friction.pads if owner in fingers else friction.others
                pair = spec.add_pair(geomname1=name, geomname2=other)
                pair.condim = 4
                pair.friction = np.array((coefficient, coefficient, friction.torsional, ROLLING, ROLLING))
                pair.solref, pair.solimp = np.array(CONTACT_TIME), np.array(CONTACT_IMPEDANCE)
                # The shortest time constant that a step allows: MuJoCo leaves out the centripetal part of
                # the acceleration at a contact, so that objects creep outward in a turning hand, at
                # that acceleration times half this.
                pair.solreffriction = np.array((2.0 * spec.option.timestep, 1.0))
    return SpecReport(spec, owners, tuple(notes), report.changing)
