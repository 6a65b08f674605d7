"""Which requirements seem to exclude each other: an irreducible set, by leaving out one after the other."""

from collections.abc import Sequence

import numpy as np

from trajopt.kinematics.goal_candidates import random_starts
from trajopt.kinematics.projection import Projection
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import Requirement
from trajopt.query import Counts, Query

STARTS = 1024
"""Configurations that each subset is searched from: a set that can be held must not be called a conflict."""


def conflicting(
    reduced: ReducedModel, requirements: Sequence[Requirement], *, rng: np.random.Generator, counts: Counts
) -> tuple[Requirement, ...]:
    """Return requirements of which no configuration was found that holds them together.

    Whichever one is left out, the others can be held together. A single one cannot be held alone.
    Source: the deletion filter of Chinneck and Dravnieks, Locating minimal infeasible constraint sets in
    linear programs, ORSA J. Computing 1991, with the search of goal configurations as its oracle.

    Args:
        reduced: The robot and its limits; collisions are not looked at.
        requirements: What no configuration was found for.
        rng: Draws the starts of the search.
        counts: Takes the work done.
    """
    query, begin = Query(reduced, counts), random_starts(reduced, rng, STARTS)
    kept = list(requirements)
    for item in requirements:
        rest = [other for other in kept if other is not item]
        if rest and (Projection(reduced, rest, query)(begin).violation > 0.0).all():
            kept = rest
    return tuple(kept)
