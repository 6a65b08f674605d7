"""URDF: what pinocchio does not hand over in full (bodies, mimics, efforts), and mesh paths.

Kinematics and inertias are pinocchio's; here the same XML is read for the shapes on each link.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from trajopt.errors import FileFormatError, MeshFileError, UnsupportedJoint
from trajopt.model.placement import Placement, placement
from trajopt.model.shapes import Box, Capsule, Cylinder, Shape, Sphere
from trajopt.shown import shown

ONE_DEGREE_OF_FREEDOM = ("revolute", "continuous", "prismatic")


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
        xml: Its text without collision and visual elements: kinematics and inertias.
        name: The robot's name.
        collisions: Collision elements of all links.
        visuals: Visual elements of all links.
        mimics: Mimicking joints by name.
    """

    path: Path
    xml: str
    name: str
    collisions: tuple[LinkGeometry, ...]
    visuals: tuple[LinkGeometry, ...]
    mimics: Mapping[str, Mimic]


def _numbers(path: Path, element: ElementTree.Element, key: str, default: str) -> list[float]:
    text = element.get(key, default)
    try:
        return [float(word) for word in text.split()]
    except ValueError as error:
        raise FileFormatError(
            str(path), f"<{element.tag} {key}={shown(text)}> is no list of numbers"
        ) from error


def resolve_mesh(filename: str, urdf: Path, package_dirs: Sequence[Path]) -> Path:
    """Find the file that a URDF's mesh name means.

    Tried in this order: the name as an absolute path (with or without `file://`); below each
    package directory; below the URDF's folder and its parents (where packages usually stand).

    Raises:
        MeshFileError: If it is nowhere.
    """
    name = filename.removeprefix("file://")
    relative = name.removeprefix("package://").removeprefix("model://")
    if name.startswith("/") and Path(name).is_file():
        return Path(name)
    roots = [*package_dirs, urdf.parent, *urdf.parent.resolve().parents]
    for root in roots:
        if (root / relative).is_file():
            return (root / relative).resolve()
    # A package directory may be the package itself: drop the package's name then.
    for root in roots[: len(package_dirs) + 1]:
        inner = root / Path(*Path(relative).parts[1:])
        if name.startswith("package://") and inner.is_file():
            return inner.resolve()
    raise MeshFileError(filename, f"not found for {urdf.name}; name its package directory")


def _geometry(
    path: Path, element: ElementTree.Element, package_dirs: Sequence[Path]
) -> Shape | MeshReference:
    box, sphere = element.find("box"), element.find("sphere")
    cylinder, capsule, mesh = element.find("cylinder"), element.find("capsule"), element.find("mesh")
    if box is not None:
        return Box(*_numbers(path, box, "size", "0 0 0"))
    if sphere is not None:
        return Sphere(*_numbers(path, sphere, "radius", "0"))
    if cylinder is not None:
        return Cylinder(*_numbers(path, cylinder, "radius", "0"), *_numbers(path, cylinder, "length", "0"))
    if capsule is not None:
        return Capsule(*_numbers(path, capsule, "radius", "0"), *_numbers(path, capsule, "length", "0"))
    if mesh is not None:
        x, y, z = _numbers(path, mesh, "scale", "1 1 1")
        file = resolve_mesh(mesh.get("filename", ""), path, package_dirs)
        return MeshReference(file, (x, y, z))
    raise FileFormatError(str(path), "a <geometry> holds no shape that trajopt knows")


def _link_geometries(
    path: Path, root: ElementTree.Element, tag: str, package_dirs: Sequence[Path]
) -> tuple[LinkGeometry, ...]:
    materials = {material.get("name"): material for material in root.findall("material")}
    found: list[LinkGeometry] = []
    for link in root.findall("link"):
        for element in link.findall(tag):
            geometry = element.find("geometry")
            if geometry is None:
                raise FileFormatError(str(path), f"link {link.get('name')}: <{tag}> has no <geometry>")
            origin = element.find("origin")
            where = placement()
            if origin is not None:
                where = placement(
                    _numbers(path, origin, "xyz", "0 0 0"), rpy=_numbers(path, origin, "rpy", "0 0 0")
                )
            material = element.find("material")
            if material is not None and material.find("color") is None:
                material = materials.get(material.get("name"))
            colour = None if material is None else material.find("color")
            rgba = None
            if colour is not None:
                red, green, blue, alpha = _numbers(path, colour, "rgba", "0.7 0.7 0.7 1")
                rgba = (red, green, blue, alpha)
            try:
                shape = _geometry(path, geometry, package_dirs)
            except MeshFileError:
                if tag == "collision":
                    raise
                continue  # nothing is planned with visuals: viewers draw collision shapes instead
            found.append(LinkGeometry(link.get("name", ""), where, shape, rgba))
    return tuple(found)


def read_urdf(path: Path, package_dirs: Sequence[Path] = ()) -> Urdf:
    """Read a URDF file and find its meshes.

    Args:
        path: The file.
        package_dirs: Folders that hold ROS packages, for `package://` names.

    Raises:
        FileFormatError: If it is missing or no URDF.
        MeshFileError: If a collision mesh cannot be found.
        UnsupportedJoint: If a joint has more than one degree of freedom.
    """
    try:
        root = ElementTree.fromstring(path.read_text())
    except (OSError, ElementTree.ParseError) as error:
        raise FileFormatError(str(path), f"is no readable URDF: {error}") from error
    if root.tag != "robot":
        raise FileFormatError(str(path), f"its root is <{root.tag}>, not <robot>")
    mimics: dict[str, Mimic] = {}
    for joint in root.findall("joint"):
        name, kind = joint.get("name", ""), joint.get("type", "")
        if kind not in (*ONE_DEGREE_OF_FREEDOM, "fixed"):
            raise UnsupportedJoint(name, kind)
        mimic = joint.find("mimic")
        if mimic is not None:
            mimics[name] = Mimic(
                mimic.get("joint", ""),
                _numbers(path, mimic, "multiplier", "1")[0],
                _numbers(path, mimic, "offset", "0")[0],
            )
    collisions = _link_geometries(path, root, "collision", package_dirs)
    visuals = _link_geometries(path, root, "visual", package_dirs)
    for link in root.findall("link"):
        for element in (*link.findall("collision"), *link.findall("visual")):
            link.remove(element)
    text = ElementTree.tostring(root, encoding="unicode")
    return Urdf(path, text, root.get("name", path.stem), collisions, visuals, mimics)
