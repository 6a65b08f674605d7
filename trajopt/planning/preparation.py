"""Preparation of a problem: margins that no configuration can keep give way, and long turns are named."""

from dataclasses import replace

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.optimise.transcription.margins import shrinkable
from trajopt.planning.budget import BudgetTracker
from trajopt.planning.infeasibility import ClosedCut, closed_cut, never_apart
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import JointPositions
from trajopt.robot.joints import joint_unit
from trajopt.scene.scene import DEFAULT_MARGIN
from trajopt.values.printed import in_degrees

MIDDLE = (0.5, 0.25, 0.75)
"""Shares of the way from start to goal at which joints are cut: nearer to the ends a margin may be
reduced.
"""


def with_possible_margins(problem: Problem, tracker: BudgetTracker) -> tuple[Problem, tuple[str, ...]]:
    """Return the problem with the default margin for pairs whose requested margin no configuration keeps.

    A margin is a wish: an impossible one must not prevent a motion.

    Args:
        problem: The problem.
        tracker: Counts the work.

    Returns:
        The problem itself if there are none, and a sentence on each pair.
    """
    reduced = problem.reduced
    pairs, asked_for = reduced.pairs, ~shrinkable(reduced.pairs)
    if not asked_for.any():
        return problem, ()
    counts = WorkCounts()
    with tracker.stage("examine"):
        near = problem.evaluator(reduced, counts).close_pairs(
            reduced.start_positions[None], np.where(asked_for, pairs.margin, -np.inf)
        )
        asked = {reduced.owners(pair): float(pairs.margin[pair]) for pair in sorted(near.pair.tolist())}
        found = never_apart(reduced, asked, counts)
    tracker.count_work(counts)
    scene = problem.scene
    for item in found:
        scene = scene.with_margin(min(DEFAULT_MARGIN, item.distance), item.first, item.second)
    words = tuple(item.words("of margin are asked of") + ": they have the default margin" for item in found)
    return (replace(problem, scene=scene), words) if found else (problem, ())


def margin_cut(problem: Problem) -> ClosedCut | None:
    """Look for a place that every motion has to pass and that violates the requested margins."""
    pairs = problem.reduced.pairs
    asked_for = ~shrinkable(pairs)
    if not asked_for.any():
        return None
    return closed_cut(problem, apart=np.where(asked_for, pairs.margin, -np.inf), shares=MIDDLE)


TURN = 2.0 * np.pi


def long_turns(problem: Problem) -> tuple[str, ...]:
    """Return a sentence on each joint without limits whose goal is more than half a turn away.

    The goal is kept, since turns may be intended, as when a cable is unwound; but the same
    angle is nearer.

    Args:
        problem: The problem; of a goal set each goal is considered.
    """
    found: dict[str, None] = {}
    start, turning = _turning(problem)
    for one in problem.alternatives.values() or (problem,):
        for goal in one.goals:
            if not isinstance(goal, JointPositions):
                continue
            for joint in turning.intersection(goal.positions):
                way = goal.positions[joint] - start[joint]
                slack = goal.above[joint] if way < 0.0 else goal.below[joint]
                if abs(way) - slack > np.pi:
                    near = goal.positions[joint] - TURN * round(way / TURN)
                    found[
                        f"{joint} is asked to turn by {in_degrees(abs(way))}: {near:.4g} rad is the same "
                        f"angle, {in_degrees(abs(near - start[joint]))} away"
                    ] = None
    return tuple(sorted(found))


def _turning(problem: Problem) -> tuple[dict[str, float], set[str]]:
    """Return the start of the group's joints, and which of them turn without limits."""
    reduced = problem.reduced
    free = np.isinf(reduced.limits.lower) & np.isinf(reduced.limits.upper)
    return (
        dict(zip(reduced.joint_names, reduced.start_positions.tolist(), strict=True)),
        {
            name
            for name, without in zip(reduced.joint_names, free.tolist(), strict=True)
            if without and joint_unit(problem.scene.robot.model, name) == "rad"
        },
    )
