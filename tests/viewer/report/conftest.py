"""Two joints in the plane: a plan, one among what moves, a failure; and names that are no names."""

from pathlib import Path

import pytest

import trajopt as to
from trajopt.files.bundle import Bundle, read_bundle

HOSTILE = '</script><script>window.hacked = 1</script><img src=x onerror="window.hacked = 1">&"\''
"""A name that would do something, if any text of a page were not escaped."""


def problem(name: str, scene: to.Scene, *, goal: float = 1.4) -> to.Problem:
    return to.Problem(scene=scene, start=[0.0, 0.4], goal={"joint1": goal, "joint2": 0.4}, name=name)


@pytest.fixture(scope="session")
def planar() -> to.Scene:
    return to.Scene(to.load("planar2"))


@pytest.fixture(scope="session")
def plan(planar: to.Scene) -> to.Result:
    """Past a ball with a hostile name, in a problem with one."""
    scene = planar.add(HOSTILE, to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
    return to.plan(problem(HOSTILE, scene))


@pytest.fixture(scope="session")
def among(planar: to.Scene) -> to.Result:
    """While a ball passes by."""
    track = to.Track.constant_velocity(to.placement((0.5, 1.3, 0.1)), (-0.6, 0.0, 0.0), end=5.0)
    return to.plan(problem("a ball passes", planar.add("passing", to.Sphere(0.1), motion=track)))


@pytest.fixture(scope="session")
def failure(planar: to.Scene) -> to.Result:
    """Into a ball."""
    scene = planar.add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
    return to.plan(problem("into a ball", scene, goal=0.6))


@pytest.fixture(scope="session")
def kept(plan: to.Result, tmp_path_factory: pytest.TempPathFactory) -> Bundle:
    """The bundle of the plan."""
    path: Path = tmp_path_factory.mktemp("kept") / "plan.trajopt"
    plan.save(path)
    return read_bundle(path)
