"""A planar arm folds to pass a post."""

import numpy as np

import trajopt as to

from .drawing import drawn, near


def planar_fold(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem: an arm of two joints turns past a post that stands within its reach.

    What is hard: with two joints the only way is to fold, pass and unfold; a straight line cannot.

    Args:
        rng: Draws the post, start and goal; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(_problem, rng)


def _problem(rng: np.random.Generator | None) -> to.Problem:
    away, at = near(rng, 0.65, 0.05), near(rng, 0.0, 0.2)
    post = to.placement((away * np.cos(at), away * np.sin(at), 0.1))
    return to.Problem(
        scene=to.Scene(to.load("planar2")).add("post", to.Cylinder(0.04, 0.4), post),
        start={"joint1": near(rng, -1.1, 0.15), "joint2": near(rng, 0.3, 0.15)},
        goal=to.joint_positions({"joint1": near(rng, 0.9, 0.15), "joint2": near(rng, 0.4, 0.15)}),
        name="planar fold",
    )
