"""The judge among things that move, appear and expire, against distances by Coal at many times."""

from itertools import combinations

import coal
import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry.geometry import collision_geometry
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.track import Prediction, Track
from trajopt.values.errors import ShapeError
from trajopt.verify import verify
from trajopt.verify.certificate import Certificate, Check, CheckKind

SAMPLES = 1500
NEAR = 0.012
"""By how much the nearest sample may be farther than what the judge finds: its own resolution, and what lies
between samples [m]."""


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


def sampled(scene: to.Scene, reduced: ReducedModel, motion: to.Trajectory) -> float:
    """Return the least distance of the arm from the objects at many times, less their errors."""
    model, data, least = reduced.model, reduced.model.createData(), np.inf
    fixed = [body for body in reduced.bodies if body.owner not in scene.objects]
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    for time in np.linspace(0.0, motion.duration, SAMPLES).tolist():
        pin.forwardKinematics(model, data, reduced.configuration(motion(time)))
        for item in scene.objects.values():
            if not item.timing.appears <= time <= item.timing.expires:
                continue
            carrier = item if item.frame == "world" else scene.objects[item.frame]
            known = carrier.timing.motion
            where = carrier.placement if known is None else known.track.at(time)
            where = where if carrier is item else where * item.placement
            error = 0.0 if known is None else known.error_at(time)
            for shape, part in item.parts:
                there = where * part
                for body in fixed:
                    at = data.oMi[body.joint]
                    moved = to.Placement(at.rotation, at.translation) * body.placement
                    result.clear()
                    distance = coal.distance(
                        collision_geometry(body.shape),
                        coal.Transform3s(moved.rotation, moved.translation),
                        collision_geometry(shape),
                        coal.Transform3s(there.rotation, there.translation),
                        request,
                        result,
                    )
                    least = min(least, distance - error)
    return least


def swing(reduced: ReducedModel, rng: np.random.Generator) -> to.Trajectory:
    size = len(reduced.joint_names)
    points = np.stack((reduced.start_positions, *rng.uniform(-0.8, 0.8, (2, size))))
    rest = np.zeros((3, size))
    return to.Trajectory(reduced.joint_names, np.array((0.0, 0.7, 1.5)), points, rest, rest.copy())


def alone(arm: to.Robot) -> to.Scene:
    """Return a scene in which the arm's links may touch each other."""
    scene = to.Scene(arm)
    for one, other in combinations(arm.links, 2):
        scene = scene.allow(one, other)
    return scene


def clearance_of(certificate: Certificate) -> Check:
    (check,) = (check for check in certificate.checks if check.kind is CheckKind.CLEARANCE)
    return check


def random_scene(arm: to.Robot, rng: np.random.Generator) -> to.Scene:
    """Return boxes on random tracks with growing errors, one carried, one that comes and goes."""

    def place() -> to.Placement:
        return to.placement(rng.uniform((0.5, -1.2, -0.2), (1.4, 1.2, 1.4)), rpy=rng.uniform(-3.0, 3.0, 3))

    track = Track.through([0.1, 0.6, 1.1, 1.4], [place() for _ in range(4)])
    straight = Track.constant_velocity(
        place(), rng.uniform(-0.5, 0.5, 3), angular_velocity=rng.uniform(-2.0, 2.0, 3)
    )
    return (
        alone(arm)
        .add("box", to.Box(0.1, 0.2, 0.15), motion=Prediction(track, (0.01, 0.02, 0.01), until=3.0))
        .add("lid", to.Sphere(0.05), to.placement((0.0, 0.0, 0.2)), frame="box")
        .add("cart", to.Cylinder(0.08, 0.3), motion=straight, appears=0.3, expires=1.2)
        .add("post", to.Box(0.1, 0.1, 0.8), place(), expires=float(rng.uniform(0.2, 1.4)))
    )


