"""URDF: the parts that pinocchio does not provide in full (bodies, mimics, efforts), and mesh paths."""

from collections import Counter
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from math import hypot
from pathlib import Path
from xml.etree import ElementTree

from trajopt.robot.loading.mesh_names import MeshNames
from trajopt.robot.loading.xml_file import SUFFIX, expanded, numbers, parse_xml, read_xml
from trajopt.values.errors import (
    FileFormatError,
    FrameNotFound,
    MeshFileError,
    ShapeError,
    UnsupportedJoint,
    listed,
    shown,
)
from trajopt.values.placement import Placement, as_rpy, from_quaternion, placement
from trajopt.values.shapes.mesh import load_mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cylinder, Shape, Sphere

_SHORTEST_AXIS = 1e-6
ONE_DEGREE_OF_FREEDOM = ("revolute", "continuous", "prismatic")
SEVERAL_DEGREES_OF_FREEDOM = ("planar", "floating")


@dataclass(frozen=True)
class MeshReference:
    """A mesh file on a link, not loaded yet, and its factors along x, y and z."""

    path: Path
    scale: tuple[float, float, float]


@dataclass(frozen=True)
class LinkGeometry:
    """One collision or visual element of a link.

    Attributes:
        placement: Of the geometry in the link's frame.
        colour: Red, green, blue, alpha in [0, 1]; None if the file has none.
    """

    link: str
    placement: Placement
    geometry: Shape | MeshReference
    colour: tuple[float, float, float, float] | None = None

    @property
    def shape(self) -> Shape:
        """Its shape; a mesh is read from its file, which may raise a MeshFileError."""
        where = self.geometry
        return load_mesh(where.path, where.scale) if isinstance(where, MeshReference) else where


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: position = multiplier * source + offset."""

    source: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Urdf:
    """The content of a URDF file, except kinematics and inertias."""

    path: Path
    xml: str
    name: str
    collisions: tuple[LinkGeometry, ...]
    visuals: tuple[LinkGeometry, ...]
    mimics: Mapping[str, Mimic]
    notes: tuple[str, ...] = ()
    limits: Mapping[str, Mapping[str, float]] = field(default_factory=dict[str, Mapping[str, float]])


@contextmanager
def _within(element: ElementTree.Element) -> Generator[None]:
    """Name a link or joint in errors of its content."""
    try:
        yield
    except FileFormatError as error:
        where = f"{element.tag} {shown(element.get('name'))}"
        raise FileFormatError(error.path, f"{where}: {error.reason}") from error


def _geometry(path: Path, element: ElementTree.Element, meshes: MeshNames) -> Shape | MeshReference:
    def sizes(shape: ElementTree.Element, *keys: str) -> list[float]:
        return [numbers(path, shape, key, "0", count=1)[0] for key in keys]

    box, sphere = element.find("box"), element.find("sphere")
    cylinder, capsule, mesh = element.find("cylinder"), element.find("capsule"), element.find("mesh")
    try:
        if box is not None:
            return Box(*numbers(path, box, "size", "0 0 0", count=3))
        if sphere is not None:
            return Sphere(*sizes(sphere, "radius"))
        if cylinder is not None:
            return Cylinder(*sizes(cylinder, "radius", "length"))
        if capsule is not None:
            return Capsule(*sizes(capsule, "radius", "length"))
    except ShapeError as error:
        raise FileFormatError(str(path), str(error)) from error
    if mesh is not None:
        x, y, z = numbers(path, mesh, "scale", "1 1 1", count=3)
        if not x * y * z:
            raise FileFormatError(str(path), f"<mesh scale={shown(mesh.get('scale'))}> makes the mesh flat")
        return MeshReference(meshes.find(mesh.get("filename", "")), (x, y, z))
    raise FileFormatError(str(path), "a <geometry> has no known shape")


def _link_geometries(
    path: Path,
    root: ElementTree.Element,
    tag: str,
    meshes: MeshNames,
    missing: dict[str, str] | None = None,
) -> tuple[LinkGeometry, ...]:
    materials = {material.get("name"): material for material in root.findall("material")}
    found: list[LinkGeometry] = []
    for link in root.findall("link"):
        with _within(link):
            for element in link.findall(tag):
                try:
                    found.append(_link_geometry(path, link.get("name", ""), element, materials, meshes))
                except MeshFileError as error:
                    if missing is None:
                        raise
                    missing.setdefault(link.get("name", ""), error.path)
    return tuple(found)


def _link_geometry(
    path: Path,
    link: str,
    element: ElementTree.Element,
    materials: Mapping[str | None, ElementTree.Element],
    meshes: MeshNames,
) -> LinkGeometry:
    geometry = element.find("geometry")
    if geometry is None:
        raise FileFormatError(str(path), f"<{element.tag}> has no <geometry>")
    if element.tag == "collision" and (count := sum(map(len, element.findall("geometry")))) > 1:
        raise FileFormatError(str(path), f"a <collision> has {count} shapes: write one <collision> for each")
    origin = element.find("origin")
    where = placement()
    if origin is not None:
        where = placement(
            numbers(path, origin, "xyz", "0 0 0", count=3),
            rpy=numbers(path, origin, "rpy", "0 0 0", count=3),
        )
    material = element.find("material")
    if material is not None and material.find("color") is None:
        material = materials.get(material.get("name"))
    colour = None if material is None else material.find("color")
    rgba = None
    if colour is not None:
        red, green, blue, alpha = numbers(path, colour, "rgba", "0.7 0.7 0.7 1", count=4)
        rgba = (red, green, blue, alpha)
    return LinkGeometry(link, where, _geometry(path, geometry, meshes), rgba)


def _check_links(path: Path, root: ElementTree.Element) -> None:
    for link in root.findall("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        mass, inertia, origin = (inertial.find(tag) for tag in ("mass", "inertia", "origin"))
        with _within(link):
            if mass is not None and (value := numbers(path, mass, "value", "0", count=1)[0]) < 0.0:
                raise FileFormatError(str(path), f"its mass is negative, {value:g} kg")
            if inertia is not None:
                for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
                    numbers(path, inertia, key, "0", count=1)
            _check_origin(path, origin)


def _check_origin(path: Path, origin: ElementTree.Element | None) -> None:
    if origin is not None:
        for key in ("xyz", "rpy"):
            numbers(path, origin, key, "0 0 0", count=3)


def _check_joint(path: Path, joint: ElementTree.Element) -> None:
    origin, axis, limit = (joint.find(tag) for tag in ("origin", "axis", "limit"))
    _check_origin(path, origin)
    if axis is not None and joint.get("type") != "fixed":
        x, y, z = numbers(path, axis, "xyz", "1 0 0", count=3)
        if hypot(x, y, z) < _SHORTEST_AXIS:
            raise FileFormatError(str(path), "its axis has no length, so it has no direction")
    if limit is not None:
        lower, upper = (numbers(path, limit, key, "0", count=1)[0] for key in ("lower", "upper"))
        for key in ("velocity", "effort"):
            numbers(path, limit, key, "0", count=1)
        if lower > upper and joint.get("type") in ("revolute", "prismatic"):
            raise FileFormatError(str(path), f"its lower limit {lower:g} is above its upper one {upper:g}")


def _rates(path: Path, joint: ElementTree.Element) -> dict[str, float]:
    limit, found = joint.find("limit"), dict[str, float]()
    if limit is None:
        return found
    for key, name in (
        ("acceleration", "max_acceleration"),
        ("deceleration", "max_acceleration"),
        ("jerk", "max_jerk"),
    ):
        if limit.get(key) is None:
            continue
        value = numbers(path, limit, key, "0", count=1)[0]
        if value <= 0.0:
            raise FileFormatError(str(path), f"<limit {key}={shown(limit.get(key))}> is not positive")
        found[name] = min(value, found.get(name, value))
    return found


def _joints(path: Path, root: ElementTree.Element) -> tuple[dict[str, Mimic], dict[str, Mapping[str, float]]]:
    mimics, limits = dict[str, Mimic](), dict[str, Mapping[str, float]]()
    for joint in root.findall("joint"):
        name, kind = joint.get("name", ""), joint.get("type", "")
        if kind not in (*ONE_DEGREE_OF_FREEDOM, *SEVERAL_DEGREES_OF_FREEDOM, "fixed"):
            raise UnsupportedJoint(name, kind)
        with _within(joint):
            _check_joint(path, joint)
            if kind in ONE_DEGREE_OF_FREEDOM and (rates := _rates(path, joint)):
                limits[name] = rates
            mimic = joint.find("mimic")
            if mimic is not None:
                mimics[name] = Mimic(
                    mimic.get("joint", ""),
                    numbers(path, mimic, "multiplier", "1", count=1)[0],
                    numbers(path, mimic, "offset", "0", count=1)[0],
                )
    return mimics, limits


def _angles_of_quaternions(path: Path, root: ElementTree.Element) -> None:
    for origin in root.iter("origin"):
        if (text := origin.attrib.pop("quat_xyzw", None)) is None:
            continue
        if origin.get("rpy") is not None:
            raise FileFormatError(
                str(path), f"<origin quat_xyzw={shown(text)}> also has rpy; give one of them"
            )
        x, y, z, w = numbers(path, ElementTree.Element("origin", quat_xyzw=text), "quat_xyzw", "", count=4)
        size = hypot(x, y, z, w)
        if size < _SHORTEST_AXIS:
            raise FileFormatError(str(path), f"<origin quat_xyzw={shown(text)}> is zero")
        angles = as_rpy(from_quaternion(x / size, y / size, z / size, w / size))
        origin.set("rpy", " ".join(map(repr, map(float, angles))))


def read_urdf(path: Path, package_dirs: Sequence[Path] = (), xacro: Mapping[str, str] | None = None) -> Urdf:
    """Read a URDF file, or the URDF of a xacro file (suffix .xacro), and find its meshes."""
    if path.suffix == SUFFIX:
        root = parse_xml(expanded(path, xacro or {}, package_dirs), path, "URDF")
    else:
        root = read_xml(path, "URDF")
    if root.find("link") is None:
        raise FileFormatError(str(path), "has no <link>, so it describes no robot")
    notes: list[str] = []
    if not root.get("name"):
        root.set("name", path.stem)
        notes.append(f"the file gives the robot no name; it is called {shown(path.stem)}")
    _angles_of_quaternions(path, root)
    _check_links(path, root)
    mimics, limits = _joints(path, root)
    check_tree(path, root)
    meshes = MeshNames(path, tuple(package_dirs))
    collisions = _link_geometries(path, root, "collision", meshes)
    missing: dict[str, str] = {}
    visuals = _link_geometries(path, root, "visual", meshes, missing)
    if missing:
        # Nothing is planned with visuals: whoever looks sees the collision shapes.
        visuals = tuple(item for item in visuals if item.link not in missing)
        visuals += tuple(item for item in collisions if item.link in missing)
        files = [f"{shown(file)} of {link}" for link, file in missing.items()]
        notes.append(f"visual meshes are missing, collision shapes are drawn instead: {listed(files)}")
    notes.extend(complete(path, root))
    for link in root.findall("link"):
        for element in (*link.findall("collision"), *link.findall("visual")):
            link.remove(element)
    text = ElementTree.tostring(root, encoding="unicode")
    return Urdf(path, text, root.get("name", path.stem), collisions, visuals, mimics, tuple(notes), limits)


MOST_LINKS = 1000
"""Most links: all pairs of them are listed, half a million for a thousand."""
_UNUSED = ("safety_controller", "calibration")
_ONCE = {"link": ("inertial",), "joint": ("parent", "child", "origin", "axis", "limit", "mimic")}
_MOMENTS, _PRODUCTS = ("ixx", "iyy", "izz"), ("ixy", "ixz", "iyz")


def check_count(path: Path, links: int, kind: str = "links") -> None:
    if links > MOST_LINKS:
        raise FileFormatError(
            str(path),
            f"has {links} {kind}, more than the {MOST_LINKS} that a robot may have; its surroundings "
            "belong in a scene (Scene.add)",
        )


def check_tree(path: Path, root: ElementTree.Element) -> None:
    """Check that the links form one tree of bounded size with unique names."""
    check_count(path, len(root.findall("link")))
    for tag in ("link", "joint"):
        counted = Counter(element.get("name", "") for element in root.findall(tag))
        if "" in counted:
            raise FileFormatError(str(path), f"a <{tag}> has no name")
        twice = [shown(name) for name, count in counted.items() if count > 1]
        if twice:
            raise FileFormatError(str(path), f"more than one <{tag}> is named {listed(twice)}")
    links = {link.get("name", ""): list[str]() for link in root.findall("link")}
    holding: dict[str, str] = {}
    for joint in root.findall("joint"):
        name = joint.get("name", "")
        parent, child = (_end(path, joint, tag, links) for tag in ("parent", "child"))
        if child in holding:
            raise FileFormatError(
                str(path),
                f"link {shown(child)} is the child of two joints, {shown(holding[child])} and {shown(name)}: "
                "links must be a tree, without closed chains",
            )
        holding[child] = name
        links[parent].append(child)
    roots = [link for link in links if link not in holding]
    if len(roots) > 1:
        raise FileFormatError(
            str(path), f"links are the child of no joint, and one alone may be: {listed(roots)}"
        )
    reached = list(roots)
    for link in reached:
        reached.extend(links[link])
    circle = sorted(links.keys() - set(reached))
    if circle:
        raise FileFormatError(str(path), f"links hang on each other in a circle: {listed(circle)}")


def _end(path: Path, joint: ElementTree.Element, tag: str, links: Mapping[str, object]) -> str:
    name, element = shown(joint.get("name")), joint.find(tag)
    link = None if element is None else element.get("link")
    if link is None:
        raise FileFormatError(str(path), f"joint {name} has no <{tag} link=...>")
    if link not in links:
        raise FileFormatError(str(path), f"joint {name}: {FrameNotFound(f'{tag} link', link, links)}")
    return link


def complete(path: Path, root: ElementTree.Element) -> list[str]:
    """Add missing parts of joints and inertias, and remove unused elements; return notes."""
    root.attrib.pop("version", None)
    for material in root.findall("material"):
        root.remove(material)
    joints = root.findall("joint")
    negative = [joint.get("name", "") for joint in joints if _has_negative_limit(path, joint)]
    softer = [joint.get("name", "") for joint in joints if _has_narrower_soft_limits(path, joint)]
    still = [joint.get("name", "") for joint in joints if not _complete_joint(path, joint)]
    dropped = [link.get("name", "") for link in root.findall("link") if not _complete_inertia(link)]
    said: list[str] = []
    if still:
        unmoved = "which URDF takes as 0, so that nothing moves"
        said.append(f"no lower and upper limits are stated, {unmoved}: {listed(still)}")
    if negative:
        said.append(f"negative limits of velocity or effort count as not stated: {listed(negative)}")
    if softer:
        narrower = "soft limits of a <safety_controller> are narrower than the limits and are not applied"
        said.append(f"{narrower}; give them as limits= to keep them: {listed(softer)}")
    if dropped:
        said.append(f"inertias without a mass or moments are left out of torques: {listed(dropped)}")
    if repeated := _repeated(root):
        said.append(f"of elements that URDF has once, the first counts: {listed(repeated)}")
    return said


def _repeated(root: ElementTree.Element) -> list[str]:
    owners = [element for kind in _ONCE for element in root.findall(kind)]
    return [
        f"<{tag}> of {owner.get('name', '')}"
        for owner in owners
        for tag in _ONCE[owner.tag]
        if len(owner.findall(tag)) > 1
    ]


def _has_negative_limit(path: Path, joint: ElementTree.Element) -> bool:
    limit = joint.find("limit")
    keys = ("velocity", "effort")
    return limit is not None and any(numbers(path, limit, key, "0", count=1)[0] < 0.0 for key in keys)


def _has_narrower_soft_limits(path: Path, joint: ElementTree.Element) -> bool:
    soft, limit = joint.find("safety_controller"), joint.find("limit")
    if soft is None or limit is None or joint.get("type") not in ("revolute", "prismatic"):
        return False
    lower, upper = (numbers(path, limit, key, "0", count=1)[0] for key in ("lower", "upper"))
    softly_lower, softly_upper = (
        numbers(path, soft, f"soft_{key}_limit", str(hard), count=1)[0]
        for key, hard in (("lower", lower), ("upper", upper))
    )
    return softly_lower > lower or softly_upper < upper


def _complete_joint(path: Path, joint: ElementTree.Element) -> bool:
    name, kind, limit = shown(joint.get("name")), joint.get("type"), joint.find("limit")
    for tag in _UNUSED:
        for element in joint.findall(tag):
            joint.remove(element)
    for dynamics in joint.findall("dynamics"):
        if dynamics.get("damping") is None and dynamics.get("friction") is None:
            joint.remove(dynamics)
    mimic = joint.find("mimic")
    if mimic is not None and not mimic.get("joint"):
        raise FileFormatError(str(path), f"joint {name}: its <mimic> names no joint")
    bounded = kind in ("revolute", "prismatic")
    if limit is None:
        if bounded:
            instead = ", or make it continuous" if kind == "revolute" else ""
            raise FileFormatError(
                str(path), f"joint {name} is {kind} and has no <limit>: state lower and upper{instead}"
            )
        return True
    for key in ("velocity", "effort"):
        if limit.get(key) is None:
            limit.set(key, "0")
    return not bounded or limit.get("lower") is not None or limit.get("upper") is not None


def _complete_inertia(link: ElementTree.Element) -> bool:
    inertial = link.find("inertial")
    if inertial is None:
        return True
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    stated = mass is not None and mass.get("value") is not None
    if not stated or inertia is None or any(inertia.get(key) is None for key in _MOMENTS):
        link.remove(inertial)
        return False
    for key in _PRODUCTS:
        if inertia.get(key) is None:
            inertia.set(key, "0")
    return True
