"""Positions of some joints."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, Ints, Value
from trajopt.errors import ProblemError
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import JointPositions, Requirement, together
from trajopt.nlp import Rows
from trajopt.terms.motion import Motion
from trajopt.terms.requirement import INSET, constrain
from trajopt.terms.residual import Constraint, Window, constraint


@dataclass(frozen=True, eq=False)
class JointPosition(Value):
    """The positions of some of the group's joints, one component each [rad | m].

    Attributes:
        joints: Their places in the group, shape (k,).
    """

    joints: Ints
    name = "joint positions"

    def linearise(self, motion: Motion) -> Rows:
        """Return the positions; exact, for they are the variables."""
        value = motion.positions[:, self.joints]
        select = np.eye(motion.positions.shape[1])[self.joints]
        return motion.rows_of_all(value, np.tile(select, (len(value), 1, 1)))


def group_places(required: JointPositions, reduced: ReducedModel) -> tuple[Ints, tuple[str, ...]]:
    """Return which of the group's joints are required, and their names.

    Raises:
        ProblemError: If a joint outside the group is required to be where it is not.
    """
    robot = reduced.scene.robot
    inside: list[str] = []
    for joint, value in required.positions.items():
        if joint in reduced.joint_names:
            inside.append(joint)
            continue
        stays = float(reduced.start[robot.index([joint])[0]])
        if not -required.below[joint] <= stays - value <= required.above[joint]:
            raise ProblemError(
                f"joint {joint!r} is required at {value:g}, but it is not in group "
                f"{reduced.group!r} and stays at {stays:g}"
            )
    places = np.array([reduced.joint_names.index(joint) for joint in inside], dtype=np.int64)
    return places, tuple(inside)


def fixed_positions(required: Sequence[Requirement], reduced: ReducedModel) -> Floats | None:
    """Return the group's positions, shape (n,), if joint positions are all that is required and fix all.

    Tolerances are not looked at; a joint that several fix is in the middle of what they share.

    Raises:
        ProblemError: If a joint outside the group is required to be where it is not.
    """
    positions = np.full(len(reduced.joint_names), np.nan)
    for item in together(required):
        if not isinstance(item, JointPositions):
            return None
        places, names = group_places(item, reduced)
        positions[places] = [item.positions[name] for name in names]
    return None if np.isnan(positions).any() else positions


def joint_box(required: Sequence[Requirement], reduced: ReducedModel) -> tuple[Floats, Floats]:
    """Return where limits and all joint positions among what is required let the group's joints be.

    Returns:
        Lower and upper bounds, shape (n,) each [rad | m]; a lower one exceeds its upper one where nothing
        is left.

    Raises:
        ProblemError: If a joint outside the group is required to be where it is not.
    """
    lower, upper = np.array(reduced.limits.lower), np.array(reduced.limits.upper)
    for item in required:
        if isinstance(item, JointPositions):
            places, names = group_places(item, reduced)
            least = [item.positions[name] - item.below[name] for name in names]
            most = [item.positions[name] + item.above[name] for name in names]
            lower[places] = np.maximum(lower[places], least)
            upper[places] = np.minimum(upper[places], most)
    return lower, upper


@constrain.register
def _(
    required: JointPositions, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    places, names = group_places(required, reduced)
    if not names:
        return ()
    centre = np.array([required.positions[name] for name in names])
    below = np.array([required.below[name] for name in names])
    above = np.array([required.above[name] for name in names])
    slack = min(float(below.min()), float(above.min()))
    return (
        constraint(
            JointPosition(places),
            lower=centre - below * (1.0 - inset),
            upper=centre + above * (1.0 - inset),
            tolerance=max(slack * inset * 0.5, 1e-9),
            window=window,
        ),
    )
