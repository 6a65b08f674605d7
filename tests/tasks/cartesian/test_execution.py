"""Execution in simulation: what is missing at the end is measured and closed."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tasks.cartesian.test_follow import at, followed
from trajopt.simulation import SimulationOptions
from trajopt.tasks.cartesian import execute, line
from trajopt.values.errors import ProblemError
from trajopt.values.trajectory import Trajectory


def test_a_good_motion_needs_no_closing_move() -> None:
    done = execute(followed(line(at(), at(0.0, 0.2, 0.1))), position_tolerance=1e-4, rotation_tolerance=1e-3)
    assert done.reached
    assert done.moves == ()
    assert len(done.rollouts) == len(done.errors) == 1


def test_a_motion_too_fast_for_the_motors_is_closed() -> None:
    """Four times as fast as planned, and looked at as soon as it should have ended."""
    result = followed(line(at(), at(0.0, 0.3, 0.1)))
    assert result.timed is not None
    slow = result.timed.trajectory
    assert slow.velocities is not None
    assert slow.accelerations is not None
    fast = Trajectory(
        slow.joint_names, slow.times / 4.0, slow.positions, 4.0 * slow.velocities, 16.0 * slow.accelerations
    )
    hurried = replace(result, result=replace(result.result, trajectory=fast))
    done = execute(hurried, options=SimulationOptions(settling_time=0.0))
    assert done.rollouts[0].saturated
    assert done.errors[0].position > 1e-3
    assert done.reached
    assert len(done.moves) >= 1
    assert all(move.complete for move in done.moves)
    assert done.errors[-1].position <= 1e-3
    start = done.moves[0].problem.reduced.start_positions
    assert start == pytest.approx(done.rollouts[0].positions[-1])
    assert np.linalg.norm(done.rollouts[1].positions[0] - start) < 1e-9


def test_nothing_to_execute_is_refused() -> None:
    with pytest.raises(ProblemError, match="no verified motion"):
        execute(followed(line(at(0.0, 0.0, 0.2), at(0.0, 0.2, 0.2))))
