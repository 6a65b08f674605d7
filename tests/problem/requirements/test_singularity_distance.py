"""Singular values: closed forms, differences, verdicts, and what every kind is asked."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import trajopt as to
import trajopt.optimise.terms
from tests.optimise.terms.worlds import World
from tests.problem.requirements.kind import Kind
from tests.problem.requirements.sound import (
    positions,
)
from tests.verify.arms import mixed_arm, planar_arm, quintic, reduced, wavy
from trajopt.geometry import Query
from trajopt.optimise import terms
from trajopt.optimise.terms.singularity_distance import SmallestSingularValue, frame_jacobian
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import (
    SingularityDistance,
    singularity_distance,
)
from trajopt.problem.residual import Residual
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Check, Evidence, VerifyOptions, When, check_requirement
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion

POINT = np.array((0.05, 0.0, 0.02))


def jacobian_by_differences(reduced: ReducedModel, at: Floats, length: float) -> Floats:
    """The finger's Jacobian by central differences of its placement."""
    step, columns = 1e-6, []
    for joint in np.eye(len(at)):
        high, low = (
            reduced.scene.placement_of("finger", reduced.all_positions(at + sign * step * joint))
            for sign in (1.0, -1.0)
        )
        spin = (high.rotation - low.rotation) @ ((high.rotation + low.rotation) / 2).T / (2 * step)
        angular = np.array((spin[2, 1], spin[0, 2], spin[1, 0]))
        columns.append(np.append((high * POINT - low * POINT) / (2 * step), length * angular))
    return np.array(columns).T


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(at=positions)
def test_singular_values_are_those_of_the_jacobian(odd: ReducedModel, at: tuple[float, ...]) -> None:
    motion = Motion.single(np.array(at), Query(odd))
    expected = np.linalg.svd(jacobian_by_differences(odd, np.array(at), 0.3), compute_uv=False)
    need = to.singularity_distance("finger", 0.01, length=0.3, offset=POINT)
    found = SmallestSingularValue(odd, need).linearise(motion).value[0]
    assert found == pytest.approx(expected[-1], abs=1e-6)
    at_origin = terms.LostManipulability("finger", 0.01, 0.3).linearise(motion).value[0]
    origin = to.singularity_distance("finger", 0.01, length=0.3)
    jacobian = frame_jacobian(odd, motion, "finger", length=origin.length, offset=origin.offset).matrix[0]
    volume = float(np.sqrt(max(np.linalg.det(jacobian.T @ jacobian), 0.0)))
    assert at_origin == pytest.approx(0.01 / (0.01 + volume), abs=1e-6)


def test_two_rods_by_hand() -> None:
    """The product of both singular values is the area that the columns span, none when stretched."""
    robot = to.load("planar2")
    group = next(iter(robot.groups))
    reduced = reduce_model(to.Scene(robot), group, robot.positions())
    frame = robot.links[-1]
    for elbow in (0.0, 0.4, 1.5):
        motion = Motion.single(np.array((0.3, elbow)), Query(reduced))
        matrix = frame_jacobian(reduced, motion, frame, length=0.0, offset=np.zeros(3)).matrix[0]
        assert np.linalg.svd(matrix, compute_uv=False).prod() == pytest.approx(
            np.linalg.norm(np.cross(matrix[:, 0], matrix[:, 1])), abs=1e-12
        )
        if elbow == 0.0:
            assert np.linalg.svd(matrix, compute_uv=False)[-1] == pytest.approx(0.0, abs=1e-12)


def test_bad_input_is_refused() -> None:
    with pytest.raises(ProblemError, match="smallest"):
        to.singularity_distance("tip", 0.0)
    with pytest.raises(ProblemError, match="length"):
        to.singularity_distance("tip", 0.1, length=-1.0)


MANY = settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


OFFSET = np.array((0.1, 0.05, 0.0))


def judged(
    model: ReducedModel, there: Trajectory, frame: str, smallest: float, length: float, when: When
) -> Check:
    motion = JudgedMotion(model, there, kinematics=Kinematics(model), options=VerifyOptions())
    wanted = singularity_distance(frame, smallest, length=length, offset=OFFSET)
    (found,) = check_requirement(wanted, motion, when)
    return found


def least_by_differences(model: ReducedModel, frame: str, at: Floats, length: float) -> float:
    step, columns = 1e-6, []
    for joint in np.eye(len(at)):
        high, low = (
            model.scene.placement_of(frame, model.all_positions(at + sign * step * joint))
            for sign in (1.0, -1.0)
        )
        spin = (high.rotation - low.rotation) @ ((high.rotation + low.rotation) / 2).T / (2 * step)
        angular = np.array((spin[2, 1], spin[0, 2], spin[1, 0]))
        velocity = (high * OFFSET - low * OFFSET) / (2 * step)
        columns.append(np.append(velocity, length * angular) if length else velocity)
    return float(np.linalg.svd(np.array(columns).T, compute_uv=False)[-1])


@given(seed=st.integers(0, 10**6), length=st.sampled_from((0.0, 0.3)))
@MANY
def test_verdicts_agree_with_dense_sampling(tmp_path: Path, seed: int, length: float) -> None:
    model = reduced(Scene(mixed_arm(tmp_path)), [0.1, -0.2, 0.05, 0.3])
    there = wavy(model, seed, size=(0.05, 0.2, 0.5)[seed % 3])
    times = np.linspace(0.0, there.duration, 150)
    least = min(least_by_differences(model, "finger", q, length) for q in there(times))
    if least < 2e-3:
        return
    below = judged(model, there, "finger", 0.95 * least, length, When.ALWAYS)
    assert below.holds, below
    assert below.evidence is Evidence.PROVEN
    assert below.value == pytest.approx(least, rel=0.05)
    assert not judged(model, there, "finger", 1.02 * least, length, When.ALWAYS).holds


def test_a_stretched_elbow_is_seen_between_the_ends(tmp_path: Path) -> None:
    model = reduced(Scene(planar_arm(tmp_path)), [0.0, 1.0])
    through = quintic(model, [[0.0, 1.0], [0.3, -0.6]], 1.0)
    assert judged(model, through, "tip", 0.05, 0.0, When.END).holds
    found = judged(model, through, "tip", 0.05, 0.0, When.ALWAYS)
    assert not found.holds
    assert found.value is not None
    assert found.value < 0.05
    short = quintic(model, [[0.0, 1.0], [0.3, 0.9]], 1.0)
    assert judged(model, short, "tip", 0.05, 0.0, When.ALWAYS).holds


def away(frame: str, length: float) -> Callable[[World], Residual]:
    def build(at: World) -> Residual:
        required = to.singularity_distance(frame, 0.01, length=length, offset=(0.05, 0, 0.02))
        return SmallestSingularValue(at.reduced, required)

    return build


KIND = Kind(
    requirement=SingularityDistance,
    printed=[(to.singularity_distance("hand", 0.05), "smallest singular value of hand at least 0.05")],
    relaxed=[to.singularity_distance("tip", 0.05, length=0.0)],
    residuals={SmallestSingularValue: [away("held", 0.3), away("finger", 0.3), away("finger", 0.0)]},
    calls={"singularity_distance": {"frame": "panda_hand_tcp", "smallest": 0.01, "length": 0.3}},
    measured=frozenset({SmallestSingularValue}),
)
