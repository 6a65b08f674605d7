"""Attached objects with mass, as loads of the joints that carry them."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Value


@dataclass(frozen=True, eq=False)
class Payload(Value):
    """A mass that a joint carries.

    Attributes:
        name: The object's id.
        mass: Its mass [kg].
        joint: Joint of the reduced model that carries it.
        point: Its centre of mass, in the joint's frame, shape (3,) [m].
        inertia: Its moments about that, along the joint's axes, shape (3, 3) [kg m^2].
    """

    name: str
    mass: float
    joint: int
    point: Floats
    inertia: Floats


def payloads(reduced: ReducedModel) -> tuple[Payload, ...]:
    """Return the objects with mass that the reduced model's joints carry."""
    return reduced.derived(_payloads)


def _payloads(reduced: ReducedModel) -> tuple[Payload, ...]:
    found: list[Payload] = []
    for item in reduced.scene.objects.values():
        anchor = reduced.anchors.get(item.name)
        if item.mass > 0.0 and anchor is not None and anchor.joint > 0:
            where = pin.SE3(anchor.placement.rotation, anchor.placement.translation)
            there = where.act(item.inertia)
            found.append(Payload(item.name, item.mass, anchor.joint, there.lever, there.inertia))
    return tuple(found)


def loaded_model(reduced: ReducedModel) -> pin.Model:
    """Return the pinocchio model of a reduced model with its payloads; the same model without any."""
    carried = payloads(reduced)
    if not carried:
        return reduced.model
    model = reduced.model.copy()
    for item in carried:
        model.inertias[item.joint] += pin.Inertia(item.mass, np.array(item.point), np.array(item.inertia))
    return model
