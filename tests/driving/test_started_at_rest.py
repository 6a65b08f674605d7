"""A robot at rest has no deadline: a slow plan is driven, and a reason is reported first."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

import trajopt as to
from tests.driving.test_supervisor import CYCLE, kinds, problem
from trajopt.driving import EventKind, IdealExecutor, RobotState, Supervisor, SupervisorOptions
from trajopt.values.errors import ProblemError, ShapeError

__all__ = ["problem"]  # a fixture


@dataclass
class SlowPlanner:
    """The clock of a budget: each time a plan looks at it first in a cycle, time passes for the robot."""

    arm: IdealExecutor
    seconds: float
    due: bool = field(default=False, init=False)

    def __call__(self) -> float:
        if self.due:
            self.due = False
            self.arm.advance(self.seconds)
        return self.arm.now()


def slowly_planned(
    problem: to.Problem, seconds: float, tolerance: float = 1e-6
) -> tuple[IdealExecutor, Supervisor, Callable[[float], None]]:
    arm = IdealExecutor(problem.scene.robot.joint_names, problem.start_positions)
    arm.tolerance[:] = tolerance
    clock = SlowPlanner(arm, seconds)
    supervisor = Supervisor(arm, problem, SupervisorOptions(budget=to.Budget(seconds=30.0, clock=clock)))
    supervisor.go(problem)

    def run(until: float) -> None:
        while supervisor.busy and arm.now() < until:
            clock.due = True
            supervisor.cycle()
            arm.advance(CYCLE)

    return arm, supervisor, run


def test_slow_plan_is_driven_from_rest(problem: to.Problem) -> None:
    _, supervisor, run = slowly_planned(problem, 0.3)
    run(10.0)
    assert kinds(supervisor) == [EventKind.STARTED, EventKind.REACHED]


def test_reason_includes_the_tracking_margin(problem: to.Problem) -> None:
    _, supervisor, run = slowly_planned(problem, 0.3, tolerance=0.02)
    run(3.0)
    assert kinds(supervisor) == [EventKind.NO_PLAN]
    words = supervisor.events[0].words
    assert words.startswith("GOAL_IN_COLLISION")
    assert "required distances include up to 116.8 mm for the tracking tolerance" in words
    assert supervisor.blocked


def test_reason_omits_the_tracking_margin_if_distances_do_not_matter(problem: to.Problem) -> None:
    beyond = to.Problem(
        scene=problem.scene, group=problem.group, start=problem.start_positions, goal={"panda_joint1": 3.5}
    )
    _, supervisor, run = slowly_planned(beyond, 0.0, tolerance=2e-3)
    run(1.0)
    assert kinds(supervisor) == [EventKind.NO_PLAN] and "tolerance" not in supervisor.events[0].words


def test_slow_plan_from_rest_among_moving_objects_is_proven_when_it_begins(problem: to.Problem) -> None:
    """A plan that comes late is proven anew where it begins; if that fails, the next may take longer."""
    track = to.Track.through(
        (0.0, 1.0, 2.0),
        [to.placement(p) for p in ((0.95, 0.19, 0.27), (0.5, 0.19, 0.27), (0.95, 0.19, 0.27))],
    )
    crossing = problem.scene.add("ball", to.Sphere(0.06), motion=track)
    arm, supervisor, run = slowly_planned(problem, 0.3)
    supervisor.see(crossing, 0.0)
    run(10.0)
    assert kinds(supervisor)[-1] is EventKind.REACHED
    assert not {EventKind.MISSED_DEADLINE, EventKind.UNPROVEN_STOP, EventKind.NO_PLAN} & {*kinds(supervisor)}
    assert not np.abs(arm.state().velocities).any()


class Noisy(IdealExecutor):
    """An arm whose sensors measure a speed at rest [rad/s]."""

    noise = 5e-3

    def state(self) -> RobotState:
        found = super().state()
        return replace(found, velocities=found.velocities + self.noise)


def test_noise_of_the_measured_speed_does_not_matter(problem: to.Problem) -> None:
    reduced = problem.reduced
    arm = Noisy(reduced.joint_names, reduced.start_positions)
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    while supervisor.busy and arm.now() < 20.0:
        supervisor.cycle()
        arm.advance(CYCLE)
    assert kinds(supervisor)[-1] is EventKind.REACHED
    arm.noise = 0.05
    with pytest.raises(ProblemError, match="the robot is moving"):
        Supervisor(arm, problem)


@pytest.mark.parametrize("name", ["positions", "velocities", "commanded"])
@pytest.mark.parametrize("wrong", [np.zeros(0), np.full(9, np.nan)])
def test_a_driver_that_measures_wrong_states_is_refused(
    problem: to.Problem, name: str, wrong: np.ndarray
) -> None:
    class Wrong(IdealExecutor):
        def state(self) -> RobotState:
            return replace(super().state(), **{name: wrong})

    arm = Wrong(problem.scene.robot.joint_names, problem.start_positions)
    with pytest.raises(ShapeError, match=rf"^Executor.state\(\).{name}: "):
        Supervisor(arm, problem)


def test_motions_that_would_always_be_late_are_refused(problem: to.Problem) -> None:
    arm = IdealExecutor(problem.scene.robot.joint_names, problem.start_positions, latency=0.1)
    with pytest.raises(ProblemError, match="ahead must be longer than the latency of the executor"):
        Supervisor(arm, problem)
