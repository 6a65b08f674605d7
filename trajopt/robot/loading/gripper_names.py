"""What names say of grippers: files mark fingers by nothing else."""

import re

FINGERS = ("finger", "thumb", "jaw", "claw", "knuckle", "pincer")
"""Parts of names of what opens and closes."""
WHOLE = "gripper"
"""Part of names of a gripper as a whole, which a wrist may turn."""
TURNS = frozenset(("wrist", "roll", "pitch", "yaw", "rotate", "rotation", "swivel"))
"""Words in the name of a joint that turns a whole gripper."""


def words(name: str) -> frozenset[str]:
    """Return the words of a name like "left_hand" or "jointGripper", in lower case."""
    return frozenset(word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name))


def names_fingers(joint: str, link: str) -> bool:
    """Say whether a joint opens and closes a gripper by its name or by that of the link that it moves."""
    if any(part in name.lower() for name in (joint, link) for part in FINGERS):
        return True
    return WHOLE in joint.lower() and not words(joint) & TURNS


def names_gripper(link: str) -> bool:
    """Say whether a link is a gripper, a hand or a part of one by its name."""
    return any(part in link.lower() for part in (WHOLE, *FINGERS)) or "hand" in words(link)
