"""A warehouse, and something to keep in it."""

from collections.abc import Iterator
from pathlib import Path

import pytest

import trajopt as to
from trajopt.planning import Result
from trajopt.server.warehouse import Warehouse


@pytest.fixture(scope="session")
def cell() -> to.Scene:
    """Two joints in the plane, beside a ball."""
    return to.Scene(to.load("planar2")).add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))


@pytest.fixture(scope="session")
def asked(cell: to.Scene) -> to.Problem:
    return to.Problem(scene=cell, start=[0.0, 0.4], goal={"joint1": 1.4, "joint2": 0.4}, name="past a ball")


@pytest.fixture(scope="session")
def solved(asked: to.Problem) -> Result:
    return to.plan(asked)


@pytest.fixture(scope="session")
def failed(cell: to.Scene) -> Result:
    """The ball stands where the arm is to go."""
    scene = cell.move("ball", to.placement((0.2, 0.6, 0.1)))
    result = to.plan(to.Problem(scene=scene, start=[0.0, 0.4], goal={"joint1": 1.2, "joint2": 0.1}))
    assert not result.verified
    return result


@pytest.fixture
def kept(tmp_path: Path) -> Iterator[Warehouse]:
    with Warehouse(tmp_path / "cell.warehouse") as warehouse:
        yield warehouse
