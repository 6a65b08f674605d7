"""Inertia of a body in the form MuJoCo takes, and what had to be changed for it."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.arrays import Floats, readonly
from trajopt.model.placement import Placement

SMALLEST_MASS = 1e-12
"""MuJoCo refuses moving bodies without mass; they get this much [kg]."""
SMALLEST_INERTIA = 1e-14
"""The same for principal moments of inertia [kg m^2]."""
ROUNDING = 1e-9
"""Share of a moment that is corrected without a word: the rounding of the file's digits."""


@dataclass(frozen=True, eq=False)
class PrincipalInertia:
    """Inertia about the principal axes.

    Attributes:
        mass: Mass [kg].
        placement: Of the principal axes, origin in the centre of mass, in the body's frame.
        moments: Principal moments, shape (3,) [kg m^2].
        change: Largest change of a moment against what the robot's file states [kg m^2].
    """

    mass: float
    placement: Placement
    moments: Floats
    change: float


def principal_inertia(inertia: pin.Inertia) -> PrincipalInertia:
    """Diagonalise an inertia; change it as little as possible where no rigid body could have it.

    No body has a principal moment larger than the sum of the other two, and MuJoCo refuses such
    numbers. They occur in robots' files; the nearest moments (least squares) take their place.

    Args:
        inertia: Pinocchio's inertia in the body's frame.
    """
    moments, axes = np.linalg.eigh(np.array(inertia.inertia))
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    nearest = np.maximum(moments, SMALLEST_INERTIA)
    excess = nearest[2] - nearest[0] - nearest[1]
    if excess > 0.0:
        nearest = nearest + np.array((1.0, 1.0, -1.0)) * excess / 3.0
    # The inequality is tested in floating point: stay inside it by a few units in the last place.
    nearest[:2] *= 1.0 + 4.0 * np.finfo(np.float64).eps
    change = float(np.abs(nearest - moments).max())
    return PrincipalInertia(
        max(float(inertia.mass), SMALLEST_MASS),
        Placement(readonly(axes), readonly(np.array(inertia.lever))),
        readonly(nearest),
        change if change > ROUNDING * abs(float(moments[2])) + 2.0 * SMALLEST_INERTIA else 0.0,
    )
