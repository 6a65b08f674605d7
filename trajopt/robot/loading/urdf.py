"""URDF: what pinocchio does not hand over in full (bodies, mimics, efforts), and mesh paths.

Kinematics and inertias are pinocchio's; here the same XML is read for the shapes on each link.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot
from pathlib import Path
from xml.etree import ElementTree

from trajopt.robot.loading.mesh_names import MeshNames
from trajopt.robot.loading.urdf_tree import check_tree, complete
from trajopt.robot.loading.xacro_file import SUFFIX, expanded
from trajopt.robot.loading.xml_file import numbers, parse_xml, read_xml
from trajopt.values.errors import FileFormatError, MeshFileError, ShapeError, UnsupportedJoint, listed, shown
from trajopt.values.placement import Placement, placement
from trajopt.values.shapes.shapes import Box, Capsule, Cylinder, Shape, Sphere

_SHORTEST_AXIS = 1e-6
ONE_DEGREE_OF_FREEDOM = ("revolute", "continuous", "prismatic")
SEVERAL_DEGREES_OF_FREEDOM = ("planar", "floating")


@dataclass(frozen=True)
class MeshReference:
    """A mesh file on a link, not loaded yet.

    Attributes:
        path: The file.
        scale: Factors along x, y, z.
    """

    path: Path
    scale: tuple[float, float, float]


@dataclass(frozen=True)
class LinkGeometry:
    """One collision or visual element of a link.

    Attributes:
        link: Name of the link.
        placement: Of the geometry in the link's frame.
        geometry: A primitive shape or the mesh file.
        colour: Red, green, blue, alpha in [0, 1]; None where the file states none.
    """

    link: str
    placement: Placement
    geometry: Shape | MeshReference
    colour: tuple[float, float, float, float] | None = None


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: position = multiplier * source + offset."""

    source: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Urdf:
    """What a URDF file says, beside kinematics and inertias.

    Attributes:
        path: The file.
        xml: Its text without collision and visual elements: kinematics and inertias; joints of several
            degrees of freedom are in it as they are written.
        name: The robot's name.
        collisions: Collision elements of all links.
        visuals: Visual elements of all links.
        mimics: Mimicking joints by name.
        notes: Sentences on what was left out, or taken differently.
    """

    path: Path
    xml: str
    name: str
    collisions: tuple[LinkGeometry, ...]
    visuals: tuple[LinkGeometry, ...]
    mimics: Mapping[str, Mimic]
    notes: tuple[str, ...] = ()


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
    raise FileFormatError(str(path), "a <geometry> holds no shape that trajopt knows")


def _link_geometries(
    path: Path,
    root: ElementTree.Element,
    tag: str,
    meshes: MeshNames,
    missing: dict[str, str] | None = None,
) -> tuple[LinkGeometry, ...]:
    """Return the elements of a tag; meshes that are not found go into `missing`, by link, where it is given.

    Raises:
        FileFormatError: If an element does not say what it must.
        MeshFileError: If a mesh is not found, and there is no `missing`.
    """
    materials = {material.get("name"): material for material in root.findall("material")}
    found: list[LinkGeometry] = []
    for link in root.findall("link"):
        for element in link.findall(tag):
            geometry = element.find("geometry")
            if geometry is None:
                raise FileFormatError(str(path), f"link {link.get('name')}: <{tag}> has no <geometry>")
            if tag == "collision" and (count := len(element.findall("geometry"))) > 1:
                reason = f"a <collision> has {count} <geometry> elements: write one <collision> for each"
                raise FileFormatError(str(path), f"link {link.get('name')}: {reason}")
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
            try:
                shape = _geometry(path, geometry, meshes)
            except MeshFileError as error:
                if missing is None:
                    raise
                missing.setdefault(link.get("name", ""), error.path)
                continue
            found.append(LinkGeometry(link.get("name", ""), where, shape, rgba))
    return tuple(found)


def _check_links(path: Path, root: ElementTree.Element) -> None:
    """Make sure of the masses and inertias, which pinocchio takes as they come."""
    for link in root.findall("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        mass, inertia, origin = (inertial.find(tag) for tag in ("mass", "inertia", "origin"))
        if mass is not None and (value := numbers(path, mass, "value", "0", count=1)[0]) < 0.0:
            raise FileFormatError(
                str(path), f"link {shown(link.get('name'))}: its mass is negative, {value:g} kg"
            )
        if inertia is not None:
            for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
                numbers(path, inertia, key, "0", count=1)
        _check_origin(path, origin)


def _check_origin(path: Path, origin: ElementTree.Element | None) -> None:
    if origin is not None:
        for key in ("xyz", "rpy"):
            numbers(path, origin, key, "0 0 0", count=3)


def _check_joint(path: Path, joint: ElementTree.Element) -> None:
    """Make sure of the numbers of a joint, which pinocchio takes as they come."""
    name = f"joint {shown(joint.get('name'))}"
    origin, axis, limit = (joint.find(tag) for tag in ("origin", "axis", "limit"))
    _check_origin(path, origin)
    if axis is not None and joint.get("type") != "fixed":
        x, y, z = numbers(path, axis, "xyz", "1 0 0", count=3)
        if hypot(x, y, z) < _SHORTEST_AXIS:
            raise FileFormatError(str(path), f"{name}: its axis has no length, so it has no direction")
    if limit is not None:
        lower, upper = (numbers(path, limit, key, "0", count=1)[0] for key in ("lower", "upper"))
        for key in ("velocity", "effort"):
            numbers(path, limit, key, "0", count=1)
        if lower > upper and joint.get("type") in ("revolute", "prismatic"):
            raise FileFormatError(
                str(path), f"{name}: its lower limit {lower:g} is above its upper one {upper:g}"
            )


def read_urdf(path: Path, package_dirs: Sequence[Path] = (), xacro: Mapping[str, str] | None = None) -> Urdf:
    """Read a URDF file, or what a xacro file makes, and find its meshes.

    Args:
        path: The file; xacro where its name ends so.
        package_dirs: Folders that hold ROS packages, for `package://` names.
        xacro: Arguments of a xacro file by name.

    Raises:
        MissingExtra: If it is xacro, and what expands that is not installed.
        FileFormatError: If it is missing or no URDF.
        MeshFileError: If a collision mesh cannot be found.
        UnsupportedJoint: If a joint is of no type that URDF has.
    """
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
    _check_links(path, root)
    mimics: dict[str, Mimic] = {}
    for joint in root.findall("joint"):
        name, kind = joint.get("name", ""), joint.get("type", "")
        if kind not in (*ONE_DEGREE_OF_FREEDOM, *SEVERAL_DEGREES_OF_FREEDOM, "fixed"):
            raise UnsupportedJoint(name, kind)
        _check_joint(path, joint)
        mimic = joint.find("mimic")
        if mimic is not None:
            mimics[name] = Mimic(
                mimic.get("joint", ""),
                numbers(path, mimic, "multiplier", "1", count=1)[0],
                numbers(path, mimic, "offset", "0", count=1)[0],
            )
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
    return Urdf(path, text, root.get("name", path.stem), collisions, visuals, mimics, tuple(notes))
