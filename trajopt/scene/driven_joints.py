"""Driven joints: tracks as joints that time drives, so that what moves by itself is carried like a link.

The origin slides along the world's three axes, then the frame turns about the axis of each piece: within a
piece by its rate, before it not at all, after it by as much as the piece turned.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.robot.bodies import Anchor
from trajopt.scene.track import STEADY, Track
from trajopt.values.arrays import Floats, Value, readonly
from trajopt.values.piecewise import refined
from trajopt.values.placement import Placement


@dataclass(frozen=True, eq=False)
class DrivenJoints(Value):
    """Positions of joints that time drives.

    Attributes:
        names: Names of the m joints.
        times: Ends of the k pieces, increasing, shape (k + 1,) [s]; before and after them all rest.
        coefficients: Of the joints' positions, by the time since the start of each piece, highest power
            first, shape (degree + 1, k, m) [rad | m].
    """

    names: tuple[str, ...]
    times: Floats
    coefficients: Floats

    def at(self, times: Floats) -> Floats:
        """Return the positions at times (s,), shape (s, m) [rad | m]."""
        moments = np.clip(times, self.times[0], self.times[-1])
        piece = np.clip(np.searchsorted(self.times, moments, side="right") - 1, 0, len(self.times) - 2)
        since = (moments - self.times[piece])[:, None]
        value = self.coefficients[0, piece]
        for row in self.coefficients[1:]:
            value = value * since + row[piece]
        return value


@dataclass(frozen=True, eq=False)
class Drive:
    """Joints that were added to a model, and what they carry.

    Attributes:
        joints: Their positions.
        anchors: The frame that each track moves, by its name.
    """

    joints: DrivenJoints
    anchors: Mapping[str, Anchor]


def add_driven(model: pin.Model, tracks: Mapping[str, Track]) -> Drive:
    """Add joints to a model that move frames along tracks.

    Args:
        model: Changed: it gets the joints, after its own.
        tracks: The frames' tracks, by name.
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
    return Drive(_joined(tuple(names), moved), anchors)


def _turns(track: Track) -> list[tuple[int, Floats]]:
    """Return the pieces in which a track turns, each with its angle in all pieces, (2, k): rate and start."""
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
    """Return the coefficients of all joints of a track side by side, of the highest degree of any."""
    columns = [slides, *(angle[:, :, None] for angle in angles)]
    degree = max(len(column) for column in columns)
    return np.concatenate([np.pad(c, ((degree - len(c), 0), (0, 0), (0, 0))) for c in columns], axis=2)


def _joined(names: tuple[str, ...], moved: list[tuple[Floats, Floats]]) -> DrivenJoints:
    """Return all tracks' joints over the same pieces."""
    if not moved:
        return DrivenJoints(names, readonly(np.array((0.0, 1.0))), readonly(np.zeros((1, 1, 0))))
    times = np.unique(np.concatenate([track_times for track_times, _ in moved]))
    degree = max(len(coefficients) for _, coefficients in moved)
    columns = [refined(times, *each, degree) for each in moved]
    return DrivenJoints(names, readonly(times), readonly(np.concatenate(columns, axis=2)))
