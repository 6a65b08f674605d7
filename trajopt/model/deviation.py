"""How far a robot's bodies can be from where they should be, when its joints are off by a little."""

import numpy as np
import pinocchio as pin

from trajopt.arrays import Floats
from trajopt.model.description.pinocchio_model import joint_unit
from trajopt.model.reduced import ReducedModel
from trajopt.model.shapes import Plane, bounding_box


def largest_deviation(reduced: ReducedModel, errors: Floats) -> float:
    """Return how far any point of the robot, and of what it carries, can be off in any configuration [m].

    A joint that turns by an angle moves a point by no more than the angle times the point's distance from the
    joint; that distance is at most the sum of the distances from joint to joint between them. Errors of
    several joints add up. It bounds as well by how much two bodies can be nearer to each other than they
    should be: only the joints between them count there.

    Args:
        reduced: Robot and scene.
        errors: How far each joint of the group can be off, shape (n,) [rad | m].
    """
    model = reduced.model
    off = np.abs(reduced.mimic_matrix) @ errors
    slides = [joint_unit(model, name) == "m" for name in model.names]
    largest = 0.0
    for body in reduced.bodies:
        if body.joint == 0 or isinstance(body.shape, Plane):
            continue
        lower, upper = bounding_box(body.shape)
        middle, radius = (lower + upper) / 2.0, float(np.linalg.norm(upper - lower)) / 2.0
        lever = float(np.linalg.norm(body.placement * middle)) + radius
        moved, joint = 0.0, body.joint
        while joint > 0:
            error = float(off[model.joints[joint].idx_v])
            moved += error if slides[joint] else error * lever
            lever += float(np.linalg.norm(model.jointPlacements[joint].translation))
            lever += _stroke(model, joint) if slides[joint] else 0.0
            joint = model.parents[joint]
        largest = max(largest, moved)
    return largest


def _stroke(model: pin.Model, joint: int) -> float:
    """Return how far a sliding joint is from its zero at most [m]."""
    place = model.joints[joint].idx_q
    return float(max(abs(model.lowerPositionLimit[place]), abs(model.upperPositionLimit[place])))
