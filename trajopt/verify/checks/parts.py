"""Checks of what has to hold on a part of the motion only: the judge cuts the part out and judges that."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeVar

from trajopt.problem.requirements import During
from trajopt.verify.certificate import Check, Evidence
from trajopt.verify.checks.waypoints import Passage
from trajopt.verify.kernel.motion import Motion

Required = TypeVar("Required")
_SHORTEST = 1e-6
"""How long a part is examined whose two moments coincide [s]."""


def part_checks(
    part: During[Required],
    motion: Motion,
    passed: Mapping[str, Passage],
    check: Callable[[Required, Motion], tuple[Check, ...]],
) -> tuple[Check, ...]:
    """Judge what has to hold between two stops, at the moments at which these are passed.

    Args:
        part: What, and from which waypoint to which.
        motion: The whole motion.
        passed: The waypoints, by name.
        check: Judges it on a motion.

    Raises:
        KeyError: If a waypoint is not among those passed.
    """
    missed = [name for name in (part.after, part.until) if name is not None and not passed[name].holds]
    if missed:
        return (
            Check(
                name=f"path: {part.part}",
                subject="",
                value=None,
                bound=None,
                unit="",
                time=None,
                slack=None,
                evidence=Evidence.SAMPLED,
                holds=False,
                detail=f"waypoint {missed[0]} is not passed",
            ),
        )
    begin = 0.0 if part.after is None else passed[part.after].time
    end = motion.duration if part.until is None else passed[part.until].time
    begin = min(begin, motion.duration - _SHORTEST)
    end = max(end, begin + _SHORTEST)
    return tuple(
        replace(
            item,
            name=f"{item.name} {part.part}",
            time=None if item.time is None else item.time + begin,
            detail=f"{item.detail} (times from {begin:.3f} s on)",
        )
        for item in check(part.required, motion.between(begin, end))
    )
