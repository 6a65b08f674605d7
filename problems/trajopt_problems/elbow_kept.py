"""A joint stays where it is, but for a little, while the hand goes elsewhere."""

import numpy as np

import trajopt as to

from .arms import panda, pointing
from .drawing import drawn, near

PLAY = 0.15
"""How far the joint may turn to either side [rad]."""


def elbow_kept(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem: a Panda reaches past a post with its third joint nearly still.

    What is hard: the joint that would swing the elbow around the post is all but taken away, for the
    goal too.

    Args:
        rng: Draws post, start and goal; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(_problem, rng)


def _problem(rng: np.random.Generator | None) -> to.Problem:
    arm = panda()
    away, at = near(rng, 0.5, 0.03), near(rng, 0.0, 0.15)
    post = to.placement((away * np.cos(at), away * np.sin(at), 0.3))
    scene = to.Scene(arm.robot).add("post", to.Cylinder(0.03, 0.6), post)
    kept = to.joint_positions({"panda_joint3": 0.0}, tolerance=PLAY)

    def side(angle: float) -> tuple[to.Requirement, to.Requirement]:
        point = (arm.reach * np.cos(angle), arm.reach * np.sin(angle), near(rng, 0.35, 0.1))
        return pointing(arm, point, (0.0, 0.0, -1.0))

    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, *side(near(rng, -0.8, 0.15)), kept),
        goal=side(near(rng, 0.8, 0.15)),
        constraints=[kept],
        name="elbow kept",
    )
