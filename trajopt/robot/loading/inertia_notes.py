"""What there is to say of inertias that no body has."""

import numpy as np
import pinocchio as pin

from trajopt.values.errors import listed

ROUNDING = 1e-3
"""Share of the largest moment by which one may be below zero: files state few digits."""


def inertia_notes(model: pin.Model) -> tuple[str, ...]:
    """Return a sentence on joints that carry a negative moment of inertia; nothing where none does."""
    negative: list[str] = []
    for name, inertia in zip(list(model.names)[1:], list(model.inertias)[1:], strict=True):
        moments = np.linalg.eigvalsh(np.asarray(inertia.inertia))
        if moments[0] < -ROUNDING * np.abs(moments).max():
            negative.append(name)
    if not negative:
        return ()
    carried = f"what {listed(negative)} {'moves' if len(negative) == 1 else 'move'}"
    return (
        f"no body has the negative moments of inertia that are stated of {carried}: torques of motions and "
        "the simulation are not those of the robot; `trajopt srdf` names the links",
    )
