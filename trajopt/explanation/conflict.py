"""Which requirements and obstacles exclude each other at the goal: an irreducible set of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from trajopt.explanation.asked import always_at_end
from trajopt.explanation.nearest import least_missed
from trajopt.infeasibility.reasons import Block, BlockKind
from trajopt.model.requirements import Requirement
from trajopt.problem import Problem


@dataclass(frozen=True, eq=False)
class _Obstacle:
    """A thing of the scene that must be kept clear of."""

    name: str

    def __str__(self) -> str:
        return f"clearance from {self.name}"


def conflict_at_goal(problem: Problem, blocks: Sequence[Block]) -> tuple[str, ...]:
    """Return what cannot be held together at the goal; whichever is left out, the rest can.

    Joint limits and the robot's clearance from itself always count. The deletion filter of
    `trajopt.planning.seeds.conflicting`, here with obstacles among what is left out.

    Args:
        problem: The problem; no free configuration was found that holds its goals.
        blocks: What is in contact where the goal is held, the most likely obstacles first.

    Returns:
        The set in words; empty if the rest of the scene is in the way in more ways than one.
    """
    touched = {name for block in blocks if block.kind is BlockKind.CONTACT for name in block.subjects}
    near = [_Obstacle(name) for name in problem.scene.objects if name in touched]
    kept: list[Requirement | _Obstacle] = [*problem.goals, *always_at_end(problem), *near]
    if _can_be_held(problem, kept):
        return ()
    for item in tuple(kept):
        rest = [other for other in kept if other is not item]
        if not _can_be_held(problem, rest):
            kept = rest
    return tuple(str(item) for item in kept)


def _can_be_held(problem: Problem, kept: Sequence[Requirement | _Obstacle]) -> bool:
    """Say whether a configuration was found that holds requirements, clear of some obstacles only."""
    obstacles = {item.name for item in kept if isinstance(item, _Obstacle)}
    scene = problem.scene
    for name in scene.objects:
        if name not in obstacles:
            scene = scene.allow(name)
    requirements = [item for item in kept if isinstance(item, Requirement)]
    return least_missed(replace(problem, scene=scene), (), hard=requirements) is not None
