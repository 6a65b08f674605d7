"""Margins that no configuration can keep: they give way before planning begins, and are named."""

from dataclasses import replace

import numpy as np

from trajopt.geometry import Counts, Query
from trajopt.optimise.transcription.margins import shrinkable
from trajopt.planning.budget import BudgetTracker
from trajopt.planning.infeasibility import ClosedCut, closed_cut, never_apart
from trajopt.problem.problem import Problem
from trajopt.scene.scene import DEFAULT_MARGIN

MIDDLE = (0.5, 0.25, 0.75)
"""Where between start and goal joints are cut: nearer to the ends a margin may not have its full size yet."""


def with_possible_margins(problem: Problem, tracker: BudgetTracker) -> tuple[Problem, tuple[str, ...]]:
    """Return the problem with the default margin for pairs that no configuration takes as far as theirs.

    A margin is a wish: what no motion could keep must not keep a motion from being found.

    Args:
        problem: The problem.
        tracker: Counts the work.

    Returns:
        The problem itself where there are none, and a sentence on each pair.
    """
    reduced = problem.reduced
    pairs, asked_for = reduced.pairs, ~shrinkable(reduced.pairs)
    if not asked_for.any():
        return problem, ()
    counts = Counts()
    with tracker.stage("examine"):
        near = Query(reduced, counts).close_pairs(
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
    """Look for a place that every motion has to pass, and where none keeps the margins asked for."""
    pairs = problem.reduced.pairs
    asked_for = ~shrinkable(pairs)
    if not asked_for.any():
        return None
    return closed_cut(problem, apart=np.where(asked_for, pairs.margin, -np.inf), shares=MIDDLE)
