"""Robots as the check reads them: its own reader of URDF, its own products of placements."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree

import coal
import numpy as np
import yaml

from tests.fuzz.random_problems.shapes import Body, box, cylinder, sphere
from trajopt.values.arrays import Floats


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint of the URDF; `kind` is "fixed", "revolute", "continuous" or "prismatic"."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Floats
    axis: Floats
    lower: float
    upper: float
    velocity: float
    mimic: tuple[str, float, float] | None


@dataclass(frozen=True, eq=False)
class Placed:
    """A body on a link (or "world"), with the name of the link or object that owns it."""

    owner: str
    link: str
    place: Floats
    body: Body


@dataclass(frozen=True, eq=False)
class Chain:
    """A robot with some joints driven: what moves, how far, and what is on its links.

    Attributes:
        joints: From the root outward.
        root: The root link.
        driven: Joints that a motion moves, in its order.
        still: Where the other joints stand that follow none [rad | m].
        acceleration: Largest accelerations [rad/s^2 | m/s^2], by joint.
        bodies: Collision bodies of the links.
        excused: Pairs of links that may touch.
    """

    joints: tuple[Joint, ...]
    root: str
    driven: tuple[str, ...]
    still: Mapping[str, float]
    acceleration: Mapping[str, float]
    bodies: tuple[Placed, ...]
    excused: frozenset[frozenset[str]]
    velocity: Mapping[str, float]

    @cached_property
    def moving(self) -> tuple[Joint, ...]:
        """Joints that can move at all, driven or not."""
        return tuple(joint for joint in self.joints if joint.kind != "fixed")

    @cached_property
    def follows(self) -> tuple[Floats, Floats]:
        """All movable joints as an affine map of the driven ones: matrix (m, n) and offset (m,)."""
        by_name = {joint.name: joint for joint in self.moving}
        matrix, offset = np.zeros((len(by_name), len(self.driven))), np.zeros(len(by_name))
        for row, joint in enumerate(self.moving):
            factor, shift, at, steps = 1.0, 0.0, joint, 0
            while at.mimic is not None:
                source, multiplier, more = at.mimic
                shift, factor, at, steps = (
                    shift + factor * more,
                    factor * multiplier,
                    by_name[source],
                    steps + 1,
                )
                assert steps <= len(by_name), "a circle of mimics"
            if at.name in self.driven:
                matrix[row, self.driven.index(at.name)] = factor
                offset[row] = shift
            else:
                offset[row] = (
                    factor * self.still.get(at.name, float(np.clip(0.0, at.lower, at.upper))) + shift
                )
        return matrix, offset

    def all_joints(self, positions: Floats) -> Floats:
        """Positions of all movable joints for the driven ones, shape (t, n) -> (t, m)."""
        matrix, offset = self.follows
        return positions @ matrix.T + offset

    def excess_of_limits(self, positions: Floats) -> float:
        """By how much any joint, followers too, is beyond its position limits at worst."""
        values = self.all_joints(positions)
        low = np.array([joint.lower for joint in self.moving])
        high = np.array([joint.upper for joint in self.moving])
        concerned = np.abs(self.follows[0]).sum(axis=1) > 0
        return float(np.maximum(low - values, values - high)[:, concerned].max())

    def places(self, positions: Floats) -> dict[str, Floats]:
        """Placements of all links, shape (t, 4, 4) each, for positions (t, n)."""
        values, count = self.all_joints(positions), len(positions)
        places = {
            self.root: np.broadcast_to(np.eye(4), (count, 4, 4)),
            "world": np.broadcast_to(np.eye(4), (count, 4, 4)),
        }
        row = {joint.name: place for place, joint in enumerate(self.moving)}
        for joint in self.joints:
            place = places[joint.parent] @ joint.origin
            if joint.kind != "fixed":
                place = place @ _moved(joint, values[:, row[joint.name]])
            places[joint.child] = place
        return places

    def lever(self, bodies: tuple[Placed, ...]) -> Floats:
        """How far a point moves at most when a driven joint moves by one, shape (n,) [m]."""
        reach = {joint.child: 0.0 for joint in self.joints} | {self.root: 0.0}
        for item in bodies:
            if item.link != "world":
                far = float(np.linalg.norm(item.place[:3, 3])) + item.body.radius
                reach[item.link] = max(reach[item.link], far)
        lever = np.zeros(len(self.moving))
        row = {joint.name: place for place, joint in enumerate(self.moving)}
        for joint in reversed(self.joints):
            slid = max(abs(joint.lower), abs(joint.upper)) if joint.kind == "prismatic" else 0.0
            if joint.kind != "fixed":
                lever[row[joint.name]] = 1.0 if joint.kind == "prismatic" else reach[joint.child]
            far = float(np.linalg.norm(joint.origin[:3, 3])) + slid + reach[joint.child]
            reach[joint.parent] = max(reach[joint.parent], far)
        return np.abs(self.follows[0]).T @ lever

    @cached_property
    def rigid(self) -> Mapping[str, str]:
        """Link -> the link nearest the root that it cannot move against."""
        moves = np.abs(self.follows[0]).sum(axis=1) > 0
        still = {joint.name for joint, moving in zip(self.moving, moves, strict=True) if not moving}
        found = {self.root: "world", "world": "world"}
        for joint in self.joints:
            fixed = joint.kind == "fixed" or joint.name in still
            found[joint.child] = found[joint.parent] if fixed else joint.child
        return found

    def limits(self) -> tuple[Floats, Floats]:
        """Velocity and acceleration limits of all movable joints, shape (m,)."""
        speed = np.array([self.velocity.get(joint.name, joint.velocity) for joint in self.moving])
        return speed, np.array([self.acceleration.get(joint.name, np.inf) for joint in self.moving])

    def bounds(self) -> tuple[Floats, Floats]:
        """Position limits of the driven joints, shape (n,); half a turn to each side where there are none."""
        by_name = {joint.name: joint for joint in self.moving}
        low = np.array([by_name[name].lower for name in self.driven])
        high = np.array([by_name[name].upper for name in self.driven])
        return np.maximum(low, -np.pi), np.minimum(high, np.pi)


def read_chain(
    text: str,
    *,
    driven: tuple[str, ...] | None = None,
    srdf: str = "",
    limits: str = "",
    still: Mapping[str, float] | None = None,
    packages: Path | Mapping[str, Body] | None = None,
) -> Chain:
    """Read a robot of its URDF; the driven joints are all that follow none where none are given.

    `packages` is the folder with its meshes, or the meshes themselves by name.
    """
    root = ElementTree.fromstring(text)
    joints = _outward([_joint(element) for element in root.findall("joint")])
    children = {joint.child for joint in joints}
    base = next(link.get("name", "") for link in root.findall("link") if link.get("name") not in children)
    stated = yaml.safe_load(limits)["joint_limits"] if limits else {}
    bodies = tuple(
        Placed(link.get("name", ""), link.get("name", ""), _origin(item), _body(item, packages))
        for link in root.findall("link")
        for item in link.findall("collision")
    )
    if driven is None:
        driven = tuple(joint.name for joint in joints if joint.kind != "fixed" and joint.mimic is None)
    return Chain(
        joints, base, driven, still or {},
        _stated(stated, "max_acceleration"),
        bodies, _excused(joints, base, srdf),
        _stated(stated, "max_velocity"),
    )  # fmt: skip


def _stated(limits: Mapping[str, Mapping[str, float]], what: str) -> dict[str, float]:
    return {name: float(entry[what]) for name, entry in limits.items() if what in entry}


def _outward(joints: list[Joint]) -> tuple[Joint, ...]:
    reached, ordered = {joint.parent for joint in joints} - {joint.child for joint in joints}, list[Joint]()
    while len(ordered) < len(joints):
        ready = [joint for joint in joints if joint.parent in reached and joint.child not in reached]
        assert ready, "links that hang on nothing"
        ordered += ready
        reached |= {joint.child for joint in ready}
    return tuple(ordered)


def _joint(element: ElementTree.Element) -> Joint:
    def end(name: str) -> str:
        found = element.find(name)
        assert found is not None
        return found.get("link", "")

    kind, limit, mimic = element.get("type", ""), element.find("limit"), element.find("mimic")
    axis, stated = np.array((1.0, 0.0, 0.0)), element.find("axis")
    if stated is not None:
        axis = _numbers(stated.get("xyz", "1 0 0"))
    bounded = limit is not None and kind in ("revolute", "prismatic")
    return Joint(
        element.get("name", ""), kind, end("parent"), end("child"), _origin(element),
        axis / np.linalg.norm(axis),
        float(limit.get("lower", 0.0)) if bounded else -np.inf,
        float(limit.get("upper", 0.0)) if bounded else np.inf,
        np.inf if limit is None else float(limit.get("velocity", np.inf)),
        None if mimic is None else (
            mimic.get("joint", ""), float(mimic.get("multiplier", 1.0)), float(mimic.get("offset", 0.0))
        ),
    )  # fmt: skip


def _numbers(text: str) -> Floats:
    return np.array([float(word) for word in text.split()])


def _origin(element: ElementTree.Element) -> Floats:
    origin, place = element.find("origin"), np.eye(4)
    if origin is not None:
        place[:3, :3] = turned(*_numbers(origin.get("rpy", "0 0 0")))
        place[:3, 3] = _numbers(origin.get("xyz", "0 0 0"))
    return place


def turned(roll: float, pitch: float, yaw: float) -> Floats:
    """Rotation of roll, then pitch, then yaw about the fixed axes."""
    (cr, cp, cy), (sr, sp, sy) = np.cos((roll, pitch, yaw)), np.sin((roll, pitch, yaw))
    about_x = np.array(((1, 0, 0), (0, cr, -sr), (0, sr, cr)))
    about_y = np.array(((cp, 0, sp), (0, 1, 0), (-sp, 0, cp)))
    about_z = np.array(((cy, -sy, 0), (sy, cy, 0), (0, 0, 1)))
    return about_z @ about_y @ about_x


def _moved(joint: Joint, values: Floats) -> Floats:
    """Placements of a joint at its values, shape (t, 4, 4)."""
    place = np.tile(np.eye(4), (len(values), 1, 1))
    if joint.kind == "prismatic":
        place[:, :3, 3] = values[:, None] * joint.axis
        return place
    x, y, z = joint.axis
    cross = np.array(((0, -z, y), (z, 0, -x), (-y, x, 0)))
    sine, cosine = np.sin(values)[:, None, None], np.cos(values)[:, None, None]
    place[:, :3, :3] = np.eye(3) + sine * cross + (1.0 - cosine) * (cross @ cross)
    return place


def _body(element: ElementTree.Element, packages: Path | Mapping[str, Body] | None) -> Body:
    shape = element.find("geometry")
    assert shape is not None
    shape = shape[0]
    if shape.tag == "box":
        return box(*_numbers(shape.get("size", "")))
    if shape.tag == "sphere":
        return sphere(float(shape.get("radius", "")))
    if shape.tag == "cylinder":
        return cylinder(float(shape.get("radius", "")), float(shape.get("length", "")))
    assert shape.tag == "mesh" and packages is not None
    if not isinstance(packages, Path):
        return packages[shape.get("filename", "")]
    scale = _numbers(shape.get("scale", "1 1 1"))
    model = coal.MeshLoader().load(
        str(packages / shape.get("filename", "").removeprefix("package://")), scale
    )
    corners = (model.tri_indices(place) for place in range(model.num_tris))
    faces = np.array([(corner[0], corner[1], corner[2]) for corner in corners])
    return Body("mesh", (), np.array(model.vertices()), faces, False)


def _excused(joints: tuple[Joint, ...], base: str, srdf: str) -> frozenset[frozenset[str]]:
    """Links that adjoin, that are fixed to each other, or that the SRDF lets touch."""
    pairs = {frozenset((joint.parent, joint.child)) for joint in joints}
    welded = {base: base}
    for joint in joints:
        welded[joint.child] = welded[joint.parent] if joint.kind == "fixed" else joint.child
    pairs |= {frozenset((a, b)) for a in welded for b in welded if a != b and welded[a] == welded[b]}
    if srdf:
        for item in ElementTree.fromstring(srdf).findall("disable_collisions"):
            pairs.add(frozenset((item.get("link1", ""), item.get("link2", ""))))
    return frozenset(pairs)
