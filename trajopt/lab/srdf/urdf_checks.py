"""Suspicious parts of a URDF: units, inertias, limits, shapes, mimics."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from trajopt.robot.joints import joint_unit
from trajopt.robot.loading.mimics import followed_limits
from trajopt.robot.loading.pinocchio_model import ENDLESS
from trajopt.robot.robot import Robot
from trajopt.values.arrays import Floats
from trajopt.values.errors import MeshFileError, MimicOutOfRange, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import Shape, placed_box

LARGE = 5.0
"""A link or an offset between links larger than this looks like millimetres [m]."""
WIDE = 8.0 * np.pi + 1e-3
"""A wider range of a turning joint looks like degrees [rad]; wrists may turn by 400 degrees each way."""
MISMATCH = 1.5
"""Visual and collision shapes differ if one is larger along an axis by this factor and more than `SLACK`."""
SLACK = 0.03
"""See `MISMATCH` [m]."""


class Severity(Enum):
    """How bad a finding is: it makes motions wrong, it may do so, or it is for information."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True)
class Finding:
    """An oddity of a URDF."""

    severity: Severity
    subject: str
    problem: str

    def as_dict(self) -> dict[str, str]:
        """Return plain data."""
        return {"severity": self.severity.value, "subject": self.subject, "problem": self.problem}

    def __str__(self) -> str:
        return f"{self.severity.value}: {self.subject}: {self.problem}"


@checked
def check_urdf(robot: Robot) -> tuple[Finding, ...]:
    """Search a robot's description for suspicious parts, errors first.

    For a robot from a Pinocchio model, without a URDF, the model's inertias and limits are checked.
    """
    if robot.urdf_path == Path():
        described = _model(robot)
    else:
        root = ElementTree.fromstring(robot.urdf_xml)
        described = (*_inertias(root, robot), *_joints(root))
    found = [*described, *_mimics(robot), *_shapes(robot)]
    order = list(Severity)
    return tuple(sorted(found, key=lambda finding: order.index(finding.severity)))


def _model(robot: Robot) -> Iterator[Finding]:
    model, limits = robot.model, robot.limits
    yield Finding(Severity.NOTE, robot.name, "was made from a Pinocchio model: there is no URDF to check")
    for name, inertia in zip(list(model.names)[1:], list(model.inertias)[1:], strict=True):
        if inertia.mass == 0.0:
            yield Finding(Severity.WARNING, name, "carries no mass: torques leave it out")
        yield from _moments(name, np.asarray(inertia.inertia))
    for joint, name in enumerate(robot.joint_names):
        lower, upper = float(limits.lower[joint]), float(limits.upper[joint])
        slides = joint_unit(model, name) == "m"
        kind = "prismatic" if slides else "revolute" if np.isfinite(lower) else "continuous"
        rates = {"velocity": float(limits.velocity[joint]), "effort": float(limits.effort[joint])}
        yield from _limit(name, kind, lower, upper, rates)


def _inertias(root: ElementTree.Element, robot: Robot) -> Iterator[Finding]:
    shaped = {element.owner for element in robot.bodies} | {element.link for element in robot.visuals}
    moved = {child.get("link", "") for child in root.iterfind("joint[@type!='fixed']/child")}
    for link in root.findall("link"):
        name, inertial = link.get("name", ""), link.find("inertial")
        if inertial is None:
            if name in moved:
                yield Finding(Severity.WARNING, name, "moves and has no <inertial>: torques leave it out")
            continue
        mass = _number(inertial.find("mass"), "value")
        if mass == 0.0 and name in shaped:
            yield Finding(Severity.WARNING, name, "has shapes and a mass of zero")
        entries = {
            key: _number(inertial.find("inertia"), key) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        }
        matrix = np.array(
            [
                [entries["ixx"], entries["ixy"], entries["ixz"]],
                [entries["ixy"], entries["iyy"], entries["iyz"]],
                [entries["ixz"], entries["iyz"], entries["izz"]],
            ]
        )
        yield from _moments(name, matrix)


def _moments(name: str, inertia: Floats) -> Iterator[Finding]:
    """Source: principal moments are integrals, e.g. ixx + iyy - izz = 2 int z^2 dm >= 0."""
    moments = np.asarray(np.linalg.eigvalsh(inertia), dtype=np.float64)
    shown = ", ".join(f"{moment:.3g}" for moment in moments.tolist())
    slack = 1e-3 * max(float(np.abs(moments).max()), 1e-12)
    if moments[0] < -slack:
        yield Finding(Severity.ERROR, name, f"has a negative moment of inertia ({shown} kg m^2)")
    elif moments[0] + moments[1] < moments[2] - slack:
        yield Finding(
            Severity.ERROR,
            name,
            f"has moments of inertia that no body has ({shown} kg m^2): two are less than the third",
        )


