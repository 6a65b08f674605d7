"""Requirements as a proof states them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import singledispatch

import numpy as np

from trajopt.files.proof.leaves import SURE
from trajopt.files.proof.pairs import Document, placed
from trajopt.problem.requirement import Requirement
from trajopt.problem.requirements import (
    AxisAlignment,
    FramePlacement,
    JointPositions,
    PositionInRegion,
    RotationCoordinates,
)
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.robot.joints import Anchor
from trajopt.values.arrays import Bools, Floats
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import Box, Cylinder, Plane, Sphere
from trajopt.values.trajectory import Interpolation
from trajopt.verify.checks.tool_speed import SAMPLES
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.relative_motion import PointMotion, RelativeMotion

Shown = Callable[[Floats, Floats], Bools]
"""Returns whether the checker can show a requirement in intervals, given by begin and end, (c,) each."""
TIGHT = 0.02
"""Largest error of a steady speed, as a share of the limit."""
MARGIN = 1.1
"""Factor on bounds of paths, as the checker's differ a little."""


@dataclass(frozen=True, eq=False)
class RequirementRecord:
    """A requirement as a proof states it.

    Attributes:
        shown: Finds intervals; None for one of the end alone.
        shortest: Shorter intervals are not cut for its sake [s].
        times: Moments that the grid must have [s].
    """

    document: Document
    shown: Shown | None = None
    shortest: float = 2e-4
    words: str = ""
    times: tuple[float, ...] = ()


@singledispatch
def stated(requirement: Requirement, motion: JudgedMotion, *, always: bool) -> RequirementRecord | None:
    del requirement, motion, always
    return None


@stated.register
def _(requirement: JointPositions, motion: JudgedMotion, *, always: bool) -> RequirementRecord | None:
    moving = motion.reduced.moving_joints
    if not set(requirement.positions) <= set(moving):
        return None
    ranges: list[list[object]] = []
    for joint, position in requirement.positions.items():
        sides = position - requirement.below[joint], position + requirement.above[joint]
        ranges.append([moving.index(joint) + 1, *(side if np.isfinite(side) else None for side in sides)])
    document: Document = {"kind": "joint positions", "always": always, "ranges": ranges}
    return RequirementRecord(document, _everywhere if always else None)


@stated.register
def _(requirement: FramePlacement, motion: JudgedMotion, *, always: bool) -> RequirementRecord | None:
    seen = _seen(motion, requirement.frame, requirement.reference)
    rotation = np.where(requirement.rotation_tolerance >= np.pi, np.inf, requirement.rotation_tolerance)
    vector = requirement.coordinates is RotationCoordinates.ROTATION_VECTOR or np.isinf(rotation).all()
    if seen is None or not vector:
        return None
    frame, reference = seen
    goal = reference.placement * requirement.placement
    point = Placement(frame.placement.rotation, frame.placement * requirement.offset)
    stated = np.concatenate((requirement.position_tolerance, rotation)).tolist()
    sizes = [size if np.isfinite(size) else None for size in stated]
    document: Document = {
        "kind": "held placement" if always else "frame placement",
        "frame": requirement.frame,
        "place": placed(frame.joint, point),
        "goal": placed(reference.joint, goal),
        "position": sizes[:3],
        "rotation": sizes[3:],
    }
    most = np.concatenate((requirement.position_tolerance, rotation)) + 0.9 * motion.options.excess
    moving = RelativeMotion(
        motion.among, requirement.frame, reference=requirement.reference, offset=requirement.offset
    )

    def shown(begin: Floats, end: Floats) -> Bools:
        bounds, half = moving.bounds(begin, end), MARGIN * (end - begin) ** 2 / 8.0
        beside = bounds.point_acceleration * half
        rest = (bounds.turn_acceleration + bounds.turn_rate**2) * half
        sizes = [_off_goal(requirement.placement, *moving.placements(times)) for times in (begin, end)]
        off, skew, cosine = (np.stack(side) for side in zip(*sizes, strict=True))
        angle = np.arccos(np.clip(cosine.min(axis=0) - 1.5 * rest, -1.0, 1.0))
        sinc = np.asarray(np.sinc(angle / np.pi), dtype=np.float64)[:, None]
        reached = np.concatenate(
            (off.max(axis=0) + beside[:, None], (skew.max(axis=0) + rest[:, None]) / sinc), axis=1
        )
        return np.all((reached <= most) | np.isinf(most), axis=1)

    return RequirementRecord(document, shown if always else None)


