"""A table with a cup, and the Panda before it."""

import pytest

import trajopt as to
from trajopt.tasks.grasping import Grasp, Place, grasps_of, gripper_of


@pytest.fixture(scope="session")
def cell() -> to.Scene:
    return (
        to.Scene(to.load("panda"))
        .add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("cup", to.Cylinder(radius=0.03, length=0.12), to.placement((0.5, -0.2, 0.06)), mass=0.2)
    )


@pytest.fixture(scope="session")
def grasps(cell: to.Scene) -> tuple[Grasp, ...]:
    return grasps_of(cell, "cup", gripper_of(cell.robot))


@pytest.fixture
def there() -> Place:
    return Place(placement=to.placement((0.5, 0.25, 0.06)))
