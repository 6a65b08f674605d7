"""Terms of the joint positions alone: single joints, weighted sums of them, a posture at rest."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import CoupledJoints, JointPositions, Requirement, together
from trajopt.problem.residual import WHOLE, Constraint, Cost, Window, constraint
from trajopt.robot.joints import joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, Loss, Rows, Value, number
from trajopt.values.errors import JointNotFound, ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_joint_position

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics


@dataclass(frozen=True, eq=False)
class JointPosition(Value):
    """The positions of some of the group's joints, one component each [rad | m].

    Attributes:
        joints: Their indices in the group, shape (k,).
        units: "rad" or "m" of each.
    """

    joints: Ints
    units: tuple[str, ...] = ()
    name = "joint positions"

    def linearise(self, motion: Motion) -> Rows:
        value = motion.positions[:, self.joints]
        select = np.eye(motion.positions.shape[1])[self.joints]
        return motion.rows_of_all(value, np.tile(select, (len(value), 1, 1)))

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        return kinematics.q[self.joints.tolist()]


def without_followers(required: Sequence[Requirement], reduced: ReducedModel) -> tuple[Requirement, ...]:
    """Return requirements with joint positions of mimic joints stated for their leaders.

    A mimic joint is at factor times leader plus offset, so a range of its positions is a range of the
    leader's.
    """
    stated: list[Requirement] = []
    for item in required:
        followers = _followers(item, reduced) if isinstance(item, JointPositions) else {}
        if not isinstance(item, JointPositions) or not followers:
            stated.append(item)
            continue
        others = item.positions.keys() - followers.keys()
        if others:
            sides = (item.positions, item.below, item.above)
            positions, below, above = ({k: side[k] for k in side if k in others} for side in sides)
            stated.append(JointPositions(positions, below, above))
        for joint, (leader, factor, offset) in followers.items():
            sides = (item.below[joint], item.above[joint])
            below, above = (side / abs(factor) for side in (sides if factor > 0.0 else sides[::-1]))
            position = (item.positions[joint] - offset) / factor
            stated.append(JointPositions({leader: position}, {leader: below}, {leader: above}))
    return tuple(stated)


def _followers(required: JointPositions, reduced: ReducedModel) -> dict[str, tuple[str, float, float]]:
    mimics = reduced.scene.robot.mimics
    named = {joint: mimics[joint] for joint in required.positions if joint in mimics}
    return {
        joint: (mimic.source, mimic.multiplier, mimic.offset)
        for joint, mimic in named.items()
        if mimic.multiplier != 0.0 and mimic.source in reduced.joint_names
    }


def group_places(required: JointPositions, reduced: ReducedModel) -> tuple[Ints, tuple[str, ...]]:
    """Return which of the group's joints are required, and their names; mimic joints as their leaders."""
    robot = reduced.scene.robot
    inside: list[str] = []
    for joint, value in required.positions.items():
        if joint in reduced.joint_names:
            inside.append(joint)
            continue
        stays = float(reduced.start[robot.index([joint])[0]])
        if not -required.below[joint] <= stays - value <= required.above[joint]:
            mimic, why = robot.mimics.get(joint), f"it is not in group {shown(reduced.group)}"
            if mimic is not None:
                why = f"it follows {shown(mimic.source)}, which is not in group {shown(reduced.group)}"
                why = why if mimic.multiplier else "it mimics with factor 0"
            unit = joint_unit(robot.model, joint)
            at, fixed = in_joint_position(value, unit), in_joint_position(stays, unit)
            raise ProblemError(f"joint {shown(joint)} is required at {at}, but {why} and stays at {fixed}")
    places = np.array([reduced.joint_names.index(joint) for joint in inside], dtype=np.int64)
    return places, tuple(inside)


def fixed_positions(required: Sequence[Requirement], reduced: ReducedModel) -> Floats | None:
    """Return the group's positions, shape (n,), if joint positions alone are required and fix all joints.

    Tolerances are not considered; a joint fixed by several is in the middle of their common range.

    Raises:
        ProblemError: If a joint outside the group is required to be elsewhere.
    """
    positions = np.full(len(reduced.joint_names), np.nan)
    for item in together(without_followers(required, reduced)):
        if not isinstance(item, JointPositions):
            return None
        places, names = group_places(item, reduced)
        positions[places] = [item.positions[name] for name in names]
    return None if np.isnan(positions).any() else positions


