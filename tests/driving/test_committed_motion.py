"""Committed motion: a spliced motion continues the present one, and others are refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from trajopt.driving import CommittedMotion
from trajopt.values.errors import JointNotFound

NAMES = ("a", "b")


def move(begin: list[float], end: list[float], duration: float = 1.0) -> to.Trajectory:
    """From rest to rest, quintic."""
    still = np.zeros((2, len(begin)))
    return to.Trajectory(NAMES[: len(begin)], np.array((0.0, duration)), np.array((begin, end)), still, still)


def test_rests_at_its_start() -> None:
    committed = CommittedMotion(NAMES, np.array((1.0, 2.0)))
    assert committed(5.0).tolist() == [[1.0, 2.0], [0.0, 0.0], [0.0, 0.0]]
    assert committed.ahead(0.0, NAMES) is None


@settings(deadline=None)
@given(at=st.floats(0.05, 1.5), later=st.floats(0.0, 3.0))
def test_rest_of_the_motion_equals_later_states(at: float, later: float) -> None:
    """Whatever is spliced together, the one motion ahead is what is committed, by another clock."""
    committed = CommittedMotion(NAMES, np.zeros(2))
    first = move([0.0, 0.0], [1.0, -1.0])
    committed.splice(first, 1.0, now=0.0)
    begin = 1.0 + at
    here = committed(begin)
    away = np.stack((here[0], here[0] + 0.3))
    rates = [np.stack((row, np.zeros(2))) for row in here[1:]]
    second = to.Trajectory(NAMES, np.array((0.0, 0.7)), away, *rates)
    assert committed.refusal(second, begin, earliest=0.0) == ""
    committed.splice(second, begin, now=0.0)
    ahead = committed.ahead(later, NAMES)
    if later >= committed.end:
        assert ahead is None
        return
    assert ahead is not None
    times = np.linspace(0.0, ahead.duration, 50)
    for order in range(3):
        wanted = np.array([committed(later + time)[order] for time in times.tolist()])
        # Where it comes to rest or leaves it, the acceleration takes a moment.
        near = 0.02 if order == 2 else 1e-5
        assert np.median(np.abs(ahead(times, order) - wanted)) < near
        if order < 2:
            assert np.abs(ahead(times, order) - wanted).max() < near


def test_spliced_motion_is_kept_unchanged(monkeypatch: pytest.MonkeyPatch) -> None:
    """In each cycle one is: no motion of all joints is made of it, and polynomials are found once for all."""
    committed = CommittedMotion((*NAMES, "c"), np.array((0.0, 0.0, 3.0)))
    made: list[to.Trajectory] = []
    first, second = move([0.0, 0.0], [1.0, -1.0]), move([1.0, -1.0], [2.0, 0.0])
    check = to.Trajectory.__post_init__

    def counted(trajectory: to.Trajectory) -> None:
        made.append(trajectory)
        check(trajectory)

    monkeypatch.setattr(to.Trajectory, "__post_init__", counted)
    for at, motion in ((1.0, first), (2.5, second)):
        assert committed.refusal(motion, at, earliest=0.0) == ""
        committed.splice(motion, at, now=0.0)
    assert not made
    assert committed(1.25)[:, 2].tolist() == [3.0, 0.0, 0.0]
    assert committed(1.25)[1, :2].tolist() == pytest.approx(first(0.25, 1).tolist())
    for (begin, whole), part in zip(committed.pieces, (first, second), strict=True):
        assert whole.joint_names == (*NAMES, "c")
        for time in (0.0, 0.3, 1.0):
            assert whole(time)[:2].tolist() == pytest.approx(part(time).tolist())
            assert whole(time).tolist() == pytest.approx(committed(begin + time)[0].tolist())


def test_refuses_motions_that_are_late_or_jump_or_do_not_end_at_rest() -> None:
    committed = CommittedMotion(NAMES, np.zeros(2))
    assert "5.0 ms late" in committed.refusal(move([0.0, 0.0], [1.0, 1.0]), 1.0, earliest=1.005)
    assert "position of b would jump by 0.5" in committed.refusal(
        move([0.0, 0.5], [1.0, 1.0]), 1.0, earliest=0.0
    )
    still = np.zeros((2, 2))
    going = to.Trajectory(NAMES, np.array((0.0, 1.0)), still, np.array(((0.0, 0.0), (0.0, 0.1))), still)
    assert "does not end at rest: b" in committed.refusal(going, 1.0, earliest=0.0)
    committed.splice(move([0.0, 0.0], [1.0, 1.0]), 1.0, now=0.0)
    assert "velocity of a would jump" in committed.refusal(
        move(committed(1.5)[0].tolist(), [0.0, 0.0]), 1.5, earliest=0.0
    )


def test_joints_outside_a_motion_rest() -> None:
    committed = CommittedMotion(NAMES, np.array((0.0, 2.0)))
    only = move([0.0], [1.0])
    assert committed.refusal(only, 1.0, earliest=0.0) == ""
    committed.splice(only, 1.0, now=0.0)
    assert committed(2.0)[0].tolist() == [1.0, 2.0]
    other = to.Trajectory(("b",), only.times, only.positions + 2.0, only.velocities, only.accelerations)
    assert "a, which it does not move, is still moving" in committed.refusal(other, 1.5, earliest=0.0)
    assert "moves c, which the executor does not drive" in committed.refusal(
        to.Trajectory(("c",), only.times, only.positions), 3.0, earliest=0.0
    )


def test_ended_motions_are_dropped() -> None:
    committed, now = CommittedMotion(NAMES, np.zeros(2)), 0.0
    for number in range(50):
        end = float(number % 2)
        committed.splice(move([1.0 - end, 0.0] if number else [0.0, 0.0], [end, 0.0]), now, now=now)
        now += 2.0
    assert committed.kept <= 2


def test_joints_that_are_not_driven_are_named() -> None:
    committed = CommittedMotion(NAMES, np.zeros(2))
    with pytest.raises(JointNotFound, match="no joint that is driven named 'c'"):
        committed.ahead(0.0, ("c",))


def test_positions_at_many_times_equal_those_at_each() -> None:
    committed = CommittedMotion((*NAMES, "c"), np.array((0.0, 0.0, 3.0)))
    times = np.linspace(-1.0, 5.0, 37)
    assert committed.positions(times).tolist() == [[0.0, 0.0, 3.0]] * 37
    committed.splice(move([0.0, 0.0], [1.0, -1.0]), 1.0, now=0.0)
    committed.splice(move([1.0, -1.0], [2.0, 0.0]), 2.5, now=0.0)
    each = [committed(float(time))[0] for time in times]
    np.testing.assert_allclose(committed.positions(times), each, atol=1e-12)