def _off_goal(goal: Placement, rotation: Floats, point: Floats) -> tuple[Floats, Floats, Floats]:
    """Return sizes of the position's error, of the skew part of the rotation, and the cosine of its angle."""
    turned = goal.rotation.T @ rotation
    skew = 0.5 * (turned - turned.swapaxes(1, 2))[:, (2, 0, 1), (1, 2, 0)]
    cosine = 0.5 * (np.trace(turned, axis1=1, axis2=2) - 1.0)
    return np.abs((point - goal.translation) @ goal.rotation), np.abs(skew), cosine


@stated.register
def _(requirement: AxisAlignment, motion: JudgedMotion, *, always: bool) -> RequirementRecord | None:
    seen = _seen(motion, requirement.frame, requirement.reference)
    if seen is None or requirement.tolerance > 3.1:
        return None
    frame, reference = seen
    document: Document = {
        "kind": "axis alignment",
        "frame": requirement.frame,
        "joint": frame.joint,
        "axis": (frame.placement.rotation @ requirement.axis).tolist(),
        "reference": reference.joint,
        "direction": (reference.placement.rotation @ requirement.direction).tolist(),
        "tolerance": requirement.tolerance,
        "always": always,
    }
    moving = RelativeMotion(
        motion.among, requirement.frame, reference=requirement.reference, offset=np.zeros(3)
    )

    def shown(begin: Floats, end: Floats) -> Bools:
        inner = [
            (moving.placements(times)[0] @ requirement.axis) @ requirement.direction for times in (begin, end)
        ]
        # A unit vector in a frame that turns at rate w accelerates by at most w^2 + a.
        bounds = moving.bounds(begin, end)
        off = (bounds.turn_acceleration + bounds.turn_rate**2) * (end - begin) ** 2 / 8.0
        return np.minimum(*inner) - MARGIN * off >= np.cos(requirement.tolerance)

    return RequirementRecord(document, shown if always else None)


@stated.register
def _(requirement: PositionInRegion, motion: JudgedMotion, *, always: bool) -> RequirementRecord | None:
    seen = _seen(motion, requirement.frame, requirement.reference)
    if seen is None:
        return None
    frame, reference = seen
    members = [(shape, where) for shape, where in requirement.members]
    document: Document = {
        "kind": "position in region",
        "frame": requirement.frame,
        "place": placed(frame.joint, Placement(np.eye(3), frame.placement * requirement.offset)),
        "members": [
            [*_sized(shape), placed(reference.joint, reference.placement * where)] for shape, where in members
        ],
        "always": always,
    }
    moving = RelativeMotion(
        motion.among, requirement.frame, reference=requirement.reference, offset=requirement.offset
    )

    def shown(begin: Floats, end: Floats) -> Bools:
        points = [moving.placements(times)[1] for times in (begin, end)]
        off = MARGIN * moving.bounds(begin, end).point_acceleration * (end - begin) ** 2 / 8.0
        holds = [
            np.maximum(*(_beyond(shape, where, point) for point in points)) + off <= 0.0
            for shape, where in members
        ]
        return np.any(holds, axis=0)

    return RequirementRecord(document, shown if always else None)


