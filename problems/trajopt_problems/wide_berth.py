"""A hand passes somebody at a distance, and everything else as closely as usual."""

import numpy as np

import trajopt as to

from .arms import panda, pointing
from .drawing import drawn, near

REQUIRED = 0.115
"""Clearance that is required between the person and the wrist with its hand [m]."""
BERTH = 0.12
"""The same with a margin, for the optimiser to keep where it can [m]."""


def wide_berth(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem: a Panda passes between a person, at twelve centimetres, and a post.

    What is hard: the clearance differs by pair, and both things stand beside the same way. The judge proves
    the clearance that is required of the person; of the post it refuses contact only.

    Args:
        rng: Draws person, post, start and goal; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(_problem, rng)


def _problem(rng: np.random.Generator | None) -> to.Problem:
    arm = panda()
    person = (near(rng, 0.72, 0.02), near(rng, 0.0, 0.15), 0.5)
    post = (near(rng, 0.2, 0.02), near(rng, 0.0, 0.05), 0.15)
    scene = (
        to.Scene(arm.robot)
        .add("person", to.Capsule(0.12, 0.9), to.placement(person))
        .add("post", to.Cylinder(0.02, 0.3), to.placement(post))
    )
    for link in (*arm.hand, "panda_link5", "panda_link6", "panda_link7"):
        scene = scene.with_clearance(REQUIRED, link, "person").with_margin(BERTH, link, "person")

    def side(angle: float) -> tuple[to.Requirement, to.Requirement]:
        away = arm.reach + near(rng, 0.05, 0.03)
        point = (away * np.cos(angle), away * np.sin(angle), near(rng, 0.3, 0.08))
        return pointing(arm, point, (0.0, 0.0, -1.0))

    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.at(scene, *side(near(rng, -0.9, 0.1))),
        goal=side(near(rng, 0.9, 0.1)),
        name="wide berth",
    )
