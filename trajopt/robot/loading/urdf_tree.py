"""What a URDF must say to be a tree of links, and what may be missing in it.

The parser behind pinocchio refuses a file as a whole, or drops an inertia, and tells why on the process's
standard error only. What is wrong is found here first, and named; what many files lack is filled in.
"""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

from trajopt.robot.loading.xml_file import numbers
from trajopt.values.errors import FileFormatError, FrameNotFound, listed, shown

MOST_LINKS = 1000
"""Links of a robot: all pairs of them are listed, and of a thousand there are half a million."""
_UNUSED = ("safety_controller", "calibration")
_MOMENTS, _PRODUCTS = ("ixx", "iyy", "izz"), ("ixy", "ixz", "iyz")


def check_count(path: Path, links: int, kind: str = "links") -> None:
    """Make sure that there are not more links than a robot may have.

    Args:
        path: The file.
        links: How many there are.
        kind: Their name in the file.

    Raises:
        FileFormatError: If there are more.
    """
    if links > MOST_LINKS:
        raise FileFormatError(
            str(path),
            f"has {links} {kind}, more than the {MOST_LINKS} that a robot may have; what stands around it "
            "belongs in a scene (Scene.add)",
        )


def check_tree(path: Path, root: ElementTree.Element) -> None:
    """Make sure that the links are one tree of bounded size, in which everything has a name of its own.

    Raises:
        FileFormatError: If they are not.
    """
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
    """Return the link at one end of a joint."""
    name, element = shown(joint.get("name")), joint.find(tag)
    link = None if element is None else element.get("link")
    if link is None:
        raise FileFormatError(str(path), f"joint {name} has no <{tag} link=...>")
    if link not in links:
        raise FileFormatError(str(path), f"joint {name}: {FrameNotFound(f'{tag} link', link, links)}")
    return link


def complete(path: Path, root: ElementTree.Element) -> list[str]:
    """Fill in what joints and inertias lack, and take out what nothing reads; return what there is to say.

    Raises:
        FileFormatError: If a joint that needs limits has none, or mimics nothing.
    """
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
    return said


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
    """Return whether the joint can move, as far as its limits say."""
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
    """Return whether the link's inertia could be read, if it has one; one that cannot is taken out."""
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
