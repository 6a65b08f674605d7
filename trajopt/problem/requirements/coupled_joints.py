"""Joints in a linear relation to each other."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from trajopt.problem.requirements.requirement import RADIANS, Relaxation, Requirement
from trajopt.values.arrays import mapping, number, positive
from trajopt.values.errors import ProblemError


@dataclass(frozen=True, eq=False)
class CoupledJoints(Requirement):
    """A weighted sum of joint positions keeps a value, within a tolerance.

    Made by `coupled_joints`, whose arguments are its fields.
    """

    weights: Mapping[str, float]
    value: float
    tolerance: float

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints of the sum."""
        return tuple(self.weights)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        """The tolerance."""
        return (
            Relaxation.of(
                self,
                "tolerance",
                f"tolerance of {' and '.join(self.weights)}",
                largest=2.0 * np.pi,
                unit=RADIANS,
            ),
        )

    def __str__(self) -> str:
        """Say the relation as one writes a sum."""
        total = ""
        for joint, weight in self.weights.items():
            sign = ("-" if weight < 0.0 else "") if not total else (" - " if weight < 0.0 else " + ")
            total += sign + (joint if abs(weight) == 1.0 else f"{abs(weight):.4g} {joint}")
        return f"{total} = {self.value:.4g}, within {self.tolerance:.3g}"


def coupled_joints(weights: Mapping[str, float], value: float = 0.0, *, tolerance: float) -> CoupledJoints:
    """Couple joints: `coupled_joints({"left": 1, "right": -1}, tolerance=0.01)` keeps two equal.

    Args:
        weights: Joint -> its factor in the sum of positions [rad | m]; at least one that is not zero.
        value: What the sum must be.
        tolerance: Largest deviation to either side, > 0.

    Raises:
        ProblemError: If no joint has a factor, or the tolerance is not positive.
        ShapeError: If a number is not finite.
    """
    factors = {
        joint: number(f"weight of {joint}", weight)
        for joint, weight in mapping("coupled_joints: weights", weights).items()
    }
    if not any(factors.values()):
        raise ProblemError("coupled_joints: give at least one joint a factor that is not zero")
    return CoupledJoints(factors, number("value", value), positive("tolerance", tolerance))