def joint_box(required: Sequence[Requirement], reduced: ReducedModel) -> tuple[Floats, Floats]:
    """Return the range that limits and requirements leave to the joints, shape (n,) each [rad | m].

    A lower bound exceeds its upper one if the range is empty.

    Raises:
        ProblemError: If a joint outside the group is required to be elsewhere.
    """
    lower, upper = np.array(reduced.limits.lower), np.array(reduced.limits.upper)
    for item in without_followers(required, reduced):
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
    stated = without_followers((required,), reduced)
    if stated[0] is not required:
        each = (constrain(item, reduced, window, inset=inset) for item in together(stated))
        return tuple(chain.from_iterable(each))
    places, names = group_places(required, reduced)
    if not names:
        return ()
    centre = np.array([required.positions[name] for name in names])
    below = np.array([required.below[name] for name in names])
    above = np.array([required.above[name] for name in names])
    slack = min(float(below.min()), float(above.min()))
    return (
        constraint(
            JointPosition(places, tuple(joint_unit(reduced.scene.robot.model, name) for name in names)),
            lower=centre - below * (1.0 - inset),
            upper=centre + above * (1.0 - inset),
            tolerance=max(slack * inset * 0.5, 1e-9),
            window=window,
        ),
    )


@dataclass(frozen=True, eq=False)
class JointSum(Value):
    """One component: a weighted sum of the group's positions and a constant [rad | m].

    Attributes:
        weights: Shape (n,).
    """

    weights: Floats
    constant: float
    name = "coupled joints"

    def linearise(self, motion: Motion) -> Rows:
        value = motion.positions @ self.weights + self.constant
        return motion.rows_of_all(value[:, None], np.tile(self.weights, (len(value), 1, 1)))

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        import casadi as ca

        return ca.dot(ca.SX(self.weights), kinematics.q) + self.constant


@constrain.register
def _(
    required: CoupledJoints, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    weights, constant = np.zeros(len(reduced.joint_names)), 0.0
    moved, robot = tuple(reduced.model.names[1:]), reduced.scene.robot
    for joint, factor in required.weights.items():
        if joint in moved:
            place = moved.index(joint)
            weights += factor * reduced.mimic_matrix[place]
            constant += factor * float(reduced.mimic_offset[place])
        else:
            constant += factor * float(reduced.start[robot.index([joint])[0]])
    off = abs(constant - required.value)
    if not weights.any():
        if off > required.tolerance:
            raise ProblemError(f"{required} is off by {off:g}, and none of its joints is in the group")
        return ()
    within = required.tolerance * (1.0 - inset)
    return (
        constraint(
            JointSum(weights, constant),
            lower=required.value - within,
            upper=required.value + within,
            tolerance=max(required.tolerance * inset * 0.5, 1e-9),
            window=window,
        ),
    )


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
        names = motion.query.reduced.joint_names
        for joint in self.positions:
            if joint not in names:
                raise JointNotFound("joint of the group", joint, names)
        places = [names.index(joint) for joint in self.positions]
        value = motion.positions[:, places] - np.array(list(self.positions.values()))
        return motion.rows_of_all(value, np.tile(np.eye(len(names))[places], (len(value), 1, 1)))

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
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
        window: Part of the motion in which it counts.

    Raises:
        ProblemError: If no joint is named.
        ShapeError: If a position is not finite.
    """
    if not positions:
        raise ProblemError("rest_posture: name at least one joint")
    values = {joint: number(f"position of {joint}", value) for joint, value in positions.items()}
    return Cost(RestPosture(values), weight, loss, window)


SHARE = 0.1
"""Share of the accepted drift that the program's own tolerances may add up to."""


@dataclass(frozen=True, eq=False)
class Rolling(Value):
    """Motion of each step from knot to knot across the heading in its middle [m].

    The chord of an arc is along the heading in its middle, so arcs and straight lines hold it exactly, smooth
    curves up to the third power of the step.

    Attributes:
        places: Of x, y and yaw among the group's joints.
    """

    places: tuple[int, int, int]
    name = "rolling"

    def linearise(self, motion: Motion) -> Rows:
        knots, (x, y, yaw) = motion.knots, self.places
        step = np.diff(knots, axis=0)
        heading = (knots[1:, yaw] + knots[:-1, yaw]) / 2.0
        s, c = np.sin(heading), np.cos(heading)
        jacobian = np.zeros((len(step), 2, knots.shape[1]))
        for end, sign in ((0, -1.0), (1, 1.0)):
            jacobian[:, end, x], jacobian[:, end, y] = -sign * s, sign * c
            jacobian[:, end, yaw] = -0.5 * (c * step[:, x] + s * step[:, y])
        first = np.arange(len(step))
        return Rows(
            c * step[:, y] - s * step[:, x],
            jacobian,
            np.stack((first, first + 1), axis=1),
            np.zeros(len(step), dtype=np.int64),
            first.astype(np.float64) + 0.5,
        )


def rolling(reduced: ReducedModel, knots: int) -> tuple[Constraint, ...]:
    base = reduced.scene.robot.base
    places = base.rolling(reduced.joint_names)
    if places is None:
        return ()
    return (constraint(Rolling(places), lower=0.0, upper=0.0, tolerance=SHARE * base.drift / knots),)
