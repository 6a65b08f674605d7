"""The robot's part of a reduced model, shared by all scenes and starts with the same fixed joints."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.robot.joints import WORLD_ANCHOR, Anchor, FixedBody, JointLimits
from trajopt.robot.loading.mimics import followed_limits
from trajopt.robot.loading.pinocchio_model import distinct_links, named_again
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import DrivenJoints
from trajopt.scene.track import STEADY, Track
from trajopt.values.arrays import Floats, readonly
from trajopt.values.cached import LruCache, cached_per_value
from trajopt.values.placement import WORLD, Placement
from trajopt.values.trajectory import refined


@dataclass(frozen=True, eq=False)
class AddedJoints:
    """Joints added to a model, and the frames that they carry.

    Attributes:
        anchors: The frame that each track moves, by its name.
    """

    joints: DrivenJoints
    anchors: Mapping[str, Anchor]


def add_driven(model: pin.Model, tracks: Mapping[str, Track]) -> AddedJoints:
    """Add joints to a model that move frames along tracks.

    Args:
        model: Changed in place: the joints are appended.
    """
    names: list[str] = []
    anchors: dict[str, Anchor] = {}
    moved: list[tuple[Floats, Floats]] = []
    for name, track in tracks.items():
        at, turned, angles = 0, pin.SE3(np.eye(3), np.zeros(3)), list[Floats]()
        for axis, direction in zip("xyz", np.eye(3).tolist(), strict=True):
            names.append(f"{name} along {axis}")
            at = model.addJoint(at, pin.JointModelPrismaticUnaligned(*direction), turned, names[-1])
        turned = pin.SE3(track.rotations[0], np.zeros(3))
        for piece, angle in _turns(track):
            names.append(f"{name} turning in piece {piece}")
            joint = pin.JointModelRevoluteUnaligned(*track.axes[piece].tolist())
            at = model.addJoint(at, joint, turned, names[-1])
            turned = pin.SE3(np.eye(3), np.zeros(3))
            angles.append(angle)
        anchors[name] = Anchor(at, Placement(readonly(turned.rotation.copy())))
        moved.append((track.times, _columns(track.coefficients, angles)))
    return AddedJoints(_joined(tuple(names), moved), anchors)


def _turns(track: Track) -> list[tuple[int, Floats]]:
    """Return the rotating pieces of a track, each with rate and start of its angle, (2, k)."""
    found: list[tuple[int, Floats]] = []
    lengths = np.diff(track.times)
    for piece, rate in enumerate(track.rates.tolist()):
        if abs(rate) <= STEADY:
            continue
        angle = np.zeros((2, len(lengths)))
        angle[0, piece] = rate
        angle[1, piece + 1 :] = rate * lengths[piece]
        found.append((piece, angle))
    return found


def _columns(slides: Floats, angles: list[Floats]) -> Floats:
    """Return the coefficients of all joints of a track, padded to the highest degree."""
    columns = [slides, *(angle[:, :, None] for angle in angles)]
    degree = max(len(column) for column in columns)
    return np.concatenate([np.pad(c, ((degree - len(c), 0), (0, 0), (0, 0))) for c in columns], axis=2)


def _joined(names: tuple[str, ...], moved: list[tuple[Floats, Floats]]) -> DrivenJoints:
    if not moved:
        return DrivenJoints(names, readonly(np.array((0.0, 1.0))), readonly(np.zeros((1, 1, 0))))
    times = np.unique(np.concatenate([track_times for track_times, _ in moved]))
    degree = max(len(coefficients) for _, coefficients in moved)
    columns = [refined(times, *each, degree) for each in moved]
    return DrivenJoints(names, readonly(times), readonly(np.concatenate(columns, axis=2)))


@dataclass(frozen=True, eq=False)
class ReducedRobot:
    """A robot with only one group's joints free.

    Attributes:
        model: Pinocchio's model of the free joints and of those that mimic them; never changed.
        joint_names: The group's joints, n of them.
        limits: Respect those of the joints that mimic them.
        mimic_matrix: Matrix (model joints, n) that maps the group's positions to the model's.
        mimic_offset: Offsets of mimicking joints, shape (model joints,).
        anchors: Carrying joint and placement of links, tool frames and the world, by name.
        driven: Joints that are driven by time and carry dynamic obstacles; None to leave these out.
    """

    model: pin.Model
    joint_names: tuple[str, ...]
    limits: JointLimits
    mimic_matrix: Floats
    mimic_offset: Floats
    anchors: Mapping[str, Anchor]
    bodies: tuple[FixedBody, ...]
    driven: DrivenJoints | None = None


def reduce_robot(robot: Robot, group: str, start: Floats) -> ReducedRobot:
    """Fix every joint outside the group at its start position; cached by the fixed joints."""
    joints = robot.group(group).joints
    free = {*joints, *(name for name, mimic in robot.mimics.items() if mimic.source in joints)}
    locked = [place for place, name in enumerate(robot.joint_names) if name not in free]
    key = (group, tuple(start[locked].tolist()))
    return _reductions(robot).get(key, lambda: _reduced(robot, joints, locked, start))


@cached_per_value
def _reductions(robot: Robot) -> LruCache[tuple[str, tuple[float, ...]], ReducedRobot]:
    del robot
    return LruCache(8)


def _reduced(robot: Robot, joints: tuple[str, ...], locked: list[int], start: Floats) -> ReducedRobot:
    fixed = [place + 1 for place in locked]  # pinocchio counts the universe as joint 0
    whole = distinct_links(robot.model)  # Pinocchio looks frames up by name alone.
    model = named_again(pin.buildReducedModel(whole, fixed, robot.configuration(start)))
    names = tuple(model.names[1:])
    mimic_matrix, mimic_offset = np.zeros((len(names), len(joints))), np.zeros(len(names))
    for row, name in enumerate(names):
        if name in joints:
            mimic_matrix[row, joints.index(name)] = 1.0
        else:
            mimic = robot.mimics[name]
            mimic_matrix[row, joints.index(mimic.source)] = mimic.multiplier
            mimic_offset[row] = mimic.offset
    anchors = _anchors(model, robot)
    return ReducedRobot(
        model,
        joints,
        followed_limits(robot.limits, joints, robot.mimics),
        readonly(mimic_matrix),
        readonly(mimic_offset),
        anchors,
        tuple(
            FixedBody(body.name, body.owner, at.joint, at.placement * body.placement, body.shape)
            for body in robot.bodies
            for at in (anchors[body.frame],)
        ),
    )


def _anchors(model: pin.Model, robot: Robot) -> Mapping[str, Anchor]:
    anchors = {WORLD: WORLD_ANCHOR}
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            where = frame.placement
            anchors[frame.name] = Anchor(
                int(frame.parentJoint),
                Placement(readonly(where.rotation.copy()), readonly(where.translation.copy())),
            )
    for name, frame in robot.frames.items():
        link = anchors[frame.link]
        anchors[name] = Anchor(link.joint, link.placement * frame.placement)
    return anchors
