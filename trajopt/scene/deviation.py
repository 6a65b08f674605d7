"""Bounds on the displacement of a robot's bodies by joint position errors."""

import numpy as np
import pinocchio as pin

from trajopt.robot.joints import joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, readonly
from trajopt.values.shapes.shapes import Plane, bounding_box


def largest_deviation(reduced: ReducedModel, errors: Floats) -> float:
    """Bound the displacement of any point of the robot and its attached objects, in any configuration [m].

    A joint that turns by an angle moves a point by at most the angle times the point's distance from the
    joint, which is at most the sum of the distances between consecutive joints. Errors of several joints add
    up. The result also bounds the approach of two bodies; for these only the joints between them count, and
    for two arms the joints of both.

    Args:
        errors: Largest error of each joint of the group, shape (n,) [rad | m].
    """
    alone = reduced.derived(_levers) @ (np.abs(reduced.mimic_matrix) @ errors)
    together = pair_levers(reduced) @ errors
    return max(float(alone.max(initial=0.0)), float(together.max(initial=0.0)))


def pair_levers(reduced: ReducedModel) -> Floats:
    """Bound the approach speed of the bodies of each pair per unit speed of each joint, shape (p, n).

    In any configuration [m/rad | m/m].
    """
    return reduced.derived(_pair_levers)


def _pair_levers(reduced: ReducedModel) -> Floats:
    levers, pairs = reduced.derived(_levers), reduced.pairs
    first, second = levers[pairs.first], levers[pairs.second]
    # A joint that carries both moves neither as seen from the other.
    between = np.where((first > 0.0) & (second > 0.0), 0.0, first + second)
    return readonly(between @ np.abs(reduced.mimic_matrix))


def _levers(reduced: ReducedModel) -> Floats:
    """Bound the distance of each body's points from each joint that carries it, 1 for a sliding joint.

    In any configuration, shape (bodies, model joints) [m]; 0 for joints that do not carry the body.
    """
    model = reduced.model
    slides = [joint_unit(model, name) == "m" for name in model.names]
    columns = [0, *(int(joint.idx_v) for joint in list(model.joints)[1:])]
    apart = [float(np.linalg.norm(placement.translation)) for placement in model.jointPlacements]
    strokes = [0.0, *(_stroke(model, joint) if slides[joint] else 0.0 for joint in range(1, model.njoints))]
    parents = [int(parent) for parent in model.parents]
    found = np.zeros((len(reduced.bodies), model.nv))
    carried = [(number, body) for number, body in enumerate(reduced.bodies) if body.joint > 0]
    # A half-space has no end: what it meets is no farther from a joint than the farthest of the other bodies.
    for number, body in sorted(carried, key=lambda item: isinstance(item[1].shape, Plane)):
        if isinstance(body.shape, Plane):
            chain = [columns[joint] for joint in list(model.supports[body.joint])[1:]]
            found[number, chain] = found[:, chain].max(axis=0)
            continue
        lower, upper = bounding_box(body.shape)
        middle, radius = (lower + upper) / 2.0, float(np.linalg.norm(upper - lower)) / 2.0
        lever, joint = float(np.linalg.norm(body.placement * middle)) + radius, body.joint
        while joint > 0:
            found[number, columns[joint]] = 1.0 if slides[joint] else lever
            lever += apart[joint] + strokes[joint]
            joint = parents[joint]
    return readonly(found)


def _stroke(model: pin.Model, joint: int) -> float:
    place = model.joints[joint].idx_q
    return float(max(abs(model.lowerPositionLimit[place]), abs(model.upperPositionLimit[place])))
