"""Problems with dynamic obstacles: proven motions touch nothing under physics either."""

import pytest
from trajopt_problems import moving_world

import trajopt as to
from trajopt.simulation import simulate

SOLVED = (
    moving_world.crossing_panda,
    moving_world.late_crate_ur5,
    moving_world.parked_crate_xarm7,
    moving_world.revolving_door,
    moving_world.lid_lifted_ur5,
    moving_world.beside_another_arm,
    moving_world.conveyor_ur5,
)


@pytest.mark.parametrize("make", SOLVED, ids=lambda make: make.__name__)
def test_nothing_is_touched_before_the_end(make: object) -> None:
    assert callable(make)
    try:
        problem = make()
    except to.MissingExtra as error:
        pytest.skip(str(error))
    assert isinstance(problem, to.Problem)
    rollout = simulate(to.plan(problem))
    assert rollout.diverged is None
    assert [
        str(contact) for contact in rollout.contacts if contact.start <= rollout.trajectory.duration
    ] == []
    assert rollout.tracking_error.maximum.max() < 0.02
