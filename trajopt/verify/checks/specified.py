"""What is asked of a motion besides its limits: goals, constraints, waypoints, and what holds in between."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from trajopt.problem.requirements import During, Requirement
from trajopt.values.errors import WaypointNotFound
from trajopt.verify.certificate import Check
from trajopt.verify.checks.criterion import Criterion
from trajopt.verify.checks.parts import part_checks
from trajopt.verify.checks.quantities import check_requirement
from trajopt.verify.checks.requirement import When
from trajopt.verify.checks.sampled import SampledCheck, sampled_check
from trajopt.verify.checks.waypoints import passages
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.specification import Specification


@dataclass(frozen=True, eq=False)
class RequirementCriterion(Criterion):
    """The goals that stand still, constraints, waypoints and what holds between them.

    Attributes:
        motion: The motion.
        specification: What is required.
        followed: The goals that time moves, which are judged among what changes with time.
    """

    motion: Motion
    specification: Specification
    followed: Sequence[Requirement]

    def measure(self) -> Iterator[Check]:
        """Judge one requirement after the other."""
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
    """Judge waypoints, and what has to hold between them."""
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
