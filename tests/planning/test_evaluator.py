"""Planning works with any evaluator of placements and distances, which the problem makes."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.planning.walls import wall
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Contacts, Evaluator, JointPlacements, WorkCounts, evaluator
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.errors import ModelError


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


@dataclass(eq=False)
class Recorder:
    """An evaluator of another class, which notes how many configurations each call has."""

    native: Evaluator
    sizes: list[int]

    def __post_init__(self) -> None:
        self.reduced, self.counts = self.native.reduced, self.native.counts

    @property
    def dynamics(self) -> DynamicsQuery:
        return self.native.dynamics

    def kinematics(self, positions: Floats) -> JointPlacements:
        self.sizes.append(len(positions))
        return self.native.kinematics(positions)

    def close_pairs(self, positions: Floats, reach: Floats, aim: Floats | None = None) -> Contacts:
        self.sizes.append(len(positions))
        return self.native.close_pairs(positions, reach, aim)

    def displacement(self, start: Floats, end: Floats) -> Floats:
        return self.native.displacement(start, end)


@dataclass(eq=False)
class Recorders:
    """Makes recorders, which share their notes."""

    sizes: list[int] = field(default_factory=list[int])

    def __call__(self, reduced: ReducedModel, counts: WorkCounts | None = None, /) -> Recorder:
        return Recorder(evaluator(reduced, counts), self.sizes)


@pytest.mark.parametrize("moves", [False, True])
def test_planning_uses_the_evaluator_of_the_problem(arm: to.Robot, *, moves: bool) -> None:
    problem, recorders = wall(arm), Recorders()
    if moves:
        track = to.Track.constant_velocity(to.placement((0.5, -0.9, 0.1)), (0.0, 1.5, 0.0))
        scene = problem.scene.add("ball", to.Sphere(0.1), motion=track)
        problem = replace(problem, scene=scene)
    native = to.plan(problem).require().trajectory
    other = to.plan(replace(problem, evaluator=recorders)).require()
    assert max(recorders.sizes) > problem.knots, "all samples of a motion are evaluated in one call"
    assert np.isclose(other.trajectory.duration, native.duration, rtol=0.05)
    assert to.judge(problem, other.trajectory).verified


def test_an_evaluator_of_the_caller_is_code_that_no_file_holds(arm: to.Robot, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="evaluator"):
        replace(wall(arm), evaluator=Recorders()).save(tmp_path / "problem.zip")
