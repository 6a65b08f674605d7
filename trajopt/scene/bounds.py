"""Bounds over all configurations: gravity torques of joints, and approaches of bodies by their motion."""

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, hypot

import numpy as np
import pinocchio as pin

from trajopt.scene.model_error import levers_of
from trajopt.scene.reduced import ReducedModel, loaded_model, payloads
from trajopt.values.arrays import Floats, readonly

ENDLESS = 1e6
"""Range of a sliding joint without limits [m]."""


@dataclass(frozen=True, eq=False)
class _Moments:
    """Enclosure of the first moments of the bodies that a joint carries, in the joint's frame.

    Attributes:
        low: Least component along the axis [kg m].
        radius: Largest distance from the axis.
    """

    mass: float
    low: float
    high: float
    radius: float
    norm: float


def largest_gravity_torques(reduced: ReducedModel) -> Floats:
    """Bound the holding torque over all configurations, shape (n,) [Nm | N].

    The bodies carried by joint j have the first moment d_j = sum m c about its origin; the gravity torque is
    the component of d_j x g along its axis. From the tip to the base, the set of all d_j is enclosed by a
    cylinder around the axis and by a ball; from the base to the tip, the angle between axis and gravity by an
    interval. Position limits of revolute joints are ignored. Attached objects count. A joint also bears the
    torques of the joints that mimic it.
    """
    return _derived(reduced, _largest_torques)


def _largest_torques(reduced: ReducedModel) -> Floats:
    arm = _Enclosed.of(reduced)
    largest = np.zeros(len(arm.slides) - 1)
    for joint, (low, high) in enumerate(arm.tilts[1:], start=1):
        moments = arm.moments[joint]
        if arm.slides[joint]:
            largest[joint - 1] = moments.mass * max(abs(np.cos(low)), abs(np.cos(high)))
        else:
            upright = low <= np.pi / 2.0 <= high
            largest[joint - 1] = moments.radius * (1.0 if upright else max(np.sin(low), np.sin(high)))
    return arm.gravity * (np.abs(reduced.mimic_matrix).T @ largest)


def _derived(reduced: ReducedModel, build: Callable[[ReducedModel], Floats]) -> Floats:
    return reduced.derived(build) if payloads(reduced) else reduced.derived_of_robot(build)


def largest_gravity_slopes(reduced: ReducedModel) -> Floats:
    """Bound the derivatives of the holding torque of each joint (rows) by the position of each, shape (n, n).

    Revolute joints i and j, j further out, change each other's torque by at most |d_j x g|; a prismatic joint
    j and the revolute joints before it by the weight that j carries.
    """
    return _derived(reduced, _largest_slopes)


def _largest_slopes(reduced: ReducedModel) -> Floats:
    arm = _Enclosed.of(reduced)
    slopes = np.zeros((len(arm.slides) - 1, len(arm.slides) - 1))
    for outer in range(1, len(arm.slides)):
        moments = arm.moments[outer]
        for inner in list(reduced.model.supports[outer])[1:]:
            if not arm.slides[inner]:
                size = moments.mass if arm.slides[outer] else moments.norm
                slopes[inner - 1, outer - 1] = slopes[outer - 1, inner - 1] = size
    moved = np.abs(reduced.mimic_matrix)
    return arm.gravity * (moved.T @ slopes @ moved)


@dataclass(frozen=True, eq=False)
class _Enclosed:
    """Enclosures of each joint's moments and of its axis's angle to gravity [rad]; the world first."""

    gravity: float
    slides: list[bool]
    tilts: list[tuple[float, float]]
    moments: dict[int, "_Moments"]

    @staticmethod
    def of(reduced: ReducedModel) -> "_Enclosed":
        model = loaded_model(reduced)
        gravity = np.array(model.gravity.linear)
        size = float(np.linalg.norm(gravity))
        axes, slides = _axes(model)
        tilts = _tilts(model, axes, slides, gravity / size if size else gravity)
        limits = reduced.limits
        lower, upper = np.maximum(limits.lower, -ENDLESS), np.minimum(limits.upper, ENDLESS)
        middle = reduced.mimic_matrix @ (0.5 * (lower + upper)) + reduced.mimic_offset
        half = np.abs(reduced.mimic_matrix) @ (0.5 * (upper - lower))
        ranges = np.stack((middle - half, middle + half), axis=1)
        moments: dict[int, _Moments] = {}
        for joint in range(model.njoints - 1, 0, -1):
            carried = {
                child: _slid(moments[child], *ranges[child - 1]) if slides[child] else moments[child]
                for child in range(joint + 1, model.njoints)
                if model.parents[child] == joint
            }
            moments[joint] = _moments(model, joint, axes, carried)
        return _Enclosed(size, slides, tilts, moments)


