"""Factory calibration of an arm of Universal Robots.

Parameters are Denavit and Hartenberg's: frame i + 1 is Rz(q + theta) Tz(d) Tx(a) Rx(alpha) in frame i.

Source:
https://www.universal-robots.com/articles/ur/application-installation/dh-parameters-for-calculations-of-kinematics-and-dynamics.
"""

import re
from dataclasses import dataclass
from math import atan2, sin
from pathlib import Path
from typing import TypeAlias, cast
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from trajopt.robot.loading.pinocchio_model import link_names
from trajopt.values.arrays import Floats, readonly
from trajopt.values.documents.document import Node, read_document
from trajopt.values.documents.files import read_text
from trajopt.values.errors import FileFormatError, FrameNotFound, JointNotFound, ModelError, listed, shown
from trajopt.values.placement import IDENTITY, Placement, from_rpy, placement

LINKS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
JOINTS = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
)
FLANGE = "tool0"
TWISTS = np.deg2rad((90.0, 0.0, 0.0, 90.0, -90.0, 0.0))
"""Nominal alpha of an arm of Universal Robots [rad]."""
LARGEST_SHIFT = 0.05
"""Largest shift of a joint by a calibration [m]; a larger one belongs to another type of arm."""
_EXACT = 1e-4
"""Accepted deviation of a model from the nominal structure [m | rad]."""
_NUMBERS = ("x", "y", "z", "roll", "pitch", "yaw")
_DELTA = re.compile(r"^[ \t]*delta_(theta|d|a|alpha)[ \t]*=[ \t]*\[([^\]\n]*)\]", re.MULTILINE)
Chain: TypeAlias = tuple[Placement, ...]
"""Frames of six joints, each in the frame of the joint before it; z is the axis."""


@dataclass(frozen=True)
class Parameters:
    """Denavit and Hartenberg's parameters, each of shape (6,) [rad | m]."""

    theta: Floats
    d: Floats
    a: Floats
    alpha: Floats

    def chain(self) -> Chain:
        """Return the frames of the joints; a and alpha of the last one are zero."""
        passive = [IDENTITY]
        for a, alpha in zip(self.a, self.alpha, strict=True):
            passive.append(placement((a, 0.0, 0.0)) * _turned(roll=alpha))
        return tuple(
            before * _turned(yaw=theta) * placement((0.0, 0.0, d))
            for before, theta, d in zip(passive[:-1], self.theta, self.d, strict=True)
        )


class Arm:
    """An arm in its model at zero positions; placements are in the world.

    Attributes:
        base: Base frame of the controller.
        frames: Frames of the joints by the nominal parameters.
    """

    def __init__(self, model: pin.Model, prefix: str) -> None:
        self.joints = tuple(prefix + name for name in JOINTS)
        for joint in self.joints:
            if joint not in list(model.names)[1:]:
                raise JointNotFound("joint of the calibrated arm", joint, list(model.names)[1:])
        if prefix + FLANGE not in link_names(model):
            raise FrameNotFound("flange of the calibrated arm", prefix + FLANGE, link_names(model))
        self._model, self._data = model, model.createData()
        self._ids = [int(model.getJointId(joint)) for joint in self.joints]
        pin.framesForwardKinematics(model, self._data, pin.neutral(model))
        self._placed = [_placement(self._data.oMi[joint]) for joint in self._ids]
        flange = self._data.oMf[model.getFrameId(prefix + FLANGE, pin.FrameType.BODY)]
        points = [*(each.translation for each in self._placed), flange.translation]
        axes = np.array([self._axis(place) for place in range(6)])
        y = -axes[1]
        base = np.column_stack((np.cross(y, axes[0]), y, axes[0]))
        self.base = Placement(readonly(base), self._parent(0).translation)
        self.nominal = _parameters(self.base, axes, points)
        self.frames = _cumulated(self.base, self.nominal.chain())
        self._check(axes, points)

    def _axis(self, place: int) -> Floats:
        joint = self._model.joints[self._ids[place]]
        data = joint.createData()
        joint.calc(data, pin.neutral(self._model))
        return self._placed[place].rotation @ data.S.ravel()[3:]

    def _parent(self, place: int) -> Placement:
        joint = self._model.getFrameId(self.joints[place], pin.FrameType.JOINT)
        return _placement(self._data.oMf[self._model.frames[joint].parentFrame])

    def _check(self, axes: Floats, points: list[Floats]) -> None:
        away = [
            np.abs((frame.inverse() * point)[:2]).max() + np.abs(frame.rotation[:, 2] - axis).max()
            for frame, point, axis in zip(
                (*self.frames, self.frames[-1]), points, (*axes, axes[-1]), strict=True
            )
        ]
        twisted = np.abs(self.nominal.alpha - TWISTS).max()
        chained = all(self._model.parents[self._ids[place + 1]] == self._ids[place] for place in range(5))
        if not chained or not max(*away, twisted) <= _EXACT:
            raise ModelError(
                f"joints {listed(self.joints)} do not have the axes of an arm of Universal Robots, so no "
                "calibration of such an arm applies to them"
            )

    def corrections(self, chain: Chain) -> Chain:
        """Return the displacements of the joints by a calibrated chain.

        A joint's frame is free along and about its axis (but for the last, which carries the flange): each
        stays nearest to its nominal frame.
        """
        found = _cumulated(self.base, chain)
        kept = [_nearest(frame, nominal) for frame, nominal in zip(found[:-1], self.frames[:-1], strict=True)]
        pairs = zip((*kept, found[-1]), self.frames, strict=True)
        return tuple(frame * nominal.inverse() for frame, nominal in pairs)

    def model_with(self, corrections: Chain) -> pin.Model:
        model, above = self._model.copy(), IDENTITY
        for joint, placed, correction in zip(self._ids, self._placed, corrections, strict=True):
            parent = above * _placement(self._data.oMi[model.parents[joint]])
            there = parent.inverse() * (correction * placed)
            model.jointPlacements[joint] = pin.SE3(there.rotation, there.translation)
            above = correction
        return model

    def description_with(self, xml: str, corrections: Chain) -> str:
        root, above = ElementTree.fromstring(xml), IDENTITY
        written = {joint.get("name"): joint for joint in root.findall("joint")}
        for place, (name, correction) in enumerate(zip(self.joints, corrections, strict=True)):
            if name in written:
                parent = above * self._parent(place)
                _set_origin(written[name], parent.inverse() * (correction * self._placed[place]))
            above = correction
        return ElementTree.tostring(root, encoding="unicode")


