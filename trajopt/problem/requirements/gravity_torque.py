"""Joints can hold the arm still."""

from dataclasses import dataclass

from trajopt.problem.requirements.requirement import PERCENT, Relaxation, Requirement
from trajopt.values.arrays import positive
from trajopt.values.errors import ProblemError

SHARE = 0.9
"""Default share of an effort limit that gravity may take. The rest moves the arm: with a
share r of a limit left, the joint accelerates r times as much as without any weight, and the path takes
1 / sqrt(r) times as long: three times as long with a tenth, ten times as long with a hundredth."""


@dataclass(frozen=True, eq=False)
class GravityTorque(Requirement):
    """The torque that holds the arm still stays within a share of each effort limit.

    No timing helps in a posture whose weight a joint cannot hold. Carried masses count where the scene
    states them. Joints without an effort limit may carry anything.

    Made by `gravity_torque`, whose arguments are its fields.
    """

    share: float

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        """The share."""
        return (
            Relaxation.of(
                self,
                "share",
                "share of the effort limits that gravity may take",
                largest=1.0 - self.share,
                unit=PERCENT,
            ),
        )

    def __str__(self) -> str:
        """Say the share in percent."""
        return f"gravity takes at most {100.0 * self.share:.3g}% of the effort limits"


def gravity_torque(share: float = SHARE) -> GravityTorque:
    """Require that the joints can hold the arm and what it carries.

    Args:
        share: Share of each joint's effort limit that its weight may take, in (0, 1].

    Raises:
        ProblemError: If the share is outside (0, 1].
    """
    if positive("share", share) > 1.0:
        raise ProblemError(f"gravity_torque: share is a part in (0, 1] of the effort limits, is {share:g}")
    return GravityTorque(float(share))