@pytest.mark.parametrize("seed", range(12))
def test_proven_clearances_hold_at_every_sampled_time(arm: to.Robot, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = random_scene(arm, rng)
    reduced = reduce_model(scene, "all", np.zeros(len(arm.joint_names)))
    motion = swing(reduced, rng)
    check = clearance_of(verify(reduced, motion, goals=()))
    least = sampled(scene, reduced, motion)
    assert check.value is not None
    if check.holds:
        assert least >= check.value - 1e-6
        assert check.value >= min(least, 0.05) - NEAR
    else:
        assert least < NEAR


def grown(scene: to.Scene, name: str, by: tuple[float, float, float]) -> to.Scene:
    """Return the scene with a larger error of one prediction."""
    item = scene.objects[name]
    known = item.timing.motion
    assert known is not None
    error = tuple(a + b for a, b in zip(known.error, by, strict=True))
    again = scene.remove("lid").remove(name)
    return again.add(
        name, item.parts, motion=Prediction(known.track, (error[0], error[1], error[2]), known.until)
    )


@pytest.mark.parametrize("seed", [1, 3])
@pytest.mark.parametrize("part", range(3))
def test_an_error_larger_than_the_remaining_clearance_is_refused(arm: to.Robot, seed: int, part: int) -> None:
    rng = np.random.default_rng(seed)
    track = Track.through([0.0, 0.75, 1.5], [to.placement((x, 0.9, 0.4)) for x in (1.5, 0.9, 1.5)])
    scene = alone(arm).add("lid", to.Sphere(0.01), to.placement((5.0, 5.0, 5.0)))
    scene = scene.add("box", to.Box(0.1, 0.1, 0.1), motion=Prediction(track))
    reduced = reduce_model(scene, "all", np.zeros(len(arm.joint_names)))
    motion = swing(reduced, rng)
    found = clearance_of(verify(reduced, motion, goals=()))
    assert found.holds and found.value is not None and found.time is not None
    for share, holds in ((0.5, True), (1.1, False)):
        # At its nearest the error has grown to a share of the distance.
        growth = np.array((1.0, found.time, found.time**2 / 2.0))
        by = np.zeros(3)
        by[part] = share * found.value / growth[part]
        if holds:
            by /= motion.duration**part / found.time**part  # nowhere more than that share
        wider = reduce_model(grown(scene, "box", (by[0], by[1], by[2])), "all", reduced.start)
        assert clearance_of(verify(wider, motion, goals=())).holds is holds


def test_nothing_is_proven_after_the_prediction(arm: to.Robot) -> None:
    track = Track.constant_velocity(to.placement((3.0, 0.0, 0.0)), (0.1, 0.0, 0.0))
    for until, holds in ((1.6, True), (1.4, False)):
        scene = alone(arm).add("box", to.Box(0.1, 0.1, 0.1), motion=Prediction(track, until=until))
        reduced = reduce_model(scene, "all", np.zeros(len(arm.joint_names)))
        certificate = verify(reduced, swing(reduced, np.random.default_rng(0)), goals=())
        (check,) = (check for check in certificate.checks if check.kind is CheckKind.PREDICTION)
        assert check.holds is holds
        assert check.detail == f"the prediction of box ends at {until:g} s, but is needed until 1.500 s"
        assert f"proven given that box is on its track until {until:g} s" in certificate.notes


@pytest.mark.parametrize(("appears", "expires", "holds"), [(1.51, 9.0, True), (0.0, 1e-3, False)])
def test_absent_objects_may_overlap_the_arm(
    arm: to.Robot, appears: float, expires: float, holds: bool
) -> None:
    scene = alone(arm).add("block", to.Box(2.0, 2.0, 2.0), appears=appears, expires=expires)
    reduced = reduce_model(scene, "all", np.zeros(len(arm.joint_names)))
    found = clearance_of(verify(reduced, swing(reduced, np.random.default_rng(0)), goals=()))
    assert found.holds is holds


def test_a_later_clock_sees_the_later_world(arm: to.Robot) -> None:
    track = Track.through([0.0, 2.0], [to.placement((3.0, 0.0, 0.3)), to.placement((0.2, 0.0, 0.3))])
    scene = alone(arm).add("box", to.Box(0.1, 0.1, 0.1), motion=track)
    start = np.zeros(len(arm.joint_names))
    motion = swing(reduce_model(scene, "all", start), np.random.default_rng(0))
    for time, holds in ((0.0, True), (1.4, False)):
        later = scene.at(time)
        assert later.objects["box"].parts[0][0] is scene.objects["box"].parts[0][0]
        assert later.placement_of("box", start) == track.at(time)
        assert clearance_of(verify(reduce_model(later, "all", start), motion, goals=())).holds is holds
    with pytest.raises(ShapeError, match="must not be before 0 s"):
        scene.at(-1.0)
