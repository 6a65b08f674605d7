"""Mimic joints: the leading joint of each, with factor and offset."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from trajopt.robot.joints import JointLimits, LimitKind
from trajopt.robot.loading.urdf import Mimic
from trajopt.values.arrays import Floats, floats, readonly, several
from trajopt.values.errors import MimicContradiction, MimicCycle, MimicOutOfRange, listed, shown

MIMIC_ERROR = 0.01
"""Accepted error of a measured mimic joint [rad | m]."""


def resolve_mimics(
    stated: Mapping[str, Mimic], *, movable: Sequence[str], fixed: frozenset[str]
) -> tuple[Mapping[str, Mimic], tuple[str, ...]]:
    """Trace chains of mimic joints to their leading joint.

    Along a chain factors multiply and offsets accumulate. A fixed joint is at zero, so its mimic is at the
    offset. A mimic of an unknown joint moves on its own.

    Returns:
        Mimic joints by name, in the order of `movable`, each with a source that mimics no other; and notes on
        mimics of unknown joints.
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
    said = "joints that mimic a missing joint move on their own"
    return traced, (f"{said}: {listed(alone)}",) if alone else ()


def followed(
    joint_names: Sequence[str],
    mimics: Mapping[str, Mimic],
    positions: Floats,
    *,
    checked: Iterable[str] = (),
) -> Floats:
    """Return positions (n,), read-only, with mimic joints as implied; `checked` ones must agree with it."""
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
    """Return positions (n,), read-only, in which mimic joints and their leaders fit the given joints."""
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


ROUNDING = 1e-9
"""Accepted excess of a constant mimic joint beyond its range [rad | m]."""


def followed_limits(limits: JointLimits, joints: tuple[str, ...], mimics: Mapping[str, Mimic]) -> JointLimits:
    """Tighten limits of joints so that their mimic joints stay within their own."""
    places = np.array([limits.joint_names.index(joint) for joint in joints], dtype=np.int64)
    found = limits.take(places)
    for joint, mimic in mimics.items():
        if mimic.source in joints:
            found = _tightened(found, limits, joint, mimic)
    return found


def _tightened(found: JointLimits, limits: JointLimits, joint: str, mimic: Mimic) -> JointLimits:
    place, own = found.joint_names.index(mimic.source), limits.joint_names.index(joint)
    lower, upper = float(limits.lower[own]), float(limits.upper[own])
    if mimic.multiplier == 0.0:
        if not lower - ROUNDING <= mimic.offset <= upper + ROUNDING:
            why = f"is always at {mimic.offset:g}, outside its range [{lower:g}, {upper:g}]"
            raise MimicOutOfRange(joint, mimic.source, why)
        return found
    size = abs(mimic.multiplier)
    least, most = sorted((end - mimic.offset) / mimic.multiplier for end in (lower, upper))
    candidates = (
        (LimitKind.LOWER, found.lower, least),
        (LimitKind.UPPER, found.upper, most),
        (LimitKind.VELOCITY, found.velocity, float(limits.velocity[own]) / size),
        (LimitKind.ACCELERATION, found.acceleration, float(limits.acceleration[own]) / size),
        (LimitKind.JERK, found.jerk, float(limits.jerk[own]) / size),
    )
    changed = {kind.value: np.array(array) for kind, array, _ in candidates}
    binding = dict(found.binding)
    for kind, array, limit in candidates:
        if limit > array[place] if kind is LimitKind.LOWER else limit < array[place]:
            changed[kind.value][place] = limit
            binding[mimic.source, kind] = joint
    if least > found.upper[place] or most < found.lower[place]:
        why = (
            f"must stay in [{lower:g}, {upper:g}], but no position of {mimic.source} in "
            f"[{found.lower[place]:g}, {found.upper[place]:g}] has it there"
        )
        raise MimicOutOfRange(joint, mimic.source, why)
    return replace(
        found,
        lower=readonly(changed["lower"]),
        upper=readonly(changed["upper"]),
        velocity=readonly(changed["velocity"]),
        acceleration=readonly(changed["acceleration"]),
        jerk=readonly(changed["jerk"]),
        binding=binding,
    )