def _parameters(base: Placement, axes: Floats, points: list[Floats]) -> Parameters:
    """Return the parameters of joints by their axes (6, 3) and points on them, the flange's at the end.

    All x axes are parallel at zero positions, and d is 0 between parallel axes.
    """
    x, origin = base.rotation[:, 0], base.translation
    d, a, alpha = np.zeros(6), np.zeros(6), np.zeros(6)
    for place, axis in enumerate(axes):
        ahead, following = points[place + 1] - origin, axes[min(place + 1, 5)]
        alpha[place] = atan2(x @ np.cross(axis, following), axis @ following)
        if place == 5:
            d[place] = ahead @ axis
        elif abs(sin(alpha[place])) < _EXACT:
            a[place] = ahead @ x
        else:
            columns = np.column_stack((axis, x, following))
            d[place], a[place], _ = np.linalg.lstsq(columns, ahead)[0]
        origin = origin + d[place] * axis + a[place] * x
    return Parameters(np.zeros(6), d, a, alpha)


def _cumulated(base: Placement, chain: Chain) -> Chain:
    found = [base]
    for frame in chain:
        found.append(found[-1] * frame)
    return tuple(found[1:])


def _nearest(frame: Placement, nominal: Placement) -> Placement:
    away = frame.inverse() * nominal
    angle = atan2(away.rotation[1, 0], away.rotation[0, 0])
    return frame * placement((0.0, 0.0, away.translation[2])) * _turned(yaw=angle)


def _turned(roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> Placement:
    return Placement(readonly(from_rpy(roll, pitch, yaw)))


def _placement(found: pin.SE3) -> Placement:
    return Placement(readonly(found.rotation.copy()), readonly(found.translation.copy()))


def _set_origin(joint: ElementTree.Element, there: Placement) -> None:
    origin = joint.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    origin.set("xyz", " ".join(map(repr, there.translation.tolist())))
    origin.set("rpy", " ".join(map(repr, there.rpy)))


def calibrated(model: pin.Model, xml: str, file: Path, prefix: str) -> tuple[pin.Model, str, str]:
    """Return the model and the URDF text with the calibration of a file, and a sentence about it."""
    arm = Arm(model, prefix)
    chain = _read_deltas(file, arm.nominal) if file.suffix == ".conf" else _read_kinematics(file)
    corrections = arm.corrections(chain)
    moved = [
        1e3 * float(np.linalg.norm(correction * frame.translation - frame.translation))
        for frame, correction in zip(arm.frames, corrections, strict=True)
    ]
    if max(moved) > 1e3 * LARGEST_SHIFT:
        far = f"{arm.joints[int(np.argmax(moved))]} by {max(moved):.0f} mm"
        raise FileFormatError(str(file), f"moves {far}: it belongs to another type of arm")
    note = f"joints are calibrated by {file.name}, which moves {prefix + FLANGE} by {moved[-1]:.2f} mm"
    return arm.model_with(corrections), arm.description_with(xml, corrections), f"{note} at zero positions"


def _read_deltas(file: Path, nominal: Parameters) -> Chain:
    found = dict[str, Floats]()
    for name, text in cast("list[tuple[str, str]]", _DELTA.findall(read_text(file))):
        if name in found:
            raise FileFormatError(str(file), f"delta_{name} is there twice")
        try:
            values = np.array([float(part) for part in text.split(",")])
        except ValueError:
            values = np.zeros(0)
        if len(values) != 6 or not np.isfinite(values).all():
            raise FileFormatError(str(file), f"delta_{name} must be six finite numbers, is {shown(text)}")
        found[name] = values
    if missing := [f"delta_{name}" for name in ("theta", "d", "a", "alpha") if name not in found]:
        raise FileFormatError(str(file), f"is not a calibration: it lacks {listed(missing)}")
    for name in ("a", "alpha"):
        if last := found[name][5]:
            raise FileFormatError(str(file), f"delta_{name} of the last joint is {last:g}, must be 0")
    return Parameters(
        nominal.theta + found["theta"],
        nominal.d + found["d"],
        nominal.a + found["a"],
        nominal.alpha + found["alpha"],
    ).chain()


def _read_kinematics(file: Path) -> Chain:
    links = read_document(file)["kinematics"]
    return tuple(_frame(links[name]) for name in LINKS)


def _frame(link: Node) -> Placement:
    *xyz, roll, pitch, yaw = (link[name].number() for name in _NUMBERS)
    # ur_calibration writes the angles of Rx Ry Rz; a URDF's rpy is Rz Ry Rx.
    return placement(xyz) * _turned(roll=roll) * _turned(pitch=pitch) * _turned(yaw=yaw)