def _joints(root: ElementTree.Element) -> Iterator[Finding]:
    for joint in root.findall("joint"):
        name, kind, limit = joint.get("name", ""), joint.get("type", ""), joint.find("limit")
        origin = joint.find("origin")
        offset = _vector(origin, "xyz") if origin is not None else np.zeros(3)
        if float(np.linalg.norm(offset)) > LARGE:
            yield Finding(
                Severity.ERROR,
                name,
                f"is {np.linalg.norm(offset):g} m from its parent: millimetres, meant as metres?",
            )
        if kind == "fixed":
            continue
        axis = joint.find("axis")
        if axis is not None and abs(float(np.linalg.norm(_vector(axis, "xyz"))) - 1.0) > 1e-3:
            yield Finding(Severity.WARNING, name, f"has an axis that is not a unit vector: {axis.get('xyz')}")
        if kind == "continuous":
            yield Finding(Severity.NOTE, name, "is continuous: it turns without limits")
        if limit is None:
            yield Finding(
                Severity.ERROR if kind != "continuous" else Severity.WARNING, name, "has no <limit>"
            )
            continue
        rates = {key: _number(limit, key) for key in ("velocity", "effort")}
        yield from _limit(name, kind, _number(limit, "lower"), _number(limit, "upper"), rates)


def _limit(name: str, kind: str, lower: float, upper: float, rates: Mapping[str, float]) -> Iterator[Finding]:
    if kind != "continuous":
        if lower == upper:
            yield Finding(Severity.ERROR, name, f"cannot move: both limits are {lower:g}")
        elif lower <= -ENDLESS and upper >= ENDLESS:
            yield Finding(Severity.NOTE, name, f"moves from {lower:g} to {upper:g}: without limits")
        elif kind == "revolute" and upper - lower > WIDE:
            yield Finding(
                Severity.WARNING, name, f"turns from {lower:g} to {upper:g} rad: degrees, meant as radians?"
            )
        elif kind == "prismatic" and upper - lower > LARGE:
            yield Finding(
                Severity.WARNING, name, f"slides by {upper - lower:g} m: millimetres, meant as metres?"
            )
    for key, rate in rates.items():
        if rate <= 0.0:
            yield Finding(Severity.WARNING, name, f"has no limit, or one of zero, on its {key}")


def _mimics(robot: Robot) -> Iterator[Finding]:
    ranges = {
        name: (lower, upper)
        for name, lower, upper in zip(
            robot.joint_names, robot.limits.lower.tolist(), robot.limits.upper.tolist(), strict=True
        )
    }
    try:
        leaders = tuple(name for name in robot.joint_names if name not in robot.mimics)
        followed_limits(robot.limits, leaders, robot.mimics)
    except MimicOutOfRange as error:
        yield Finding(Severity.ERROR, error.joint, f"{error}: no motion of {error.source} can be planned")
    for name, mimic in robot.mimics.items():
        if mimic.source not in ranges:
            yield Finding(
                Severity.ERROR, name, f"follows {shown(mimic.source)}, which is not a joint that moves"
            )
            continue
        ends = [mimic.multiplier * end + mimic.offset for end in ranges[mimic.source]]
        lower, upper = ranges[name]
        if min(ends) < lower - 1e-3 or max(ends) > upper + 1e-3:
            yield Finding(
                Severity.WARNING,
                name,
                f"follows {mimic.source} to [{min(ends):.3g}, {max(ends):.3g}], beyond its own range "
                f"[{lower:.3g}, {upper:.3g}]",
            )


def _shapes(robot: Robot) -> Iterator[Finding]:
    solid = _boxes([(body.owner, body.placement, body.shape) for body in robot.bodies])
    seen: list[tuple[str, Placement, Shape]] = []
    for visual in robot.visuals:
        try:
            seen.append((visual.link, visual.placement, visual.shape))
        except MeshFileError as error:
            yield Finding(Severity.WARNING, visual.link, f"has a visual mesh that cannot be read: {error}")
    shown = _boxes(seen)
    for link in robot.links:
        if link in shown and link not in solid:
            yield Finding(
                Severity.WARNING, link, "is visible but has no collision shape: nothing keeps clear of it"
            )
        if link in solid:
            size = solid[link][1] - solid[link][0]
            if size.max() > LARGE:
                yield Finding(
                    Severity.ERROR,
                    link,
                    f"has a collision shape of {size.max():.3g} m: millimetres, meant as metres?",
                )
            elif link in shown:
                yield from _mismatch(link, solid[link], shown[link])


def _mismatch(link: str, solid: Floats, shown: Floats) -> Iterator[Finding]:
    sizes = [box[1] - box[0] for box in (solid, shown)]
    bad = (np.maximum(*sizes) > MISMATCH * np.minimum(*sizes)) & (np.abs(sizes[0] - sizes[1]) > SLACK)
    if bad.any():
        one, other = (" x ".join(f"{1000.0 * edge:.0f}" for edge in size.tolist()) for size in sizes)
        yield Finding(
            Severity.WARNING,
            link,
            f"collision shapes fill a box of {one} mm, visual shapes one of {other} mm",
        )
    elif (np.abs(solid.mean(axis=0) - shown.mean(axis=0)) > np.maximum(0.5 * sizes[1], SLACK)).any():
        yield Finding(Severity.WARNING, link, "collision shapes are displaced from the visual shapes")


def _boxes(shapes: list[tuple[str, Placement, Shape]]) -> dict[str, Floats]:
    found: dict[str, Floats] = {}
    for link, where, shape in shapes:
        box = placed_box(shape, where)
        if link in found:
            box = np.stack((np.minimum(box[0], found[link][0]), np.maximum(box[1], found[link][1])))
        found[link] = box
    return found


def _number(element: ElementTree.Element | None, key: str) -> float:
    return float(element.get(key, "0")) if element is not None else 0.0


def _vector(element: ElementTree.Element, key: str) -> Floats:
    return np.array([float(word) for word in element.get(key, "0 0 0").split()])
