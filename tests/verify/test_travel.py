"""Bounds on how far bodies travel, against dense sampling of the motion."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.verify.arms import mixed_arm, reduced, wavy
from trajopt.scene.scene import Scene
from trajopt.values.placement import WORLD
from trajopt.verify.kernel.kinematics import Kinematics, Travel, relative_chain
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.options import VerifyOptions
from trajopt.verify.kernel.relative_motion import RelativeMotion

CORNERS = np.array([(x, y, z) for x in (0.0, 0.1) for y in (-0.01, 0.01) for z in (-0.01, 0.01)])
SAME_FOLDER = settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def motion_of(folder: Path, seed: int) -> JudgedMotion:
    model = reduced(Scene(mixed_arm(folder)), [0.1, -0.2, 0.05, 0.3])
    return JudgedMotion(model, wavy(model, seed), kinematics=Kinematics(model), options=VerifyOptions())


def test_the_mimicking_joint_and_the_kinds_of_joints_are_read(tmp_path: Path) -> None:
    motion = motion_of(tmp_path, 0)
    assert motion.reduced.joint_names == ("j1", "j2", "j3", "j4")
    assert motion.kinematics.revolute.tolist() == [False, True, True, False, True, True]
    np.testing.assert_allclose(motion.kinematics.axes[1], (0.0, 0.6, 0.8))
    deviation = motion.deviation(np.array([0.3]), np.array([0.5]))[0]
    assert deviation[0] == 0.0
    assert deviation[5] == pytest.approx(deviation[4] / 2)


@given(seed=st.integers(0, 10**6))
@SAME_FOLDER
def test_no_point_of_a_body_leaves_its_bound(tmp_path: Path, seed: int) -> None:
    motion = motion_of(tmp_path, seed)
    kinematics, rng = motion.kinematics, np.random.default_rng(seed)
    last = len(kinematics.parents) - 1
    centre = CORNERS.mean(axis=0)
    radius = np.linalg.norm(CORNERS - centre, axis=1).max()
    travel = Travel(
        kinematics,
        carrier=[last],
        centre=centre[None],
        radius=np.array([radius]),
        chains=[kinematics.chain(last)],
    )
    begin = rng.uniform(0.0, 1.9, 20)
    end = begin + rng.uniform(0.001, 0.1, 20)
    poses = motion.poses((begin + end) / 2)
    bound = travel.bound(poses, travel.centres(poses), motion.deviation(begin, end)).travel[:, 0, -1]
    loose: list[float] = []
    for row in range(20):
        seen = motion.poses(np.append(np.linspace(begin[row], end[row], 60), (begin[row] + end[row]) / 2))
        points = np.einsum("cij,pj->cpi", seen.rotation[:, last], CORNERS) + seen.translation[:, None, last]
        moved = np.linalg.norm(points[:-1] - points[-1], axis=2).max()
        assert moved <= bound[row] + 1e-12
        loose.append((bound[row] - 1e-3) / moved)
    # Where joints turn against each other a body hardly moves, which the bound cannot know.
    assert np.median(loose) <= 8.0, "the bound should not be absurdly loose"


@given(seed=st.integers(0, 10**6), swap=st.booleans())
@SAME_FOLDER
def test_relative_motion_stays_within_its_bounds(tmp_path: Path, seed: int, swap: bool) -> None:
    motion = motion_of(tmp_path, seed)
    rng = np.random.default_rng(seed)
    frame, reference = ("finger", "b") if not swap else ("b", "finger")
    moving = RelativeMotion(motion, frame, reference=reference, offset=np.array((0.1, 0.02, -0.05)))
    begin = rng.uniform(0.0, 1.9, 2)
    end = np.minimum(begin + rng.uniform(0.01, 0.1, 2), 2.0)
    bounds = moving.bounds(begin, end)
    for row in range(2):
        times = np.linspace(begin[row], end[row], 201)
        rotation, point = moving.placements(times)
        middle = 100
        shift = np.linalg.norm(point - point[middle], axis=1).max()
        trace = np.einsum("cij,ij->c", rotation, rotation[middle])
        turn = np.arccos(np.clip((trace - 1.0) / 2.0, -1.0, 1.0)).max()
        assert shift <= bounds.shift[row] + 1e-9
        assert turn <= bounds.turn[row] + 1e-6
        step = times[1] - times[0]
        acceleration = np.linalg.norm(np.diff(point, 2, axis=0), axis=1).max() / step**2
        assert acceleration <= bounds.point_acceleration[row] * (1.0 + 1e-3) + 1e-3
        # The axis of a turning frame has a second derivative of at most A + W^2.
        bend = np.linalg.norm(np.diff(rotation, 2, axis=0), axis=1).max() / step**2
        assert bend <= (bounds.turn_acceleration + bounds.turn_rate**2)[row] * (1.0 + 1e-3) + 1e-3


def test_the_chain_between_two_frames(tmp_path: Path) -> None:
    kinematics = motion_of(tmp_path, 0).kinematics
    assert relative_chain(kinematics, 5, 2) == ((5, 4, 3), 3)
    assert relative_chain(kinematics, 2, 5) == ((3, 4, 5), 0)
    assert relative_chain(kinematics, 3, 3) == ((), 0)
    assert relative_chain(kinematics, 2, 0) == ((2, 1), 2)


def test_a_frame_relative_to_itself_does_not_move(tmp_path: Path) -> None:
    motion = motion_of(tmp_path, 0)
    moving = RelativeMotion(motion, "d", reference="d", offset=np.zeros(3))
    bounds = moving.bounds(np.array([0.0]), np.array([2.0]))
    assert bounds.shift[0] == bounds.turn[0] == bounds.point_acceleration[0] == 0.0
    rotation, point = moving.placements(np.array([0.7]))
    np.testing.assert_allclose(rotation[0], np.eye(3), atol=1e-12)
    np.testing.assert_allclose(point[0], 0.0, atol=1e-12)
    world = RelativeMotion(motion, "base", reference=WORLD, offset=np.zeros(3))
    assert world.bounds(np.array([0.0]), np.array([2.0])).shift[0] == 0.0
