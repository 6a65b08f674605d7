"""Checks of goals, constraints, waypoints and user code."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.problem.requirement import During, Requirement
from trajopt.values.errors import ShapeError, WaypointNotFound, shown
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.checks.criterion import Criterion
from trajopt.verify.checks.quantities import When, check_requirement
from trajopt.verify.checks.waypoints import part_checks, passages
from trajopt.verify.kernel.motion import Motion, sampled_times
from trajopt.verify.specification import SampledCheck, Specification


def sampled_check(check: SampledCheck, motion: Motion) -> Check:
    """Judge a constraint in user code at samples.

    Raises:
        ShapeError: If it does not return numbers of the right shape.
    """
    times = sampled_times(motion)
    returned = check.evaluate(times, motion.trajectory(times))
    try:
        values, lower, upper = (np.asarray(part, dtype=np.float64) for part in returned)
        rows = values.reshape(len(times), -1)
        low, high = (np.broadcast_to(bound, values.shape).reshape(len(times), -1) for bound in (lower, upper))
    except (TypeError, ValueError) as error:
        raise ShapeError(f"values of {shown(check.name)}", f"do not fit {len(times)} samples") from error
    excess = np.maximum(rows - high, low - rows)
    excess = np.where(np.isnan(excess), np.inf, excess)
    row, column = np.unravel_index(int(excess.argmax()), excess.shape)
    above = rows[row, column] - high[row, column] >= low[row, column] - rows[row, column]
    bound = float((high if above else low)[row, column])
    worst = float(excess[row, column])
    return Check(
        kind=CheckKind.USER_CODE,
        name=f"path: {check.name}",
        subject=f"row {column}" if rows.shape[1] > 1 else "",
        value=float(rows[row, column]),
        bound=bound if np.isfinite(bound) else None,
        unit="",
        time=float(times[row]),
        slack=-worst if np.isfinite(worst) else None,
        evidence=Evidence.SAMPLED,
        holds=worst <= motion.options.excess,
        detail=f"user code, {len(times)} samples",
    )


@dataclass(frozen=True, eq=False)
class RequirementCriterion(Criterion):
    """Static goals, constraints, waypoints and requirements between them.

    Attributes:
        motion: Motion.
        specification: Requirements.
        followed: Moving goals, which are judged among dynamic obstacles.
    """

    motion: Motion
    specification: Specification
    followed: Sequence[Requirement]

    def measure(self) -> Iterator[Check]:
        """Return the checks of all requirements."""
        motion, specification = self.motion, self.specification
        still = [goal for goal in specification.goals if not any(goal is each for each in self.followed)]
        for when, requirements in ((When.END, still), (When.ALWAYS, specification.constraints)):
            for requirement in requirements:
                yield from check_requirement(requirement, motion, when)
        yield from _on_the_way(motion, specification.waypoints, specification.partial)
        for check in specification.sampled:
            yield sampled_check(check, motion)


def _on_the_way(
    motion: Motion,
    waypoints: Mapping[str, Sequence[Requirement]],
    partial: Sequence[During[Requirement] | During[SampledCheck]],
) -> list[Check]:
    """Judge waypoints, and the requirements between them."""
    proven: list[During[Requirement]] = []
    sampled: list[During[SampledCheck]] = []
    for part in partial:
        for name in (part.after, part.until):
            if name is not None and name not in waypoints:
                raise WaypointNotFound("waypoint", name, waypoints)
        if isinstance(part.required, Requirement):
            proven.append(During(part.required, part.after, part.until))
        else:
            sampled.append(During(part.required, part.after, part.until))
    passed = passages(motion, waypoints, proven)
    checks = [passage.check for passage in passed.values() if passage.check is not None]
    for part in proven:
        checks += part_checks(part, motion, passed, _always)
    for part in sampled:
        checks += part_checks(part, motion, passed, lambda check, cut: (sampled_check(check, cut),))
    return checks


def _always(requirement: Requirement, motion: Motion) -> tuple[Check, ...]:
    return check_requirement(requirement, motion, When.ALWAYS)
