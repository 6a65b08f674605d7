"""Clearance at fault: what comes near a link at rest is no fault of the robot, yet it is refused."""

import numpy as np
import pytest

import trajopt as to
from tests.verify.test_moving_things import alone
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.track import Prediction, Track
from trajopt.verify import verify
from trajopt.verify.certificate import Certificate, Check, CheckKind, Evidence

ON_TOP = 0.17
"""Height at which a ball of 5 cm lies on the arm's links [m]."""
FAR = to.placement((0.0, -0.8, ON_TOP))


@pytest.fixture
def arm(planar_arm: to.Robot) -> to.Robot:
    return planar_arm


def reduced_in(scene: to.Scene) -> ReducedModel:
    return reduce_model(scene, "arm", np.zeros(len(scene.robot.joint_names)))


def turning(reduced: ReducedModel, times: list[float], angles: list[float]) -> to.Trajectory:
    """Return a motion of the first joint through angles, at rest at each of the times."""
    points = np.zeros((len(times), len(reduced.joint_names)))
    points[:, 0] = angles
    rest = np.zeros_like(points)
    return to.Trajectory(reduced.joint_names, np.array(times), points, rest, rest.copy())


def visit(begin: float, end: float, *, gap: float) -> Track:
    """Return the track of a ball of 5 cm that comes as near as `gap` to the forearm, and leaves again."""
    side = to.placement((0.75, 0.0, ON_TOP + 0.6))
    near = to.placement((0.75, 0.0, ON_TOP + gap))
    return Track.through([begin, (begin + end) / 2, end], [side, near, side])


def checks_of(certificate: Certificate) -> tuple[Check, Check]:
    (always,) = (check for check in certificate.checks if check.kind is CheckKind.CLEARANCE)
    (at_fault,) = (check for check in certificate.checks if check.kind is CheckKind.AT_FAULT)
    return always, at_fault


def judged(scene: to.Scene, times: list[float], angles: list[float]) -> Certificate:
    reduced = reduced_in(scene)
    return verify(reduced, turning(reduced, times, angles), goals=())


def test_contact_with_a_link_at_rest_is_not_at_fault_but_not_verified(arm: to.Robot) -> None:
    touching = alone(arm).add("ball", to.Sphere(0.05), motion=visit(0.1, 0.9, gap=-0.01))
    certificate = judged(touching, [0.0, 1.0, 2.0], [0.0, 0.0, 1.5])
    always, at_fault = checks_of(certificate)
    assert not always.holds and always.evidence is Evidence.SAMPLED and not certificate.verified
    assert at_fault.holds and at_fault.evidence is Evidence.PROVEN and not at_fault.required
    assert certificate.clearance < 0.0 and certificate.at_fault > 0.05
    assert at_fault.value == certificate.at_fault


@pytest.mark.parametrize("rest", [0, 1, 2])
def test_a_rest_may_be_at_the_start_in_the_middle_or_at_the_end(arm: to.Robot, rest: int) -> None:
    angles = {0: [0.0, 0.0, 1.5], 1: [1.5, 0.0, 0.0, 1.5], 2: [1.5, 0.0, 0.0]}[rest]
    begin = 0.0 if rest == 0 else 1.0
    scene = alone(arm).add("ball", to.Sphere(0.05), motion=visit(begin + 0.1, begin + 0.9, gap=-0.01))
    reduced = reduced_in(scene)
    motion = turning(reduced, [float(number) for number in range(len(angles))], angles)
    certificate = verify(reduced, motion, goals=())
    assert certificate.clearance < 0.0 and certificate.at_fault > 0.05
    through = verify(reduced, turning(reduced, [0.0, 2 * begin + 1.0], [-1.5, 1.5]), goals=())
    assert through.at_fault == pytest.approx(through.clearance, abs=1e-3) and through.clearance < 0.0


def test_a_link_that_moves_into_a_resting_object_is_at_fault(arm: to.Robot) -> None:
    post = alone(arm).add("post", to.Cylinder(0.05, 2.0), to.placement((0.0, 0.7, 0.5)), appears=0.2)
    certificate = judged(post, [0.0, 1.0, 2.0], [0.0, 0.0, 1.5])
    always, at_fault = checks_of(certificate)
    assert not at_fault.holds and at_fault.evidence is Evidence.SAMPLED
    assert certificate.at_fault == pytest.approx(certificate.clearance, abs=1e-3)
    assert at_fault.time is not None and always.time is not None and at_fault.time > 1.0
    assert "post" in at_fault.subject and "while the robot's part of them moves" in at_fault.detail


def test_a_link_that_never_moves_is_never_at_fault(arm: to.Robot) -> None:
    base = Track.through([0.0, 1.0, 2.0], [to.placement((x, 0.0, 0.03)) for x in (3.0, 0.0, 3.0)])
    certificate = judged(alone(arm).add("ball", to.Sphere(0.02), motion=base), [0.0, 2.0], [0.0, 1.0])
    assert certificate.clearance < 0.0 < certificate.at_fault


def test_the_nearer_of_still_things_and_moving_ones_counts(arm: to.Robot) -> None:
    scene = alone(arm).add("post", to.Sphere(0.05), to.placement((0.75, 0.0, ON_TOP + 0.03)))
    alone_there = judged(scene, [0.0, 1.0, 2.0], [0.0, 0.0, 1.5])
    among = judged(
        scene.add("ball", to.Sphere(0.05), motion=visit(0.1, 0.9, gap=-0.01)),
        [0.0, 1.0, 2.0],
        [0.0, 0.0, 1.5],
    )
    assert among.at_fault == pytest.approx(alone_there.clearance, abs=1.2e-3)
    assert alone_there.at_fault == alone_there.clearance
    assert all(check.kind is not CheckKind.AT_FAULT for check in alone_there.checks)


def test_both_numbers_are_printed_and_written(arm: to.Robot) -> None:
    scene = alone(arm).add("ball", to.Sphere(0.05), motion=Prediction(visit(0.1, 0.9, gap=0.01), until=9.0))
    certificate = judged(scene, [0.0, 1.0, 2.0], [0.0, 0.0, 1.5])
    assert checks_of(certificate)[0].holds
    data = certificate.as_dict()
    assert data["clearance"] == certificate.clearance < data["at_fault"] == certificate.at_fault
    assert "clearance at fault" in str(certificate) and "at fault" in repr(certificate)


def test_a_refuted_clearance_is_marked_as_measured(arm: to.Robot) -> None:
    touching = alone(arm).add("ball", to.Sphere(0.05), motion=visit(0.1, 0.9, gap=-0.01))
    refuted = judged(touching, [0.0, 1.0, 2.0], [0.0, 0.0, 1.5])
    assert "mm measured" in refuted.closest and "proven" not in refuted.closest
    clear = judged(alone(arm).add("ball", to.Sphere(0.05), FAR), [0.0, 1.0], [0.0, 1.5])
    assert clear.closest.endswith("proven")


def test_where_nothing_has_to_keep_apart_there_is_nothing_to_come_near(arm: to.Robot) -> None:
    belt = alone(arm).add("belt", (), motion=Track.through([0.0, 1.0], [FAR, to.placement((0.5, 0.0, 0.2))]))
    certificate = judged(belt, [0.0, 1.0], [0.0, 1.5])
    always, at_fault = checks_of(certificate)
    assert always.holds and at_fault.holds and at_fault.value is None
    assert certificate.clearance == certificate.at_fault == np.inf
