"""Two Pandas in one scene: they carry a tray together, and bring their hands together."""

import numpy as np

import trajopt as to

from .arms import two_pandas
from .drawing import drawn, near

LEFT, RIGHT = "left_panda_hand_tcp", "right_panda_hand_tcp"
SPAN = 0.4
"""Distance of the two hands at the tray [m]."""
TILT = np.radians(5.0)
"""Largest angle between the tray and the horizontal plane [rad]."""


def two_arms_tray(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem: two Pandas carry a tray over a wall and keep it level.

    What is hard: one hand is placed relative to the other all the way, within two millimetres and
    half a degree, which takes six of fourteen joints' freedom at every moment; the straight line
    in joint space tears the tray and goes through the wall.

    Args:
        rng: Draws wall, start and goal; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(_tray, rng)


def two_arms_meet(rng: np.random.Generator | None = None) -> to.Problem:
    """Return the problem: two Pandas bring their hands face to face, wherever that is easiest.

    What is hard: the goal places one moving hand relative to the other and neither in the world, and a
    pillar stands in the middle.

    Args:
        rng: Draws the pillar and the distance of the hands; the fixed instance when None.

    Expected outcome: solved.
    """
    return drawn(_meet, rng)


def _tray(rng: np.random.Generator | None) -> to.Problem:
    arms = two_pandas()
    wall = near(rng, 0.22, 0.04)
    scene = (
        to.Scene(arms.robot)
        .add("table", to.Box(0.9, 2.0, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("wall", to.Box(0.03, 0.4, wall), to.placement((near(rng, 0.46, 0.02), 0.0, wall / 2)))
        .add("tray", to.Box(0.16, SPAN, 0.02), to.placement((0.0, SPAN / 2, 0.01)), frame=LEFT,
             touch_links=arms.hand)
    )  # fmt: skip
    held = to.frame_placement(
        RIGHT,
        to.placement((0.0, SPAN, 0.0)),
        reference=LEFT,
        position_tolerance=2e-3,
        rotation_tolerance=np.radians(0.5),
    )
    level = to.axis_alignment("tray", direction=(0.0, 0.0, -1.0), tolerance=TILT)

    def place(x: float) -> to.Requirement:
        return to.frame_placement(
            "tray",
            to.placement((x, near(rng, 0.0, 0.06), near(rng, 0.12, 0.03)), rpy=(np.pi, 0.0, 0.0)),
            position_tolerance=2e-3,
            rotation_tolerance=0.03,
        )

    return to.Problem(
        scene=scene,
        group=arms.group,
        start=arms.at(scene, place(near(rng, 0.33, 0.01)), held),
        goal=place(near(rng, 0.6, 0.01)),
        constraints=[held, level],
        name="two arms carry a tray",
    )


def _meet(rng: np.random.Generator | None) -> to.Problem:
    arms = two_pandas()
    pillar = to.placement((near(rng, 0.38, 0.05), near(rng, 0.0, 0.05), 0.5))
    scene = (
        to.Scene(arms.robot)
        .add("table", to.Box(0.9, 2.0, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("pillar", to.Cylinder(0.08, 1.0), pillar)
    )
    face_to_face = to.frame_placement(
        RIGHT,
        to.placement((0.0, 0.0, near(rng, 0.05, 0.02)), rpy=(np.pi, 0.0, 0.0)),
        reference=LEFT,
        position_tolerance=2e-3,
        rotation_tolerance=0.02,
    )
    return to.Problem(
        scene=scene, group=arms.group, start=arms.ready, goal=face_to_face, name="two arms meet"
    )
