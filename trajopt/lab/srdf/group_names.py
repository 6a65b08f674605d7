"""Names of groups as a person would choose them: `panda_arm`, `hand`, `left_arm`, `head`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from trajopt.robot.loading.groups import words

ARM, HAND, GRIPPER, TORSO, WHEEL = "arm", "hand", "gripper", "torso", "wheel"
BODY_PARTS: Mapping[str, frozenset[str]] = {
    "head": frozenset(("head", "neck")),
    TORSO: frozenset((TORSO, "waist", "spine")),
    "leg": frozenset(("leg", "hip", "thigh", "knee", "calf", "ankle", "foot")),
    "finger": frozenset(("finger", "thumb")),
}
"""Words in the names of joints by the part of the body that they move."""
WHEELS = frozenset((WHEEL, "caster"))
"""Words in the names of links and joints of a base on wheels."""
SIDES: Mapping[str, frozenset[str]] = {"left": frozenset(("left", "l")), "right": frozenset(("right", "r"))}
"""Words in the names of joints by the side of the body."""
GENERAL = frozenset(("joint", "joints", "link"))
"""Words in names of joints that tell nothing."""
ARM_JOINTS = 2
"""A chain with fewer driven joints is not an arm."""


@dataclass
class UniqueNames:
    """Names that are given once; a second one of the same name gets a number."""

    counts: dict[str, int]

    def take(self, name: str) -> str:
        """Return a name that was not given yet."""
        self.counts[name] = self.counts.get(name, 0) + 1
        return name if self.counts[name] == 1 else f"{name}_{self.counts[name]}"


def body_part(joints: Sequence[str]) -> str:
    """Return the part of a robot that joints move: wheel, head, torso, leg, arm; empty if not known."""
    if any(words(joint) & WHEELS for joint in joints):
        return WHEEL
    for part, known in BODY_PARTS.items():
        if all(words(joint) & known for joint in joints):
            return part
    return ARM if len(joints) >= ARM_JOINTS else ""


def chain_name(joints: Sequence[str]) -> str:
    """Return the name of a chain after the part that its joints move, their side, or their shared words."""
    part = body_part(joints)
    for side, known in SIDES.items():
        if all(words(joint) & known for joint in joints):
            return f"{side}_{part}" if part else f"{side}_{_shared(joints, GENERAL | known) or 'joint'}"
    if part and part != ARM:
        return part
    prefix = _shared(joints, GENERAL | {ARM})
    return "_".join(each for each in (prefix, part) if each) or "joint"


def gripper_name(palm: str, carrier: str, *, alone: bool) -> str:
    """Return the name of a gripper.

    Args:
        palm: The link that carries the fingers.
        carrier: Name of the arm that carries it.
        alone: Whether the robot has one arm only.
    """
    kind = HAND if HAND in words(palm) else GRIPPER
    side = "" if alone else carrier.removesuffix(ARM).strip("_")
    return f"{side}_{kind}" if side else kind


def _shared(joints: Sequence[str], left_out: frozenset[str]) -> str:
    """Return the leading words that all names share, the last word of several names aside."""
    split = [joint.split("_") for joint in joints]
    columns = (
        zip(*(each[:-1] for each in split), strict=False) if len(split) > 1 else zip(*split, strict=True)
    )
    shared: list[str] = []
    for column in columns:
        if len(set(column)) > 1:
            break
        shared.append(column[0])
    return "_".join(word for word in shared if word.lower() not in left_out)
