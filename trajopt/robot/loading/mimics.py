"""Mimic joints: which joint each follows in the end, and by what factor and offset."""

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np

from trajopt.robot.loading.urdf import Mimic
from trajopt.values.arrays import Floats, floats, readonly, several
from trajopt.values.errors import MimicContradiction, MimicCycle, listed, shown

MIMIC_ERROR = 0.01
"""A measured mimic joint may be this far from where it follows, and is taken to be there [rad | m]."""


def resolve_mimics(
    stated: Mapping[str, Mimic], *, movable: Sequence[str], fixed: frozenset[str]
) -> tuple[Mapping[str, Mimic], tuple[str, ...]]:
    """Trace chains of mimic joints to the joint that leads them.

    Along a chain positions are mapped one after the other, so factors multiply and offsets are carried on.
    A fixed joint stands at zero, so what mimics it stands at its offset; a fixed joint that mimics another
    stands still all the same. A joint that mimics one that the robot does not have moves on its own.

    Args:
        stated: What the URDF says, by mimic joint.
        movable: Names of the joints that move.
        fixed: Names of the joints that do not.

    Returns:
        Mimic joints by name, in the order of `movable`; the source of each mimics no other. Then sentences on
        joints that mimic what the robot does not have.

    Raises:
        MimicCycle: If joints mimic each other in a circle.
    """
    alone: list[str] = []
    moving: dict[str, Mimic] = {}
    for joint, mimic in stated.items():
        if mimic.source not in movable and mimic.source not in fixed:
            alone.append(f"{joint} ({shown(mimic.source)})")
            continue
        _refuse_cycle(joint, stated)
        if joint in movable:
            moving[joint] = mimic
    traced = {joint: _traced(joint, moving) for joint in movable if joint in moving}
    said = "joints move on their own that mimic what the robot does not have"
    return traced, (f"{said}: {listed(alone)}",) if alone else ()


def followed(
    joint_names: Sequence[str],
    mimics: Mapping[str, Mimic],
    positions: Floats,
    *,
    checked: Iterable[str] = (),
) -> Floats:
    """Return positions with each mimic joint where it follows.

    Args:
        joint_names: Names of all joints that move, n of them.
        mimics: Mimic joints by name, each with the joint that leads it.
        positions: Of all joints, shape (n,) [rad | m].
        checked: Mimic joints whose position somebody gave; `MIMIC_ERROR` is accepted.

    Returns:
        Positions, shape (n,), read-only.

    Raises:
        MimicContradiction: If one of those was put elsewhere than where it follows.
    """
    result = np.array(floats("positions", positions, (len(joint_names),)))
    refused = frozenset(several("checked", checked, str))
    for joint, mimic in mimics.items():
        place = joint_names.index(joint)
        # A fixed joint stands at zero.
        source = result[joint_names.index(mimic.source)] if mimic.source in joint_names else 0.0
        asked, follows = float(result[place]), float(mimic.multiplier * source + mimic.offset)
        if joint in refused and not abs(asked - follows) <= MIMIC_ERROR:
            raise MimicContradiction(joint, mimic.source, position=asked, expected=follows)
        result[place] = follows
    return readonly(result)


def completed(
    joint_names: Sequence[str], mimics: Mapping[str, Mimic], positions: Floats, *, given: Collection[str]
) -> Floats:
    """Return positions of which some were given, with the joints that mimic or lead those where they belong.

    Args:
        joint_names: Names of all joints that move, n of them.
        mimics: Mimic joints by name, each with the joint that leads it.
        positions: Of all joints, shape (n,) [rad | m].
        given: Joints whose position stays; the joint that a given mimic joint follows is placed to suit, and
            all other mimic joints follow.

    Returns:
        Positions, shape (n,), read-only.
    """
    result = np.array(positions)
    for joint in given:
        mimic = mimics.get(joint)
        if mimic is not None and mimic.multiplier and mimic.source not in given:
            if mimic.source in joint_names:
                leader = joint_names.index(mimic.source)
                result[leader] = (result[joint_names.index(joint)] - mimic.offset) / mimic.multiplier
    following = {joint: mimic for joint, mimic in mimics.items() if joint not in given}
    return followed(joint_names, following, result)


def _refuse_cycle(joint: str, stated: Mapping[str, Mimic]) -> None:
    passed = [joint]
    while passed[-1] in stated:
        source = stated[passed[-1]].source
        if source in passed:
            raise MimicCycle(passed[passed.index(source) :])
        passed.append(source)


def _traced(joint: str, moving: Mapping[str, Mimic]) -> Mimic:
    found = moving[joint]
    while found.source in moving:
        above = moving[found.source]
        found = Mimic(
            above.source,
            found.multiplier * above.multiplier,
            found.multiplier * above.offset + found.offset,
        )
    return found