def _axes(model: pin.Model) -> tuple[list[Floats], list[bool]]:
    axes, slides = [np.zeros(3)], [False]
    neutral = pin.neutral(model)
    for joint in model.joints[1:]:
        data = joint.createData()
        joint.calc(data, neutral[joint.idx_q : joint.idx_q + joint.nq])
        motion = np.array(data.S).reshape(6, -1)[:, 0]
        sliding = bool(np.abs(motion[3:]).max() == 0.0)
        axes.append(motion[:3] if sliding else motion[3:])
        slides.append(sliding)
    return axes, slides


def _tilts(
    model: pin.Model, axes: list[Floats], slides: list[bool], down: Floats
) -> list[tuple[float, float]]:
    """Return the least and largest angle of each joint's axis to gravity [rad]; the world's first."""
    # The last joint before each, itself included, that turns, and how the joint stands in its frame.
    turning: list[tuple[int, Floats]] = [(0, np.eye(3))]
    tilts = [(0.0, 0.0)]
    for joint in range(1, model.njoints):
        before, stands = turning[model.parents[joint]]
        stands = stands @ model.jointPlacements[joint].rotation
        turning.append((before, stands) if slides[joint] else (joint, np.eye(3)))
        axis = stands @ axes[joint]
        if before == 0:
            angle = _angle(axis, down)
            tilts.append((angle, angle))
            continue
        # The axis goes round the one before at a fixed angle: the triangle inequality on the sphere.
        between, (low, high) = _angle(axis, axes[before]), tilts[before]
        least = max(low - between, between - high, 0.0)
        most = np.pi - max(np.pi - high - between, between - (np.pi - low), 0.0)
        tilts.append((least, most))
    return tilts


def _angle(first: Floats, second: Floats) -> float:
    (a, b, c), (x, y, z) = first.tolist(), second.tolist()
    return atan2(hypot(b * z - c * y, c * x - a * z, a * y - b * x), a * x + b * y + c * z)


def _moments(model: pin.Model, joint: int, axes: list[Floats], outer: dict[int, _Moments]) -> _Moments:
    axis, link = axes[joint], model.inertias[joint]
    mass = float(link.mass)
    fixed = mass * np.array(link.lever)
    middle = np.zeros(3)
    least = most = spread = reach = 0.0
    for child, carried in outer.items():
        place = model.jointPlacements[child]
        mass += carried.mass
        fixed = fixed + carried.mass * np.array(place.translation)
        direction = place.rotation @ axes[child]
        along = float(np.clip(direction @ axis, -1.0, 1.0))
        aside = float(np.sqrt(1.0 - along**2))
        ends = (along * carried.low, along * carried.high)
        least += max(min(ends) - aside * carried.radius, -carried.norm)
        most += min(max(ends) + aside * carried.radius, carried.norm)
        middle = middle + (direction - along * axis) * 0.5 * (carried.low + carried.high)
        spread += aside * 0.5 * (carried.high - carried.low) + carried.radius
        reach += carried.norm
    height = float(fixed @ axis)
    level = fixed - height * axis
    radius = min(float(np.linalg.norm(level + middle)) + spread, float(np.linalg.norm(level)) + reach)
    low, high = height + least, height + most
    norm = min(float(np.linalg.norm(fixed)) + reach, float(np.hypot(radius, max(abs(low), abs(high)))))
    return _Moments(mass, low, high, radius, norm)


def _slid(moments: _Moments, low: float, high: float) -> _Moments:
    least, most = moments.low + moments.mass * low, moments.high + moments.mass * high
    norm = float(np.hypot(moments.radius, max(abs(least), abs(most))))
    return _Moments(moments.mass, least, most, moments.radius, norm)


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
    placed = [(body.joint, body.placement, body.shape) for body in reduced.bodies]
    return readonly(levers_of(reduced.model, placed)[:, 1:])
