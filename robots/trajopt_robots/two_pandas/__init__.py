"""Two Pandas side by side, made at load time from the files of one."""

import re
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree

import trajopt as to

from .. import panda
from .._example_robot_data import share_folder

__all__ = ["load"]

_ONE = Path(panda.__file__).parent
_URDF = "example-robot-data/robots/panda_description/urdf/panda.urdf"

_SIDES = {"left": 0.4, "right": -0.4}
"""Name of each arm and where it stands along y [m]."""

_NAMES = {
    "link": ("name",),
    "joint": ("name",),
    "parent": ("link",),
    "child": ("link",),
    "mimic": ("joint",),
    "group": ("name",),
    "chain": ("base_link", "tip_link"),
    "group_state": ("name", "group"),
    "end_effector": ("name", "parent_link", "group", "parent_group"),
    "disable_collisions": ("link1", "link2"),
}
"""Elements of URDF and SRDF, and which of their attributes name what there are two of."""


def load() -> to.Robot:
    """Load two Pandas 0.8 m apart along y, both looking along x: 14 arm joints [rad], 4 fingers [m].

    Every name of the Panda is there twice, as ``left_...`` and ``right_...``; group ``both`` holds the
    joints of both arms, and state ``ready`` of that group those of both Pandas' ``ready``. Frame ``base``
    is between them.

    Returns:
        The robot, with the limits of the Panda.

    Raises:
        MissingExtra: if ``example-robot-data`` is not installed.
    """
    share = share_folder()
    with TemporaryDirectory() as folder:
        files = {
            "two_pandas.urdf": _description((share / _URDF).read_text()),
            "two_pandas.srdf": _semantics((_ONE / "panda.srdf").read_text()),
            "joint_limits.yaml": _limits((_ONE / "joint_limits.yaml").read_text()),
        }
        for name, text in files.items():
            (Path(folder) / name).write_text(text)
        urdf, srdf, limits = (Path(folder) / name for name in files)
        return to.Robot.from_urdf(urdf, srdf=srdf, limits=limits, package_dirs=(share,), name="two_pandas")


def _twice(text: str) -> list[ElementTree.Element]:
    """Return the elements of a description for each side, their names with the side in front."""
    elements: list[ElementTree.Element] = []
    for side in _SIDES:
        for element in ElementTree.fromstring(text):
            for item in element.iter():
                for name in _NAMES.get(item.tag, ()):
                    if name in item.attrib:
                        item.attrib[name] = f"{side}_{item.attrib[name]}"
            elements.append(element)
    return elements


def _description(text: str) -> str:
    """Return the URDF of both from that of one."""
    robot = ElementTree.Element("robot", name="two_pandas")
    ElementTree.SubElement(robot, "link", name="base")
    for side, y in _SIDES.items():
        stand = ElementTree.SubElement(robot, "joint", name=f"{side}_stand", type="fixed")
        ElementTree.SubElement(stand, "parent", link="base")
        ElementTree.SubElement(stand, "child", link=f"{side}_panda_link0")
        ElementTree.SubElement(stand, "origin", xyz=f"0 {y} 0", rpy="0 0 0")
    robot.extend(_twice(text))
    return ElementTree.tostring(robot, encoding="unicode")


def _semantics(text: str) -> str:
    """Return the SRDF of both from that of one, with the group of both arms and its state."""
    robot = ElementTree.Element("robot", name="two_pandas")
    robot.extend(element for element in _twice(text) if element.tag != "virtual_joint")
    both = ElementTree.SubElement(robot, "group", name="both")
    ready = ElementTree.SubElement(robot, "group_state", name="ready", group="both")
    for side in _SIDES:
        ElementTree.SubElement(both, "group", name=f"{side}_panda_arm")
        ready.extend(robot.findall(f"group_state[@name='{side}_ready']/joint"))
    return ElementTree.tostring(robot, encoding="unicode")


def _limits(text: str) -> str:
    """Return the joint limits of both from those of one."""
    joints = text.partition("joint_limits:\n")[2]
    return "joint_limits:\n" + "".join(
        re.sub(r"^  (panda_\w+):", rf"  {side}_\1:", joints, flags=re.MULTILINE) for side in _SIDES
    )
