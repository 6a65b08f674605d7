"""Violations by the term, verdicts of the judge, and what they are compared on."""

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from tests.verify.arms import quintic
from trajopt.geometry import Query
from trajopt.optimise.terms import constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import (
    Requirement,
)
from trajopt.problem.residual import WHOLE
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.placement import Placement, placement
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Check, Evidence, VerifyOptions, When, check_requirement
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion

MANY_CONFIGURATIONS = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


positions = st.tuples(st.floats(-6, 6), st.floats(0, 0.3), st.floats(-2.5, 2.5), st.floats(-3, 3))


points = st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(0.0, 0.8))


rpys = st.tuples(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3))


TIP_OFFSET = np.array((0.01, 0.02, 0.03))


def violation(reduced: ReducedModel, required: Requirement, at: tuple[float, ...]) -> float:
    """Largest violation of the requirement's rows, without inset."""
    motion = Motion.single(np.array(at), Query(reduced))
    worst = -np.inf
    for item in constrain(required, reduced, WHOLE, inset=0.0):
        rows = item.residual.linearise(motion)
        lower, upper = item.bounds(rows)
        worst = max(worst, float(np.maximum(lower - rows.value, rows.value - upper).max()))
    return worst


def tip(reduced: ReducedModel, at: tuple[float, ...], reference: str = "world") -> Floats:
    full = reduced.all_positions(np.array(at))
    scene = reduced.scene
    return scene.placement_of(reference, full).inverse() * (scene.placement_of("tip", full) * TIP_OFFSET)


MANY_MOTIONS = settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


OFFSET = np.array((0.05, -0.02, 0.1))


def check(model: ReducedModel, trajectory: Trajectory, wanted: Requirement, when: When) -> tuple[Check, ...]:
    motion = JudgedMotion(model, trajectory, kinematics=Kinematics(model), options=VerifyOptions())
    return check_requirement(wanted, motion, when)


def verdict(model: ReducedModel, there: Trajectory, wanted: Requirement) -> tuple[bool, Check]:
    found = check(model, there, wanted, When.ALWAYS)
    assert all(one.evidence is Evidence.PROVEN for one in found if one.holds)
    return all(one.holds for one in found), max(found, key=lambda one: -(one.slack or 0.0))


END = (0.9, 0.4)


def reach(model: ReducedModel, *knots: tuple[float, float], duration: float = 1.0) -> Trajectory:
    return quintic(model, [[-0.5, 0.2], *(list(knot) for knot in knots)], duration)


def planar_tip(shoulder: float, elbow: float) -> Placement:
    """Where the tip is, by trigonometry."""
    x = 0.5 * np.cos(shoulder) + 0.5 * np.cos(shoulder + elbow)
    y = 0.5 * np.sin(shoulder) + 0.5 * np.sin(shoulder + elbow)
    return placement((x, y, 0.0), rpy=(0, 0, shoulder + elbow))


def relative(model: ReducedModel, frame: str, reference: str, positions: np.ndarray) -> Placement:
    scene, everything = model.scene, model.all_positions(positions)
    return scene.placement_of(reference, everything).inverse() * scene.placement_of(frame, everything)
