"""Cameras that look at points: formulas, verdicts, and what every kind is asked."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trajopt as to
import trajopt.optimise.terms
from tests.problem.requirements.kind import Kind
from tests.problem.requirements.sound import (
    MANY_CONFIGURATIONS,
    MANY_MOTIONS,
    OFFSET,
    TIP_OFFSET,
    check,
    points,
    positions,
    verdict,
    violation,
)
from tests.robots_for_tests import two_arms
from tests.verify.arms import mixed_arm, reduced, wavy
from trajopt.geometry import Query
from trajopt.optimise.terms import constrain
from trajopt.optimise.terms.alignment import ViewAngle, ViewDistance
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import (
    Gaze,
    Requirement,
    gaze,
)
from trajopt.problem.residual import WHOLE
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.verify import Evidence, When


@MANY_CONFIGURATIONS
@given(at=positions, where=points, behind=st.booleans())
def test_gaze(odd: ReducedModel, at: tuple[float, ...], where: tuple[float, ...], behind: bool) -> None:
    """Angle and range by the cosine rule, in the world; a target behind still has a slope."""
    frame = odd.scene.placement_of("tip", odd.all_positions(np.array(at)))
    axis = np.array((1.0, 0.0, 0.2)) / np.linalg.norm((1.0, 0.0, 0.2))
    eye = frame * TIP_OFFSET
    target = eye - 0.4 * frame.rotation @ axis if behind else np.array(where)
    way = target - eye
    distance = float(np.linalg.norm(way))
    angle = float(np.arccos(np.clip(way @ frame.rotation @ axis / distance, -1.0, 1.0)))
    need = to.gaze("tip", target, angle=0.3, axis=axis, origin=TIP_OFFSET, nearest=0.2, farthest=0.5)
    excess = max(angle - 0.3, 0.2 - distance, distance - 0.5)
    assert violation(odd, need, at) == pytest.approx(excess, abs=1e-6)
    (cone, _) = constrain(need, odd, WHOLE, inset=0.0)
    slope = cone.residual.linearise(Motion.single(np.array(at), Query(odd))).jacobian
    if behind:
        assert angle == pytest.approx(np.pi, abs=1e-6)
        assert np.linalg.norm(slope) > 1e-3


@given(seed=st.integers(0, 10**6))
@MANY_MOTIONS
def test_gaze_agrees_with_dense_sampling(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = reduced(Scene(mixed_arm(tmp_path)), [0.1, -0.2, 0.05, 0.3])
    there = wavy(model, seed, size=(0.1, 0.5, 1.0)[seed % 3])
    target, axis = rng.uniform(-1.0, 1.0, 3), rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    reference = "world" if seed % 2 else "a"
    scene = model.scene
    angles, distances = [], []
    for q in there(np.linspace(0.0, there.duration, 300)):
        full = model.all_positions(q)
        way = scene.placement_of(reference, full) * target - scene.placement_of("finger", full) * OFFSET
        distances.append(float(np.linalg.norm(way)))
        cosine = way @ (scene.placement_of("finger", full).rotation @ axis) / distances[-1]
        angles.append(float(np.arccos(np.clip(cosine, -1.0, 1.0))))
    if min(distances) < 0.02 or max(angles) > 3.0:
        return
    for factor, holds in ((1.02, True), (0.98, False)):
        wanted = gaze(
            "finger", target, angle=factor * max(angles), axis=axis, origin=OFFSET, reference=reference,
            nearest=0.99 * min(distances), farthest=1.01 * max(distances),
        )  # fmt: skip
        found = check(model, there, wanted, When.ALWAYS)
        assert [one.holds for one in found] == [holds, True, True]
        assert all(one.evidence is Evidence.PROVEN for one in found if one.holds)
    far = gaze(
        "finger",
        target,
        angle=3.1,
        axis=axis,
        origin=OFFSET,
        farthest=0.98 * max(distances),
        reference=reference,
    )
    assert not verdict(model, there, far)[0]


def test_bad_input_is_refused() -> None:
    with pytest.raises(ProblemError):
        to.gaze("a", (0, 0, 0), angle=0.3, nearest=0.5, farthest=0.4)
    with pytest.raises(ShapeError, match="angle"):
        to.gaze("tip", (0, 0, 0), angle=4.0)


@pytest.mark.parametrize(
    "need",
    [
        to.gaze("tool", (0, 0, 0), angle=0.3, reference="tool"),
        to.gaze("tool", (0, 0, 1), angle=0.3, reference="right_fore"),
        to.axis_alignment("torso", tolerance=0.1),
        to.distance_between("right_hand", "tool", lower=0.1),
    ],
    ids=str,
)
def test_frames_fixed_to_each_other_are_refused(need: Requirement, tmp_path: Path) -> None:
    """The planner searched for minutes while the camera looked at its own centre."""
    scene = Scene(two_arms(tmp_path))
    places: list[dict[str, Any]] = [{"constraints": [need]}, {"waypoints": [need]}, {"goal": need}]
    for where in places:
        fields: dict[str, Any] = {"goal": [0.1, 0.1], **where}
        with pytest.raises(ProblemError, match=r"no motion changes it: .* is fixed to"):
            to.Problem(scene=scene, group="right", start=[0.0, 0.0], **fields)


def camera(reference: str) -> Gaze:
    return to.gaze(
        "held",
        (0.3, 0.2, 0.1),
        angle=0.3,
        axis=(0.1, 0.2, 1),
        origin=(0, 0, 0.02),
        farthest=1,
        reference=reference,
    )


POINT = (0.1, 0.0, 0.2)
KIND = Kind(
    requirement=Gaze,
    printed=[
        (to.gaze("eye", (0.5, 0, 0.2), angle=np.pi / 6), "eye looks at (0.5, 0, 0.2) m, within 30 deg"),
        (
            to.gaze("eye", (0, 0, 0), angle=np.pi / 6, nearest=0.05, farthest=2, reference="cup"),
            "eye looks at (0, 0, 0) m from cup, within 30 deg, at least 50 mm away, at most 2 m away",
        ),
    ],
    relaxed=[to.gaze("tip", (1.0, 0.0, 0.0), angle=0.4)],
    residuals={
        ViewAngle: [lambda at: ViewAngle(at.reduced, camera("slide"))],
        ViewDistance: [lambda at: ViewDistance(at.reduced, camera("world"))],
    },
    calls={
        "gaze": {
            "frame": "panda_hand_tcp",
            "target": POINT,
            "angle": 0.3,
            "axis": (0.0, 0.0, 1.0),
            "origin": POINT,
            "nearest": 0.1,
            "farthest": 2.0,
        }
    },
)
