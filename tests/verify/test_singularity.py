"""The judge's smallest singular value: by hand, against dense sampling, and proven in between."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.verify.arms import mixed_arm, planar_arm, quintic, reduced, wavy
from trajopt.arrays import Floats
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import singularity_distance
from trajopt.model.scene import Scene
from trajopt.model.trajectory import Trajectory
from trajopt.verify import Check, Evidence, VerifyOptions, When, check_requirement
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import Motion

MANY = settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
OFFSET = np.array((0.1, 0.05, 0.0))


def judged(
    model: ReducedModel, there: Trajectory, frame: str, smallest: float, length: float, when: When
) -> Check:
    motion = Motion(model, there, kinematics=Kinematics(model), options=VerifyOptions())
    wanted = singularity_distance(frame, smallest, length=length, offset=OFFSET)
    (found,) = check_requirement(wanted, motion, when)
    return found


def differenced(model: ReducedModel, frame: str, at: Floats, length: float) -> float:
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
    least = min(differenced(model, "finger", q, length) for q in there(times))
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
