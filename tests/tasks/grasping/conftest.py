"""The Panda, its gripper, and a table with something to take."""

import numpy as np
import pytest

import trajopt as to
from trajopt.tasks.grasping import Gripper, gripper_of
from trajopt.values.shapes.shapes import Convex, Shape

STOOD = to.placement((0.5, -0.2, 0.05), rpy=(0.0, 0.0, 0.3))
FUNCTIONS = to.placement((0.45, 0.25, 0.05))
BLOCK = to.Box(0.05, 0.06, 0.1)
Parts = list[tuple[Shape, to.Placement]]
POST, FOOT = to.Box(0.04, 0.04, 0.1), to.Box(0.08, 0.04, 0.03)
ANGLE: Parts = [(POST, to.placement()), (FOOT, to.placement((0.04, 0.0, -0.035)))]
"""An L of two boxes."""


@pytest.fixture(scope="session")
def panda() -> to.Robot:
    return to.load("panda")


@pytest.fixture(scope="session")
def gripper(panda: to.Robot) -> Gripper:
    return gripper_of(panda)


def on_table(robot: to.Robot, shape: Shape | Parts, where: to.Placement, mass: float = 0.3) -> to.Scene:
    """A table with its top at z = 0, and a thing."""
    return (
        to.Scene(robot)
        .add("table", to.Box(1.0, 1.6, 0.04), to.placement((0.6, 0.0, -0.02)))
        .add("thing", shape, where, mass=mass)
    )


def drawn(robot: to.Robot, rng: np.random.Generator) -> tuple[to.Scene, to.Placement]:
    """A box or cylinder of a size and mass that a hand takes, and another place on the table."""
    shape: Shape
    if rng.integers(2):
        x, y, z = rng.uniform((0.03, 0.03, 0.04), (0.065, 0.065, 0.14)).tolist()
        shape, height = to.Box(x, y, z), z
    else:
        height = float(rng.uniform(0.05, 0.15))
        shape = to.Cylinder(float(rng.uniform(0.015, 0.033)), height)

    def somewhere() -> to.Placement:
        away, towards = rng.uniform(0.38, 0.62), rng.uniform(-1.1, 1.1)
        point = (away * np.cos(towards), away * np.sin(towards), height / 2)
        return to.placement(point, rpy=(0.0, 0.0, rng.uniform(-np.pi, np.pi)))

    taken, put = somewhere(), somewhere()
    while np.linalg.norm(taken.translation - put.translation) < 0.2:
        put = somewhere()
    return on_table(robot, shape, taken, mass=float(rng.uniform(0.1, 0.6))), put


def hexagonal(across: float, length: float) -> Convex:
    angles = np.pi / 3.0 * np.arange(6)
    ring = across / np.sqrt(3.0) * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    return to.convex(np.vstack([np.column_stack((ring, np.full(6, z))) for z in (-length / 2, length / 2)]))
