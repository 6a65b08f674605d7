"""Twin of the native core `servo`, in plain Python."""

import numpy as np

from trajopt.driving.servo_program import DAMPING, INSET, PENALTY, Braking
from trajopt.geometry import JointPlacements
from trajopt.geometry.geometry import BoundingBoxes
from trajopt.robot.joints import EXCESS
from trajopt.scene.bounds import pair_levers
from trajopt.scene.reduced import ReducedModel
from trajopt.timing.time_scaling import TICK
from trajopt.values.arrays import Floats


def bounds(braking: Braking, state: Floats) -> tuple[Floats, Floats]:
    limits, (position, _, acceleration) = braking.limits, state
    most, change = limits.acceleration, limits.jerk * braking.period
    reached = np.stack((acceleration - change, acceleration + change))
    least, greatest = _settled(braking, state, np.clip(reached, -most, most))
    room = np.stack((position - limits.lower, limits.upper - position))
    delayed = most * braking.delay
    brakeable = np.sqrt(delayed**2 + 2.0 * most * np.maximum(room - INSET, 0.0)) - delayed
    down, up = np.minimum(limits.velocity * (1.0 - EXCESS), brakeable)
    lower, upper = np.clip(np.stack((-down, up)), least, greatest)
    return lower, upper


def _settled(braking: Braking, state: Floats, acceleration: Floats) -> Floats:
    gone = np.maximum(np.abs(acceleration) / braking.limits.jerk + TICK, braking.period)
    return state[1] + braking.period * (state[2] + acceleration) / 2.0 + acceleration * gone / 2.0


def nearer(reduced: ReducedModel, placed: JointPlacements, lower: Floats, upper: Floats) -> Floats:
    model, boxes, pairs = reduced.model, BoundingBoxes.of(reduced), reduced.pairs
    rates = reduced.mimic_matrix @ ((lower + upper) / 2.0)
    speed: list[float] = []
    for joint, centre, radius in zip(boxes.joint, boxes.centre, boxes.radius, strict=True):
        carriers = [int(model.joints[each].idx_v) for each in list(model.supports[int(joint)])[1:]]
        twist = placed.jacobian[0][:, carriers] @ rates[carriers]
        at = placed.rotation[0, joint] @ centre + placed.translation[0, joint]
        moved = twist[:3] + np.cross(twist[3:], at)
        speed.append(float(np.linalg.norm(moved) + np.linalg.norm(twist[3:]) * radius))
    levers, bodies = pair_levers(reduced), np.array(speed)
    middle = bodies[pairs.first] + bodies[pairs.second] + levers @ ((upper - lower) / 2.0)
    return np.minimum(levers @ np.maximum(-lower, upper), middle)


def slopes(linear: Floats, angular: Floats, mimic: Floats, length: float) -> tuple[Floats, Floats]:
    """Return singular values and their slopes: the Jacobian's derivatives one by one, each shape (6, n)."""
    jacobian = np.concatenate((linear, length * angular), axis=1).T @ mimic
    left, values, right = np.linalg.svd(jacobian, full_matrices=False)
    turned = np.zeros((len(linear), 6, len(linear)))
    for one in range(len(linear)):
        for other in range(len(linear)):
            first = min(one, other)
            turned[one, :3, other] = np.cross(angular[first], linear[max(one, other)])
            if one < other:
                turned[one, 3:, other] = length * np.cross(angular[one], angular[other])
    by_joint = np.einsum("axb,bn,am->mxn", turned, mimic, mimic)
    return values, np.einsum("xk,mxn,kn->km", left, by_joint, right)


def value(
    task: Floats,
    target: Floats,
    rows: Floats,
    least: Floats,
    velocity: Floats,
    velocities: Floats,
) -> float:
    """Return the value that `settle` minimises."""
    missed = task @ velocities - target
    relative, broken = velocities / velocity, np.maximum(least - rows @ velocities, 0.0)
    return float(missed @ missed + DAMPING * relative @ relative + PENALTY * broken.sum())
