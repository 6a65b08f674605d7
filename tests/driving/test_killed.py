"""The planning process is killed while the robot moves: the robot comes to rest as proven."""

import os
import signal
from multiprocessing import get_context
from multiprocessing.connection import Connection
from time import monotonic, sleep
from typing import Any

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import CommittedMotion, SimulatedExecutor, Supervisor, SupervisorOptions
from trajopt.driving.motion_guard import guard_of, start_from
from trajopt.driving.remote import RemoteExecutor, attend
from trajopt.driving.world_snapshot import WorldSnapshot

PROBLEMS = ("cup_past_pillar", "bookshelf_ur5", "past_pillar_xarm7")
KILLED = 100
"""Planners killed in the slow test."""
AHEAD = 0.3
"""How far ahead the robot is committed [s]: on a machine with much else to do a plan takes its time."""
SLOWER = 3.0
"""By so much slower than real time the robot moves, for the same reason."""
LATEST = 0.8
"""A planner is killed so long at most after the robot has begun to move [s]."""
PATIENCE = 60.0
"""A planner that has not moved the robot by then is broken [s]."""


class Remembering(SimulatedExecutor):
    """Remembers everything that it was given to do."""

    given: CommittedMotion

    def splice(self, trajectory: to.Trajectory, at: float) -> str:
        refused = super().splice(trajectory, at)
        if not refused:
            self.given.splice(trajectory, at, now=-np.inf)
        return refused


def planner(connection: "Connection[Any, Any]", problem: to.Problem) -> None:
    """Plan and supervise, to the goal and back, until somebody kills this process."""
    executor = RemoteExecutor(connection)
    supervisor = Supervisor(executor, problem, SupervisorOptions(ahead=AHEAD))
    start = dict(zip(problem.reduced.joint_names, problem.reduced.start_positions.tolist(), strict=True))
    ways = (problem, replaced(problem, goal=to.joint_positions(start)))
    for number in range(1_000_000):
        supervisor.go(ways[number % 2])
        while supervisor.busy:
            supervisor.cycle()
            sleep(0.01)


def replaced(problem: to.Problem, **fields: Any) -> to.Problem:
    from dataclasses import replace

    return replace(problem, **fields)


def killed_in_motion(problem: to.Problem, seed: int) -> None:
    """Let a planner drive a robot in real time, kill it at a random moment, and judge what was driven."""
    rng, context = np.random.default_rng(seed), get_context("fork")
    arm = Remembering(problem.scene, problem.start_positions, clock=lambda: monotonic() / SLOWER)
    arm.given = CommittedMotion(arm.joint_names, arm.state().commanded)
    ours, theirs = context.Pipe()
    process = context.Process(target=planner, args=(theirs, problem), daemon=True)
    process.start()
    theirs.close()
    begun, moment = monotonic(), np.inf
    while True:
        assert attend(arm, ours, wait=1e-3), "the planner ended by itself"
        moving = arm.now() < arm.committed.end and np.abs(arm.state().velocities).max() > 0.02
        if moving and moment == np.inf:
            moment = arm.now() + float(rng.uniform(0.0, LATEST))
        if moving and arm.now() >= moment:
            break
        assert monotonic() < begun + PATIENCE, "the planner did not move the robot"
    assert process.pid is not None
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    while attend(arm, ours):
        pass  # what it had still said before it died
    assert process.exitcode == -signal.SIGKILL
    in_motion_until = arm.committed.end
    while arm.now() < in_motion_until + 0.5:
        sleep(0.01)
    check_at_rest_and_proven(problem, arm)


def check_at_rest_and_proven(problem: to.Problem, arm: Remembering) -> None:
    assert arm.fault() == ""
    assert np.abs(arm.truth().velocities).max() < 1e-3
    away = np.abs(arm.truth().positions - arm.committed(arm.now())[0])
    assert (away <= arm.tolerance).all()
    assert arm.contacts == ()
    driven = arm.given.ahead(0.0, problem.reduced.joint_names)
    assert driven is not None
    world = start_from(problem, problem.start_positions, problem.scene)
    certificate = guard_of(world, arm).certificate(driven, WorldSnapshot(problem.scene, 0.0), 0.0)
    assert certificate.verified, certificate.summary()


def named(name: str) -> to.Problem:
    try:
        problem = to.named_problem(name)
    except to.MissingExtra as error:
        pytest.skip(str(error))
    to.plan(problem)  # what is made at the first plan, the processes inherit
    return problem


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_killed_planner_leaves_a_robot_that_comes_to_rest(name: str) -> None:
    killed_in_motion(named(name), 0)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", PROBLEMS)
def test_a_hundred_killed_planners(name: str) -> None:
    place = PROBLEMS.index(name)
    for seed in range(1 + place, KILLED + 1, len(PROBLEMS)):
        killed_in_motion(named(name) if seed <= len(PROBLEMS) else to.named_problem(name), seed)
