"""Proof over intervals: what is no number is no proof, whoever computed it."""

import numpy as np
import pytest

import trajopt as to
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.verify.certificate import Evidence
from trajopt.verify.kernel.interval_proof import Excess, prove_over_time
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.options import VerifyOptions

BROKEN = 0.43
"""When the number cannot be computed, on a motion of a second [s]."""


@pytest.fixture
def motion(planar_arm: to.Robot) -> JudgedMotion:
    reduced = reduce_model(to.Scene(planar_arm), "arm", np.zeros(len(planar_arm.joint_names)))
    points = np.zeros((2, len(reduced.joint_names)))
    points[1] = 0.1
    trajectory = to.Trajectory(reduced.joint_names, np.array((0.0, 1.0)), points)
    return JudgedMotion(reduced, trajectory, kinematics=Kinematics(reduced), options=VerifyOptions())


@pytest.mark.parametrize(("measured", "evidence"), [(True, Evidence.SAMPLED), (False, Evidence.UNPROVEN)])
def test_a_number_that_cannot_be_computed_is_not_within_its_bound(
    motion: JudgedMotion, measured: bool, evidence: Evidence
) -> None:
    def excess(begin: Floats, end: Floats) -> Excess:
        middle = (begin + end) / 2.0
        unknown = np.where((begin <= BROKEN) & (BROKEN <= end), np.nan, -1.0)
        return Excess(unknown if measured else np.full(len(begin), -1.0), middle, unknown)

    found = prove_over_time(motion, excess)
    assert found.evidence is evidence
    if not measured:
        assert found.interval is not None and found.interval[0] <= BROKEN <= found.interval[1]


def test_numbers_within_their_bound_are_proven(motion: JudgedMotion) -> None:
    found = prove_over_time(motion, lambda begin, end: Excess(begin - 2.0, begin, end - 2.0))
    assert found.evidence is Evidence.PROVEN and found.interval is None
