"""Tracks against scipy's interpolation of rotations, and what is refused."""

# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from trajopt.scene.track import Prediction, Track
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.placement import Placement, as_rotation_vector, from_rotation_vector, placement

NUMBERS = st.floats(-2.0, 2.0)
VECTORS = st.tuples(NUMBERS, NUMBERS, NUMBERS)


def places(rng: np.random.Generator, count: int) -> list[Placement]:
    turns = Rotation.random(count, random_state=int(rng.integers(1 << 30))).as_quat()
    return [placement(rng.uniform(-1.0, 1.0, 3), quaternion=turn) for turn in turns]


@given(VECTORS)
def test_rotation_vectors_are_those_of_scipy(vector: tuple[float, float, float]) -> None:
    matrix = from_rotation_vector(np.array(vector))
    assert matrix == pytest.approx(Rotation.from_rotvec(vector).as_matrix(), abs=1e-12)
    assert from_rotation_vector(as_rotation_vector(matrix)) == pytest.approx(matrix, abs=1e-9)
    assert np.linalg.norm(as_rotation_vector(matrix)) <= np.pi + 1e-12


@pytest.mark.parametrize("seed", range(5))
def test_between_its_times_it_is_straight_and_turns_evenly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.1, 1.0, 5)) - 1.0
    given_places = places(rng, 5)
    track = Track.through(times, given_places)
    turning = Slerp(times, Rotation.from_matrix([where.rotation for where in given_places]))
    for time in rng.uniform(times[0] - 1.0, times[-1] + 1.0, 40):
        inside = np.clip(time, times[0], times[-1])
        straight = [
            np.interp(inside, times, [where.translation[i] for where in given_places]) for i in range(3)
        ]
        assert track.at(time).translation == pytest.approx(straight, abs=1e-12)
        assert track.at(time).rotation == pytest.approx(turning(inside).as_matrix(), abs=1e-9)


def test_constant_velocity_is_seen_in_the_world() -> None:
    start = placement((0.1, 0.2, 0.3), rpy=(0.4, -0.5, 0.6))
    spin = np.array((0.3, -0.2, 0.5))
    track = Track.constant_velocity(start, (1.0, 0.0, -2.0), angular_velocity=spin, start=1.0, end=3.0)
    assert track.at(0.0) == start
    expected = Rotation.from_rotvec(1.5 * spin).as_matrix() @ start.rotation
    assert track.at(2.5).translation == pytest.approx((1.6, 0.2, -2.7))
    assert track.at(2.5).rotation == pytest.approx(expected, abs=1e-12)
    assert track.at(9.0).rotation == pytest.approx(track.at(3.0).rotation)
    without_end = Track.constant_velocity(start, (1.0, 0.0, 0.0))
    assert without_end.at(1000.0).translation[0] == pytest.approx(1000.1)


def test_a_shifted_track_is_the_same_by_another_clock() -> None:
    track = Track.through([0.0, 1.0, 3.0], places(np.random.default_rng(1), 3))
    for time in (-1.0, 0.2, 1.7, 5.0):
        later, now = track.shifted(0.7).at(time - 0.7), track.at(time)
        assert later.translation == pytest.approx(now.translation, abs=1e-12)
        assert later.rotation == pytest.approx(now.rotation, abs=1e-12)


@pytest.mark.parametrize(
    ("times", "count", "words"),
    [
        ([0.0, 1.0, 1.0], 3, "must be two at least, and increase"),
        ([0.0], 1, "must be two at least, and increase"),
        ([0.0, np.nan], 2, "not finite"),
        ([0.0, 1.0], 3, "has 2 times and 3 placements"),
    ],
)
def test_times_that_are_none_are_refused(times: list[float], count: int, words: str) -> None:
    with pytest.raises(ShapeError, match=words):
        Track.through(times, places(np.random.default_rng(0), count))


def test_jumps_are_refused_with_their_time_and_size() -> None:
    coefficients = np.zeros((2, 2, 3))
    coefficients[1, 1, 0] = 0.01
    turned = np.stack((np.eye(3), from_rotation_vector(np.array((0.0, 0.0, 0.1)))))
    axes = np.tile((0.0, 0.0, 1.0), (2, 1))
    with pytest.raises(ShapeError, match=r"jumps at 1 s by 10 mm and 5\.73 deg"):
        Track(np.array((0.0, 1.0, 2.0)), coefficients, turned, axes, np.zeros(2))


def test_an_error_grows_and_keeps_growing_on_a_shifted_clock() -> None:
    track = Track.constant_velocity(placement(), (0.1, 0.0, 0.0))
    prediction = Prediction(track, (0.01, 0.02, 0.03), until=4.0)
    assert prediction.error_at(-1.0) == 0.01
    assert prediction.error_at(2.0) == pytest.approx(0.01 + 0.04 + 0.06)
    later = prediction.shifted(1.5)
    assert later.until == 2.5
    for time in (0.0, 0.4, 2.0):
        assert later.error_at(time) == pytest.approx(prediction.error_at(time + 1.5))
    with pytest.raises(ShapeError, match="must be from 0 to before 4 s, is 5 s"):
        prediction.shifted(5.0)
    assert repr(prediction) == (
        "Prediction(Track(0 to 1e+09 s, 1 piece), within 10 mm + 20 mm/s + 30 mm/s^2, until 4 s)"
    )


def test_predictions_that_are_none_are_refused() -> None:
    track = Track.constant_velocity(placement(), (0.1, 0.0, 0.0))
    with pytest.raises(ProblemError, match="track must be a Track, is 'table'"):
        Prediction("table")  # pyright: ignore[reportArgumentType]
    with pytest.raises(ShapeError, match="error: must not be negative"):
        Prediction(track, (0.0, -0.1, 0.0))
    with pytest.raises(ShapeError, match="until: must be after 0 s, is -1 s"):
        Prediction(track, until=-1.0)


def test_copies_are_as_immutable_as_the_track() -> None:
    track = Track.through([0.0, 1.0], places(np.random.default_rng(0), 2))
    for other in (copy.copy(track), pickle.loads(pickle.dumps(track))):
        assert not other.coefficients.flags.writeable and not other.times.flags.writeable
        assert other.at(0.3) == track.at(0.3)
