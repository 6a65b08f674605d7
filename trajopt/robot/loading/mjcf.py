"""MJCF: MuJoCo's files, compiled by MuJoCo and converted to a URDF."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations, product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from trajopt.robot.loading.groups import ALL_JOINTS
from trajopt.robot.loading.srdf import Srdf
from trajopt.robot.loading.urdf import LinkGeometry, Mimic, Urdf, check_count
from trajopt.values.arrays import Floats, readonly
from trajopt.values.documents.files import read_bytes
from trajopt.values.errors import FileFormatError, ModelError, UnsupportedJoint, listed, shown
from trajopt.values.placement import Placement, as_rpy, from_quaternion
from trajopt.values.processes import ProcessRefused, answer_of
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cylinder, Plane, Shape, Sphere, convex

FREE, BALL, SLIDE, HINGE = range(4)  # numbers of MuJoCo's mjtJoint
_JOINT_EQUALITY = 2  # of mjtEq
_JOINT_TRANSMISSIONS, _TENDON_TRANSMISSION, _WRAPPED_JOINT = (0, 1), 3, 1  # of mjtTrn and mjtWrap
_WORLD = "world"
_NUMBERS = {
    "body": ("body_pos", "body_quat", "body_mass", "body_ipos", "body_iquat", "body_inertia"),
    "joint": ("jnt_pos", "jnt_axis", "jnt_range"),
    "geom": ("geom_pos", "geom_quat", "geom_size"),
    "actuator": ("actuator_forcerange", "actuator_ctrlrange", "actuator_gear"),
    "key": ("key_qpos",),
}
_CHILD, _COMPILED = Path(__file__).with_name("mjcf_child.py"), "compiled.mjb"
LONGEST_SLIDE = 100.0
"""Half the range of a slide without limits [m]: more than the travel of any arm, gantry or base."""
_EXACT = 1e-12  # anchors this near the body's origin are in it [m]
_EARTH = (0.0, 0.0, -9.81)


def read_mjcf(path: Path) -> tuple[Urdf, Srdf]:
    """Read a MuJoCo model as a description: bodies become links, named key frames states.

    Bodies fixed to the world are part of the robot: each geom of the world becomes a link.
    """
    model, warnings = _compiled(path)
    said = [f"MuJoCo warns: {' '.join(warning.split())}" for warning in dict.fromkeys(warnings)]
    return _Reading(path, model, notes=said).read()


def _compiled(path: Path) -> tuple[Any, list[str]]:
    from trajopt.robot.loading.mujoco_library import mujoco  # slow to import

    # Before MuJoCo reads it: for ten thousand bodies it takes minutes.
    check_count(path, read_bytes(path).count(b"<body"), "bodies")
    try:
        answer = answer_of(_CHILD, json.dumps({"file": str(path.absolute())}).encode())
    except ProcessRefused as error:
        raise FileFormatError(str(path), f"MuJoCo cannot read it: {error}") from error
    warnings, _, compiled = answer.partition(b"\n")
    engine: Any = mujoco
    model: Any = engine.MjModel.from_binary_path(_COMPILED, {_COMPILED: compiled})
    return model, json.loads(warnings)


@dataclass
class _Reading:
    path: Path
    model: Any
    root: ElementTree.Element = field(default_factory=lambda: ElementTree.Element("robot"))
    collisions: list[LinkGeometry] = field(default_factory=list[LinkGeometry])
    visuals: list[LinkGeometry] = field(default_factory=list[LinkGeometry])
    notes: list[str] = field(default_factory=list[str])

    def read(self) -> tuple[Urdf, Srdf]:
        model = self.model
        if not any(int(kind) in (SLIDE, HINGE) for kind in model.jnt_type):
            raise FileFormatError(str(self.path), "has no hinge and no slide, so nothing in it moves")
        self._check()
        name = bytes(model.names).split(b"\0", 1)[0].decode() or self.path.stem
        self.root.set("name", name)
        self._link(_WORLD)
        for body in range(1, model.nbody):
            self._body(body)
        owners = self._geoms()
        check_count(self.path, len(self.root.findall("link")), "bodies and geoms of the world")
        mimics = self._mimics()
        passive = self._passive(mimics)
        self._say_what_is_left_out()
        xml = ElementTree.tostring(self.root, encoding="unicode")
        srdf = Srdf(
            states=self._states(), disabled_pairs=untouching(model, owners), passive_joints=frozenset(passive)
        )
        shapes = (tuple(self.collisions), tuple(self.visuals))
        return Urdf(self.path, xml, name, *shapes, mimics, tuple(self.notes)), srdf

    def _check(self) -> None:
        try:
            bytes(self.model.names).decode()
        except UnicodeDecodeError as error:
            raise FileFormatError(str(self.path), f"has a name that is not UTF-8: {error}") from error
        for kind, fields in _NUMBERS.items():
            for field_name in fields:
                values = np.array(getattr(self.model, field_name), dtype=float)
                strange = [row for row, value in enumerate(values) if not np.isfinite(value).all()]
                if strange:
                    raise FileFormatError(
                        str(self.path),
                        f"{kind} {shown(self._name(kind, strange[0]))} has a number that is not finite "
                        f"({field_name})",
                    )

    def _body(self, body: int) -> None:
        model, name, over = self.model, self._name("body", body), int(self.model.body_parentid[body])
        above = self._name("body", over) if over else _WORLD
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        turn, shift = rotation_of(model.body_quat[body]), np.array(model.body_pos[body], dtype=float)
        for joint in range(first, first + count):
            kind, label = int(model.jnt_type[joint]), self._name("joint", joint)
            if kind == BALL:
                raise UnsupportedJoint(label, "ball")
            if kind == FREE:
                self.notes.append(f"joint {shown(label)} is free: {name} is fixed in its place")
                continue
            axis, anchor = (np.array(each[joint], dtype=float) for each in (model.jnt_axis, model.jnt_pos))
            zero = float(model.qpos0[int(model.jnt_qposadr[joint])])
            if kind == SLIDE:
                shift, anchor = shift - turn @ axis * zero, np.zeros(3)
            else:
                shift, turn = shift + turn @ anchor, turn @ _about(axis, -zero)
            direct = joint == first + count - 1 and bool(np.abs(anchor).max() < _EXACT)
            below = name if direct else f"{name}/{label}"
            if not direct:
                self._link(below)
            self._joint(joint, label, (above, below), (shift, turn))
            above, turn, shift = below, np.eye(3), -anchor
        self._link(name, body)
        if above != name:
            self._fixed(name, above, (shift, turn))

    def _link(self, name: str, body: int | None = None) -> None:
        link = ElementTree.SubElement(self.root, "link", name=name)
        if body is None or not float(self.model.body_mass[body]) > 0.0:
            return
        model, inertial = self.model, ElementTree.SubElement(link, "inertial")
        _origin(inertial, np.array(model.body_ipos[body], dtype=float), rotation_of(model.body_iquat[body]))
        ElementTree.SubElement(inertial, "mass", value=_written(model.body_mass[body]))
        moments = dict(zip(("ixx", "iyy", "izz"), map(_written, model.body_inertia[body]), strict=True))
        ElementTree.SubElement(inertial, "inertia", ixy="0", ixz="0", iyz="0", **moments)

    def _joint(self, joint: int, name: str, links: tuple[str, str], where: tuple[Floats, Floats]) -> None:
        model, limited = self.model, bool(self.model.jnt_limited[joint])
        slides = int(model.jnt_type[joint]) == SLIDE
        kind = "prismatic" if slides else "revolute" if limited else "continuous"
        element = _joint(self.root, name, kind, links, where)
        ElementTree.SubElement(element, "axis", xyz=" ".join(map(_written, model.jnt_axis[joint])))
        limit = ElementTree.SubElement(element, "limit", velocity="0", effort=_written(self._effort(joint)))
        if limited:
            lower, upper = (float(end) for end in model.jnt_range[joint])
        elif slides:
            lower, upper = -LONGEST_SLIDE, LONGEST_SLIDE
            self.notes.append(f"slide {shown(name)} has no range: [{lower:g}, {upper:g}] m is taken")
        else:
            return
        limit.set("lower", _written(lower))
        limit.set("upper", _written(upper))

    def _fixed(self, link: str, above: str, where: tuple[Floats, Floats]) -> None:
        _joint(self.root, f"{link}/fixed", "fixed", (above, link), where)

    def _effort(self, joint: int) -> float:
        model, stated = self.model, 0.0
        for actuator in range(int(model.nu)):
            driven = int(model.actuator_trntype[actuator]) in _JOINT_TRANSMISSIONS
            if not driven or int(model.actuator_trnid[actuator][0]) != joint:
                continue
            if model.actuator_forcelimited[actuator]:
                force = float(np.abs(model.actuator_forcerange[actuator]).max())
            elif model.actuator_ctrllimited[actuator] and _is_motor(model, actuator):
                force = float(np.abs(model.actuator_ctrlrange[actuator]).max())
                force *= abs(float(model.actuator_gainprm[actuator][0]))
            else:
                return 0.0
            stated += force * abs(float(model.actuator_gear[actuator][0]))
        if model.jnt_actfrclimited[joint]:
            most = float(np.abs(model.jnt_actfrcrange[joint]).max())
            return min(stated, most) if stated else most
        return stated

    def _geoms(self) -> Mapping[int, str]:
        model, owners = self.model, dict[int, str]()
        seen: dict[str, list[LinkGeometry]] = {}
        for geom in range(int(model.ngeom)):
            body, name = int(model.geom_bodyid[geom]), self._name("geom", geom)
            link = self._name("body", body) if body else f"{_WORLD}/{name}"
            if not body:
                self._link(link)
                self._fixed(link, _WORLD, (np.zeros(3), np.eye(3)))
            red, green, blue, alpha = (float(part) for part in model.geom_rgba[geom])
            shape = geom_shape(model, geom, name)
            item = LinkGeometry(link, geom_placement(model, geom), shape, (red, green, blue, alpha))
            if collides(model, geom):
                owners[geom] = link
                self.collisions.append(item)
            else:
                seen.setdefault(link, []).append(item)
        plain = [item for item in self.collisions if item.link not in seen]
        self.visuals = [*(item for items in seen.values() for item in items), *plain]
        return owners

    def _mimics(self) -> dict[str, Mimic]:
        model, found, others = self.model, dict[str, Mimic](), list[str]()
        for place in range(int(model.neq)):
            kind, name = int(model.eq_type[place]), self._name("equality", place)
            one, other = int(model.eq_obj1id[place]), int(model.eq_obj2id[place])
            offset, factor, *curved = (float(value) for value in model.eq_data[place][:5])
            if not model.eq_active0[place]:
                continue
            if kind != _JOINT_EQUALITY or other < 0 or any(curved):
                others.append(name)
                continue
            at = [float(model.qpos0[int(model.jnt_qposadr[joint])]) for joint in (one, other)]
            leader, follower = self._name("joint", other), self._name("joint", one)
            found[follower] = Mimic(leader, factor, at[0] + offset - factor * at[1])
        if others:
            self.notes.append(f"equality constraints are not kept, loops among them: {listed(others)}")
        return found

    def _passive(self, mimics: Mapping[str, Mimic]) -> list[str]:
        model, driven = self.model, set[int]()
        for actuator in range(int(model.nu)):
            kind, place = int(model.actuator_trntype[actuator]), int(model.actuator_trnid[actuator][0])
            if kind in _JOINT_TRANSMISSIONS:
                driven.add(place)
            elif kind == _TENDON_TRANSMISSION:
                first, count = int(model.tendon_adr[place]), int(model.tendon_num[place])
                wrapped = range(first, first + count)
                joints = (each for each in wrapped if int(model.wrap_type[each]) == _WRAPPED_JOINT)
                driven.update(int(model.wrap_objid[each]) for each in joints)
        names = [
            self._name("joint", joint)
            for joint, kind in enumerate(model.jnt_type)
            if int(kind) in (SLIDE, HINGE) and joint not in driven
        ]
        passive = [name for name in names if name not in mimics] if int(model.nu) else []
        if passive:
            self.notes.append(f"no actuator moves these joints, and no group does: {listed(passive)}")
        return passive

    def _states(self) -> Mapping[tuple[str, str], Mapping[str, float]]:
        model = self.model
        movable = [joint for joint, kind in enumerate(model.jnt_type) if int(kind) in (SLIDE, HINGE)]
        return {
            (ALL_JOINTS, name): {
                self._name("joint", joint): float(model.key_qpos[key][int(model.jnt_qposadr[joint])])
                for joint in movable
            }
            for key in range(int(model.nkey))
            if (name := str(model.key(key).name))
        }

    def _say_what_is_left_out(self) -> None:
        model = self.model
        forces = {
            "damping": model.dof_damping,
            "friction": model.dof_frictionloss,
            "rotor inertia": model.dof_armature,
            "springs": model.jnt_stiffness,
        }
        present = [name for name, values in forces.items() if np.any(values)]
        if present:
            self.notes.append(f"{listed(present)} of joints do not count in torques")
        if np.any(model.body_gravcomp):
            self.notes.append("bodies whose weight MuJoCo compensates count in torques with all of it")
        gravity = np.array(model.opt.gravity)
        if np.abs(gravity - _EARTH).max() > _EXACT:
            self.notes.append(f"gravity is taken as {_EARTH} m/s^2; the file has {gravity.tolist()}")

    def _name(self, kind: str, place: int) -> str:
        return str(getattr(self.model, kind)(place).name) or f"{kind}_{place}"


def _is_motor(model: Any, actuator: int) -> bool:
    return not int(model.actuator_gaintype[actuator]) and not int(model.actuator_biastype[actuator])


def _about(axis: Floats, angle: float) -> Floats:
    half = 0.5 * angle
    return rotation_of(np.array((np.cos(half), *(np.sin(half) * axis / np.linalg.norm(axis)))))


def _written(value: float) -> str:
    return repr(float(value))


def _origin(element: ElementTree.Element, shift: Floats, turn: Floats) -> None:
    xyz, rpy = (" ".join(map(_written, each)) for each in (shift, as_rpy(turn)))
    ElementTree.SubElement(element, "origin", xyz=xyz, rpy=rpy)


def _joint(
    root: ElementTree.Element,
    name: str,
    kind: str,
    links: tuple[str, str],
    where: tuple[Floats, Floats],
) -> ElementTree.Element:
    element = ElementTree.SubElement(root, "joint", name=name, type=kind)
    for tag, link in zip(("parent", "child"), links, strict=True):
        ElementTree.SubElement(element, tag, link=link)
    _origin(element, *where)
    return element


_ROUND = (24, 13)
"""Meridians and parallels of the hull around an ellipsoid: its corners exceed the radii by 2 %."""


def rotation_of(quaternion: Floats) -> Floats:
    w, x, y, z = (float(value) for value in quaternion)
    return from_quaternion(x, y, z, w)


def geom_placement(model: Any, geom: int) -> Placement:
    position = np.array(model.geom_pos[geom], dtype=float)
    return Placement(readonly(rotation_of(model.geom_quat[geom])), readonly(position))


def geom_shape(model: Any, geom: int, name: str) -> Shape:
    """Return the shape of a geom; for an ellipsoid a hull around it."""
    x, y, z = (float(value) for value in model.geom_size[geom])
    match int(model.geom_type[geom]):  # numbers of MuJoCo's mjtGeom
        case 0:
            return Plane()
        case 2:
            return Sphere(x)
        case 3:
            return Capsule(x, 2.0 * y)
        case 4:
            return _around_ellipsoid(np.array((x, y, z)))
        case 5:
            return Cylinder(x, 2.0 * y)
        case 6:
            return Box(2.0 * x, 2.0 * y, 2.0 * z)
        case 7:
            mesh = int(model.geom_dataid[geom])
            first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
            face, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
            corners = np.array(model.mesh_vert[first : first + count], dtype=float)
            return Mesh(corners, np.array(model.mesh_face[face : face + faces], dtype=np.int32))
        case _:
            reason = "is a height field or a signed distance field, which no link can have"
            raise ModelError(f"geom {shown(name)} {reason}; use a mesh or primitives")


def _around_ellipsoid(radii: Floats) -> Shape:
    turns, heights = _ROUND
    around = np.linspace(0.0, 2.0 * np.pi, turns, endpoint=False)
    points = np.array(
        [
            (np.sin(down) * np.cos(turn), np.sin(down) * np.sin(turn), np.cos(down))
            for down in np.linspace(0.0, np.pi, heights)[1:-1]
            for turn in around
        ]
        + [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]
    )
    hull = convex(points)
    corners = hull.vertices[hull.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    nearest = float(np.einsum("ij,ij->i", normals, corners[:, 0]).min())
    return convex(points / nearest * radii)


def collides(model: Any, geom: int) -> bool:
    return bool(model.geom_contype[geom] or model.geom_conaffinity[geom])


def untouching(model: Any, owners: Mapping[int, str]) -> frozenset[frozenset[str]]:
    """Return the pairs of links not checked against each other.

    Pairs without two geoms that share collision bits, pairs in `<exclude>`, and a body and its parent, as for
    any robot also if that is the fixed base.
    """
    bits: dict[str, set[tuple[int, int]]] = {}
    bodies: dict[str, int] = {}
    for geom, link in owners.items():
        bits.setdefault(link, set()).add((int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])))
        bodies.setdefault(link, int(model.geom_bodyid[geom]))
    excluded = {frozenset((int(pair) >> 16, int(pair) & 0xFFFF)) for pair in model.exclude_signature}
    pairs = zip(model.pair_geom1, model.pair_geom2, strict=True)
    demanded = {frozenset(owners.get(int(geom), "") for geom in pair) for pair in pairs}
    found: set[frozenset[str]] = set()
    for one, other in combinations(bits, 2):
        pair, bodies_of = frozenset((one, other)), (bodies[one], bodies[other])
        if pair in demanded:
            continue
        apart = not any(bool(a[0] & b[1] or b[0] & a[1]) for a, b in product(bits[one], bits[other]))
        if apart or frozenset(bodies_of) in excluded or _hang_together(model, *bodies_of):
            found.add(pair)
    return frozenset(found)


def _hang_together(model: Any, a: int, b: int) -> bool:
    welds = model.body_weldid
    if welds[a] == welds[b]:
        return True
    for one, other in ((a, b), (b, a)):
        above = int(model.body_parentid[int(welds[one])])
        if above and (above == other or (welds[above] and welds[above] == welds[other])):
            return True
    return False
