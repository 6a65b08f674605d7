"""After a fault a robot leaves contacts, and goes home slowly."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import EventKind, IdealExecutor, SimulatedExecutor, Supervisor
from trajopt.verify import examine


@pytest.fixture(scope="module")
def problem() -> to.Problem:
    try:
        panda = to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    scene = to.Scene(panda).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    return to.Problem(scene=scene, group="panda_arm", start="ready", goal="ready")


def touching(problem: to.Problem, depth: float) -> to.Problem:
    """The fingers are so deep in the table."""
    down = to.placement((0.5, 0.0, 0.009 - depth), rpy=(np.pi, 0.0, 0.0))
    free = replace(
        problem, scene=to.Scene(problem.scene.robot), goal=to.frame_placement("panda_hand_tcp", down)
    )
    end = to.plan(free).require().trajectory
    start = problem.reduced.all_positions(end(end.duration))
    return replace(problem, start=start)


def test_recovers_from_light_contact_with_growing_distances(problem: to.Problem) -> None:
    stuck = touching(problem, 0.002)
    reduced = stuck.reduced
    before = examine(reduced, reduced.start_positions).collisions
    assert before and before[0].distance < 0.0
    arm = IdealExecutor(problem.scene.robot.joint_names, stuck.start_positions)
    arm.stop()
    supervisor = Supervisor(arm, stuck)
    assert supervisor.recover("ready")
    assert "leaves table" in supervisor.events[-1].words
    columns = [arm.joint_names.index(name) for name in reduced.joint_names]
    depths = []
    while supervisor.busy:
        supervisor.cycle()
        arm.advance(0.01)
        found = examine(reduced, arm.state().positions[columns]).collisions
        depths.append(min((pair.distance for pair in found), default=np.inf))
    clear = int(np.argmax(np.isinf(depths)))
    assert (np.diff(depths[:clear]) >= -1e-6).all() and np.isinf(depths[clear:]).all()
    home = problem.reduced.start_positions
    assert arm.state().positions[columns] == pytest.approx(home, abs=1e-3)
    assert [event.kind for event in supervisor.events] == [EventKind.RECOVERING]


def test_deep_contact_is_not_recovered_automatically(problem: to.Problem) -> None:
    stuck = touching(problem, 0.03)
    supervisor = Supervisor(IdealExecutor(problem.scene.robot.joint_names, stuck.start_positions), stuck)
    assert not supervisor.recover("ready")
    assert supervisor.events[-1].kind is EventKind.NO_PLAN
    assert "not light contact" in supervisor.events[-1].words


def test_recovers_after_a_stop_of_the_driver(problem: to.Problem) -> None:
    asked = to.named_problem("cup_past_pillar")
    arm = SimulatedExecutor(asked.scene, asked.start_positions)
    supervisor = Supervisor(arm, asked)
    supervisor.go(asked)
    for _ in range(15):
        supervisor.cycle()
        arm.advance(0.02)
    arm.stop()
    supervisor.cycle()
    assert supervisor.events[-1].kind is EventKind.FAULT
    arm.advance(1.0)
    home = dict(zip(asked.reduced.joint_names, asked.reduced.start_positions.tolist(), strict=True))
    assert supervisor.recover(home, scaling=0.3)
    while supervisor.busy:
        supervisor.cycle()
        arm.advance(0.02)
    assert supervisor.events[-1].kind is EventKind.RECOVERING and arm.contacts == ()
