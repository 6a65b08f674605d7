"""Random shelves with objects, and cameras that see them, for the benchmark of perception."""

from dataclasses import dataclass

import numpy as np
from trajopt_problems.furniture import WALL, shelf

import trajopt as to
from trajopt.lab.perception import Camera, DepthNoise, Intrinsics, Workspace, looking_at

VGA = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)
"""A usual depth camera."""
NOISE = DepthNoise(constant=0.001, quadratic=0.0019)
"""Noise of a camera that projects a pattern (Khoshelham 2012); a millimetre for near points."""
SPACING, DEPTH, WIDTH, LEVELS = 0.32, 0.28, 0.8, 3
EYES = ((0.25, 0.38, 0.75), (0.25, -0.38, 0.75), (0.3, 0.0, 0.5), (0.3, 0.0, 0.95))
"""From where the camera on the hand looks [m]."""
MIDDLE = (0.7, 0.0, 0.5)
"""What it looks at [m]."""
EYE = Camera(VGA, "panda_hand", to.placement((0.06, 0.0, 0.03), rpy=(0.0, 0.0, np.pi / 2)), 0.15, 3.0, NOISE)


@dataclass(frozen=True, eq=False)
class Shelf:
    """An unknown shelf.

    Attributes:
        truth: The robot and all there is.
        empty: The robot alone, which is all that is known.
        goal: Where the hand has to be, before a thing.
        workspace: Where the shelf may be.
    """

    truth: to.Scene
    empty: to.Scene
    goal: tuple[to.Requirement, to.Requirement]
    workspace: Workspace


def room(scene: to.Scene) -> to.Scene:
    """Return a scene in a room, whose walls the camera measures behind everything."""
    scene = scene.add("floor", to.Box(4.0, 4.0, 0.02), to.placement((0.0, 0.0, -0.02)))
    scene = scene.add("back", to.Box(0.02, 4.0, 3.0), to.placement((1.5, 0.0, 1.5)))
    for name, side in (("left", 1.3), ("right", -1.3)):
        scene = scene.add(name, to.Box(4.0, 0.02, 3.0), to.placement((0.0, side, 1.5)))
    return scene


def random_shelf(robot: to.Robot, rng: np.random.Generator) -> Shelf:
    """Draw a shelf before the robot, two or three things in each storey, and one of them to reach for."""
    turn = rng.uniform(-0.25, 0.25)
    stands = to.placement(rpy=(0.0, 0.0, turn)) * to.placement((rng.uniform(0.5, 0.58), 0.0, 0.0))
    empty = to.Scene(robot)
    parts = shelf(width=WIDTH, depth=DEPTH, levels=LEVELS, spacing=SPACING)
    truth = room(empty).add("shelf", parts, stands)
    reached: list[np.ndarray] = []
    for level in range(LEVELS):
        floor = WALL + level * (SPACING + WALL)
        for count, y in enumerate(rng.choice((-0.28, -0.09, 0.1, 0.29), rng.integers(2, 4), replace=False)):
            height, at = (
                rng.uniform(0.06, 0.22),
                np.array((rng.uniform(0.1, 0.2), y + rng.uniform(-0.03, 0.03), floor)),
            )
            if rng.random() < 0.5:
                thing = to.Box(rng.uniform(0.04, 0.1), rng.uniform(0.04, 0.1), height)
            else:
                thing = to.Cylinder(rng.uniform(0.025, 0.045), height)
            up = np.array((0.0, 0.0, height / 2 + 1e-3))
            truth = truth.add(f"thing {level}{count}", thing, stands * to.placement(at + up))
            if level < 2:
                reached.append(np.array((-0.02, at[1], floor + 0.16)))
    before = stands * reached[int(rng.integers(len(reached)))]
    goal = (
        to.frame_placement(
            "panda_hand_tcp", to.placement(before), position_tolerance=0.01, rotation_tolerance=np.inf
        ),
        to.axis_alignment(
            "panda_hand_tcp", direction=(float(np.cos(turn)), float(np.sin(turn)), 0.0), tolerance=0.3
        ),
    )
    workspace = Workspace((0.35, -0.55, 0.0), (1.0, 0.55, 1.1))
    return Shelf(truth, empty, goal, workspace)


def looks(robot: to.Robot) -> list[np.ndarray]:
    """Return where the arm stands to look, positions of all joints [rad | m].

    Raises:
        TrajoptError: If it cannot stand so.
    """
    scene = to.Scene(robot).add("eye", [], EYE.placement, frame=EYE.frame)
    found: list[np.ndarray] = []
    for eye in EYES:
        where = looking_at(np.array(eye), np.array(MIDDLE))
        goal = to.frame_placement("eye", where, position_tolerance=0.02, rotation_tolerance=(0.1, 0.1, 0.6))
        problem = to.Problem(scene=scene, group="panda_arm", start="ready", goal=goal)
        configurations = to.goal_configurations(problem)
        if not configurations:
            raise to.TrajoptError(f"the arm cannot look from {eye}")
        found.append(problem.reduced.all_positions(configurations[0]))
    return found
