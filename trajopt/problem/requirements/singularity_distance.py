"""A frame keeps away from singular configurations."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from trajopt.problem.requirements.requirement import PLAIN, Relaxation, Requirement
from trajopt.values.arrays import Floats, floats, number, positive
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked

LENGTH = 0.3
"""Default length that a radian of the frame's rotation counts as [m]."""


@dataclass(frozen=True, eq=False)
class SingularityDistance(Requirement):
    """The smallest singular value of a frame's Jacobian stays above a bound.

    The Jacobian maps joint velocities to (velocity of a point of the frame [m/s], length times angular
    velocity [m/s]), 6 by n. The smallest of its min(6, n) singular values is the speed of the frame in its
    slowest direction (for n < 6: of those in which it can move at all) when the joint velocities have a
    Euclidean norm of one. With the length 0 only the point
    counts: the Jacobian is 3 by n.

    Made by `singularity_distance`, whose arguments are its fields.
    """

    frame: str
    smallest: float
    length: float
    offset: Floats

    @property
    def frames(self) -> tuple[str, ...]:
        """The frame."""
        return (self.frame,)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        """The bound."""
        return (
            Relaxation.of(
                self,
                "smallest",
                f"smallest singular value of {self.frame}",
                largest=0.99 * self.smallest,
                unit=PLAIN,
                shrinks=True,
            ),
        )

    def __str__(self) -> str:
        """Say the bound."""
        return f"smallest singular value of {self.frame} at least {self.smallest:.3g}"


@checked
def singularity_distance(
    frame: str,
    smallest: float,
    *,
    length: float = LENGTH,
    offset: ArrayLike = (0.0, 0.0, 0.0),
) -> SingularityDistance:
    """Keep a frame away from singular configurations.

    Args:
        frame: Link, tool frame or attached object.
        smallest: Smallest singular value accepted, > 0 [m/rad; m/m].
        length: Length that a radian of rotation counts as [m]; 0 where only the point's motion counts.
        offset: The point, in the frame's coordinates, shape (3,) [m].

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: If the bound is not positive, or the length is negative.
    """
    weight = number("length", length)
    if weight < 0.0:
        raise ProblemError(f"length must not be negative, is {weight:g}")
    return SingularityDistance(frame, positive("smallest", smallest), weight, floats("offset", offset, (3,)))