def stated_speeds(limited: ToolSpeed, motion: JudgedMotion) -> list[RequirementRecord | None]:
    """Return limits of a frame's speeds, and steadiness, as a proof states them; None without a rule."""
    frame = motion.reduced.anchors.get(limited.frame)
    if frame is None:
        return [None]
    point = PointMotion(motion, limited.frame, offset=limited.offset)
    place = placed(frame.joint, Placement(np.eye(3), frame.placement * limited.offset))
    document: Document = {"frame": limited.frame, "place": place}

    def velocities(begin: Floats, end: Floats, which: int = 0) -> tuple[list[Floats], Floats]:
        changes, length = point.changes(begin, end), end - begin
        smooth = which or motion.trajectory.interpolation is Interpolation.QUINTIC
        off = changes.second[:, which] * length**2 / 8.0 if smooth else changes.first[:, 0] * length / 2.0
        return [point.speeds(times)[which] for times in (begin, end)], MARGIN * off

    def below(kind: str, which: int, limit: float) -> RequirementRecord:
        def shown(begin: Floats, end: Floats) -> Bools:
            sides, off = velocities(begin, end, which)
            return np.maximum(*(np.linalg.norm(side, axis=1) for side in sides)) + off <= limit * SURE

        return RequirementRecord({"kind": kind, **document, "limit": limit}, shown)

    limits = {"tool speed": limited.linear, "angular speed": limited.angular}
    found = [
        below(kind, which, limit) for which, (kind, limit) in enumerate(limits.items()) if np.isfinite(limit)
    ]
    if not np.isfinite(limited.steady):
        return [*found]
    least, error = (1.0 - limited.steady) * limited.linear, TIGHT * limited.linear
    times = np.linspace(0.0, motion.trajectory.duration, SAMPLES)
    speed = np.linalg.norm(point.speeds(times)[0], axis=1)
    above = times[speed > least]
    if not len(above):
        return [*found, None]
    since, until = float(above[0]), float(above[-1])
    within = (times >= since) & (times <= until)
    if speed[~within].sum() + 2.0 * error * len(times) > speed[within].sum():
        return [*found, None]

    def steady(begin: Floats, end: Floats) -> Bools:
        (first, last), off = velocities(begin, end)
        middle = first + last
        along = [np.einsum("ci,ci->c", side, middle) for side in (first, last)]
        length = np.maximum(np.linalg.norm(middle, axis=1), 1e-12)
        reached = np.minimum(*along) / length - off >= least
        uneven = np.linalg.norm(last - first, axis=1) + 2.0 * off
        return (reached | (begin < since) | (end > until)) & (uneven <= error)

    stated: Document = {"kind": "steady speed", **document, "least": least, "since": since, "until": until}
    return [*found, RequirementRecord(stated, steady, times=(since, until))]


def _everywhere(begin: Floats, end: Floats) -> Bools:
    return np.ones(len(begin), dtype=np.bool_) & (end > begin)


def _seen(motion: JudgedMotion, frame: str, reference: str) -> tuple[Anchor, Anchor] | None:
    anchors = motion.among.reduced.anchors
    found, base = anchors.get(frame), anchors.get(reference)
    return None if found is None or base is None else (found, base)


def _sized(shape: Box | Sphere | Cylinder | Plane) -> tuple[str, list[float]]:
    match shape:
        case Box(x=x, y=y, z=z):
            return "box", [x, y, z]
        case Sphere(radius=radius):
            return "sphere", [radius]
        case Cylinder(radius=radius, length=length):
            return "cylinder", [radius, length]
        case Plane():
            return "half-space", []


def _beyond(shape: Box | Sphere | Cylinder | Plane, where: Placement, points: Floats) -> Floats:
    local = (points - where.translation) @ where.rotation
    match shape:
        case Box(x=x, y=y, z=z):
            return (np.abs(local) - np.array((x, y, z)) / 2.0).max(axis=1)
        case Sphere(radius=radius):
            return np.linalg.norm(local, axis=1) - radius
        case Cylinder(radius=radius, length=length):
            across = np.hypot(local[:, 0], local[:, 1]) - radius
            return np.maximum(across, np.abs(local[:, 2]) - length / 2.0)
        case Plane():
            return local[:, 2]
