"""Model error: difference of a robot from its description."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
import pinocchio as pin

from trajopt.robot.bodies import CollisionBody
from trajopt.robot.joints import FixedBody, joint_unit
from trajopt.robot.loading.pinocchio_model import link_frame
from trajopt.robot.robot import Robot
from trajopt.values.arrays import Floats, Ints, Value, at_least, not_negative, readonly
from trajopt.values.cached import cached_per_value
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import Plane, Shape, bounding_box


@dataclass(frozen=True)
class ModelUncertainty(Value):
    """Largest differences between a robot and its description.

    Attributes:
        joints: Error of the zero position of each joint, by name [rad | m].
        shift: Displacement of the robot's root in the world [m].
        turn: Rotation of the robot about any axis through the origin of its root [rad].
        payload: Error of the masses of attached objects, as a share of each.
    """

    joints: Mapping[str, float] = field(default_factory=dict[str, float])
    shift: float = 0.0
    turn: float = 0.0
    payload: float = 0.0

    def __post_init__(self) -> None:
        at_least(self, 0.0, "shift", "turn", "payload")
        for name, size in self.joints.items():
            not_negative(f"joints[{name!r}]", size)

    @property
    def displaces(self) -> bool:
        return bool(self.shift or self.turn or any(self.joints.values()))

    def with_joints(self, errors: Mapping[str, float], robot: Robot) -> ModelUncertainty:
        """Return a copy with further errors of joints [rad | m]; joints that follow one are off with it."""
        followers = {
            name: abs(mimic.multiplier) * errors[mimic.source]
            for name, mimic in robot.mimics.items()
            if mimic.source in errors
        }
        further = {**followers, **errors}
        sizes = {
            name: self.joints.get(name, 0.0) + further.get(name, 0.0) for name in (*self.joints, *further)
        }
        return replace(self, joints=sizes)

    def __str__(self) -> str:
        largest, mounted = max(self.joints.values(), default=0.0), self.shift or self.turn
        parts = (
            f"{largest:.3g} rad or m in a joint" if largest else "",
            f"{1e3 * self.shift:.3g} mm and {self.turn:.3g} rad in the mounting" if mounted else "",
            f"{100.0 * self.payload:.3g} % of the payload" if self.payload else "",
        )
        return ", ".join(part for part in parts if part) or "none"


EXACT = ModelUncertainty()
"""No error: the robot is as described."""


def approaches(
    error: ModelUncertainty,
    robot: Robot,
    carried: Sequence[CollisionBody],
    bodies: Sequence[FixedBody],
    first: Ints,
    second: Ints,
) -> Floats:
    """Bound how much nearer the model error brings the bodies of each pair, in any configuration.

    The errors act in order: each joint turns or slides all that it carries as one, and moves a point by at
    most its error times the point's distance. A joint that carries both bodies moves neither as seen from the
    other.

    Args:
        carried: Bodies of objects on links of the robot.
        first: Of each pair the first body, shape (p,).
        second: The second, shape (p,).

    Returns:
        Shape (p,) [m].
    """
    known = {**_levers_of_links(robot), **_levers_by_name(robot, carried)}
    levers = np.zeros((len(bodies), robot.model.njoints))
    for row, body in enumerate(bodies):
        levers[row] = known.get(body.name, 0.0)
    mounted = np.array([body.name in known for body in bodies], dtype=np.bool_)
    sizes = np.array([error.turn, *(error.joints.get(name, 0.0) for name in robot.joint_names)])
    moved = np.where(sizes > 0.0, levers, 0.0) * sizes
    moved[mounted, 0] += error.shift
    moves = levers > 0.0
    moves[:, 0] = mounted
    both = moves[first] & moves[second]
    return readonly(np.where(both, 0.0, moved[first] + moved[second]).sum(axis=1))


@cached_per_value
def _levers_of_links(robot: Robot) -> Mapping[str, Floats]:
    return _levers_by_name(robot, robot.bodies)


def _levers_by_name(robot: Robot, bodies: Sequence[CollisionBody]) -> Mapping[str, Floats]:
    placed: list[PlacedShape] = []
    for body in bodies:
        link = robot.model.frames[link_frame(robot.model, body.frame)]
        at = Placement(readonly(link.placement.rotation.copy()), readonly(link.placement.translation.copy()))
        placed.append((int(link.parentJoint), at * body.placement, body.shape))
    levers = levers_of(robot.model, placed)
    return {body.name: row for body, row in zip(bodies, levers, strict=True)}


PlacedShape: TypeAlias = tuple[int, Placement, Shape]
"""A shape, the joint that carries it (0: the world), and its placement in that joint."""


def levers_of(model: pin.Model, placed: Sequence[PlacedShape]) -> Floats:
    """Bound the distance of each body's points from each joint that carries it, 1 for a sliding joint.

    In any configuration, shape (bodies, 1 + model joints) [m]; 0 for joints that do not carry the body. The
    first column is of the world's origin.
    """
    slides = [joint_unit(model, name) == "m" for name in model.names]
    apart = [float(np.linalg.norm(placement.translation)) for placement in model.jointPlacements]
    strokes = [0.0, *(_stroke(model, joint) if slides[joint] else 0.0 for joint in range(1, model.njoints))]
    parents = [int(parent) for parent in model.parents]
    found = np.zeros((len(placed), model.njoints))
    # A half-space has no end: what it meets is no farther from a joint than the farthest of the other bodies.
    for row, (joint, where, shape) in sorted(
        enumerate(placed), key=lambda each: isinstance(each[1][2], Plane)
    ):
        if isinstance(shape, Plane):
            chain = list(model.supports[joint])
            found[row, chain] = found[:, chain].max(axis=0)
            continue
        lower, upper = bounding_box(shape)
        middle, radius = (lower + upper) / 2.0, float(np.linalg.norm(upper - lower)) / 2.0
        lever, carrier = float(np.linalg.norm(where * middle)) + radius, joint
        while carrier > 0:
            found[row, carrier] = 1.0 if slides[carrier] else lever
            lever += apart[carrier] + strokes[carrier]
            carrier = parents[carrier]
        found[row, 0] = lever
    return found


def _stroke(model: pin.Model, joint: int) -> float:
    place = model.joints[joint].idx_q
    return float(max(abs(model.lowerPositionLimit[place]), abs(model.upperPositionLimit[place])))
