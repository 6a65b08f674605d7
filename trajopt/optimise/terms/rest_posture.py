"""Distance of joints from a preferred posture: a cost."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trajopt.problem.motion import Motion
from trajopt.problem.residual import WHOLE, Cost, Window
from trajopt.values.arrays import Loss, Rows, number
from trajopt.values.errors import JointNotFound, ProblemError
from trajopt.values.errors.arguments import checked

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics


@checked
@dataclass(frozen=True, eq=False)
class RestPosture:
    """Positions of some of the group's joints less those at rest, one component each [rad | m].

    Attributes:
        positions: Joint -> position at rest [rad | m].
    """

    positions: Mapping[str, float]
    name = "rest posture"

    def linearise(self, motion: Motion) -> Rows:
        """Return the differences; exact, for they are linear.

        Raises:
            JointNotFound: If a joint is not of the group.
        """
        names = motion.query.reduced.joint_names
        for joint in self.positions:
            if joint not in names:
                raise JointNotFound("joint of the group", joint, names)
        places = [names.index(joint) for joint in self.positions]
        value = motion.positions[:, places] - np.array(list(self.positions.values()))
        return motion.rows_of_all(value, np.tile(np.eye(len(names))[places], (len(value), 1, 1)))

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        """Return the components as an expression; see `Symbolic`."""
        import casadi as ca

        names = kinematics.reduced.joint_names
        places = [names.index(joint) for joint in self.positions]
        return kinematics.q[places] - ca.SX(list(self.positions.values()))


@checked
def rest_posture(
    positions: Mapping[str, float],
    *,
    weight: float = 1e-3,
    loss: Loss = Loss.SQUARED,
    window: Window = WHOLE,
) -> Cost:
    """Pull joints towards a posture: a `Cost` that counts at every sample of the path.

    Args:
        positions: Joint of the group -> position [rad | m]; at least one.
        weight: Of a squared radian or metre; the default is small compared with the default costs.
        loss: Squared by default.
        window: Where it counts.

    Raises:
        ProblemError: If no joint is named.
        ShapeError: If a position is not finite.
    """
    if not positions:
        raise ProblemError("rest_posture: name at least one joint")
    values = {joint: number(f"position of {joint}", value) for joint, value in positions.items()}
    return Cost(RestPosture(values), weight, loss, window)
