"""Clearance over all time: nothing thin is missed, bounds are sound and tight, failures are named."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.oracles.judge_distances import PlainDistances
from tests.verify.arms import mixed_arm, planar_arm, quintic, reduced, wavy
from trajopt.robot.bodies import MeshPolicy
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.placement import placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Plane, Sphere, convex
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Certificate, Check, Evidence, VerifyOptions, verify
from trajopt.verify.kernel.kinematics import Kinematics

SWEEP = [[-1.0, 0.0], [1.0, 0.0]]


def clearance(certificate: Certificate) -> Check:
    return next(check for check in certificate.checks if check.name == "clearance")


def densest(model: ReducedModel, trajectory: Trajectory, samples: int = 400) -> float:
    """Smallest distance of any pair at many samples."""
    distances = PlainDistances(model, error=1e-12)
    poses = Kinematics(model).poses(trajectory(np.linspace(0.0, trajectory.duration, samples)))
    count = len(distances.first)
    cell, pair = np.repeat(np.arange(samples), count), np.tile(np.arange(count), samples)
    return float(distances.measure(poses, cell, pair).min())


@pytest.mark.parametrize("angle", np.linspace(-0.9, 0.9, 23))
def test_a_plate_of_one_millimetre_is_found(tmp_path: Path, angle: float) -> None:
    """The tip crosses it in 2 ms of a motion of one second."""
    where = placement((1.005 * np.cos(angle), 1.005 * np.sin(angle), 0.0), rpy=(0, 0, angle))
    plate = Box(0.02, 0.001, 0.02)
    scene = Scene(planar_arm(tmp_path)).add("plate", plate, where)
    model = reduced(scene, SWEEP[0])
    certificate = verify(model, quintic(model, SWEEP, 1.0), goals=())
    assert not certificate.verified
    check = clearance(certificate)
    assert check.subject == "lower - plate"
    assert check.evidence is Evidence.SAMPLED
    assert check.value == pytest.approx(-0.005, abs=1e-3), "the tip dips 5 mm into the plate"
    trajectory = quintic(model, SWEEP, 1.0)
    assert check.time is not None
    assert trajectory(check.time)[0] == pytest.approx(angle, abs=0.03)


def test_a_plate_just_out_of_reach_is_proven_to_be_missed(tmp_path: Path) -> None:
    """The tip's outer corners move on a circle; the plate begins half a millimetre outside."""
    circle = np.hypot(1.0, 0.01)
    where = placement((circle + 0.0005 + 0.01, 0.0, 0.0))
    scene = Scene(planar_arm(tmp_path)).add("plate", Box(0.02, 0.001, 0.02), where)
    model = reduced(scene, SWEEP[0])
    certificate = verify(model, quintic(model, SWEEP, 1.0), goals=())
    assert certificate.verified, str(certificate)
    assert 0.7 * 0.0005 <= certificate.clearance <= 0.0005
    (pair,) = certificate.pairs
    assert (pair.first, pair.second) == ("lower", "plate")
    assert pair.proven == certificate.clearance
    assert 0.0005 - 2e-6 <= pair.measured <= 0.0006


@given(seed=st.integers(0, 10**6))
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_verdicts_agree_with_dense_sampling(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = Scene(mixed_arm(tmp_path))
    for a, b in (("a", "c"), ("c", "finger"), ("b", "d"), ("a", "d"), ("a", "finger"), ("b", "finger")):
        scene = scene.allow(a, b)
    for number in range(4):
        shape = (Box(*rng.uniform(0.01, 0.3, 3)), Sphere(rng.uniform(0.02, 0.2)))[number % 2]
        where = placement(rng.uniform(-1.0, 1.3, 3), rpy=rng.uniform(-3.0, 3.0, 3))
        scene = scene.add(f"thing {number}", shape, where)
    model = reduced(scene, [0.1, -0.2, 0.05, 0.3])
    trajectory = wavy(model, seed)
    certificate = verify(model, trajectory, goals=())
    check, measured = clearance(certificate), densest(model, trajectory)
    if check.holds:
        assert certificate.clearance <= measured
        if measured < 0.04:
            assert certificate.clearance >= min(measured, certificate.pairs[0].measured) - 1.001e-3
    else:
        assert check.evidence is Evidence.SAMPLED, "no verdict may stay open here"
        assert check.value is not None
        assert measured < 1e-4
        assert check.value <= 0.5 * measured + 2e-3, "the depth is of the size of the largest"


def test_links_against_each_other(tmp_path: Path) -> None:
    """The tip's ball passes the base's ball; only the relative motion counts."""
    scene = Scene(planar_arm(tmp_path)).add("hub", Sphere(0.1), placement((0.0, 0.0, 0.0)))
    scene = scene.add("ball", Sphere(0.05), placement((0.5, 0.0, 0.0)), frame="lower", touch_links=["lower"])
    scene = scene.allow("hub", "upper").allow("hub", "lower").allow("ball", "upper")
    model = reduced(scene, [0.0, 0.5])
    free = verify(model, quintic(model, [[0.0, 0.5], [1.0, 2.5]], 1.0), goals=())
    expected = 2.0 * 0.5 * np.cos(2.5 / 2.0) - 0.15
    assert free.verified
    assert expected - 1e-3 <= free.clearance <= expected
    spin = verify(model, quintic(model, [[0.0, 0.5], [2.9, 0.5]], 1.0), goals=())
    assert spin.clearance > 0.05
    assert spin.counts.distances < 100
    hit = verify(model, quintic(model, [[0.0, 0.5], [0.0, 2.9]], 1.0), goals=())
    assert clearance(hit).value == pytest.approx(2.0 * 0.5 * np.cos(2.9 / 2.0) - 0.15, abs=1e-5)
    assert clearance(hit).time == pytest.approx(1.0)


def test_a_half_space_on_a_moving_link(tmp_path: Path) -> None:
    scene = Scene(planar_arm(tmp_path)).add(
        "shield", Plane(), placement((-0.2, 0, 0), rpy=(0, np.pi / 2, 0)), frame="upper"
    )
    scene = scene.add("post", Sphere(0.1), placement((0.0, 0.6, 0.0)))
    for name in ("upper", "lower", "tip", "base"):
        scene = scene.allow("shield", name).allow("post", name)
    model = reduced(scene, [0.0, 0.0])
    # In the frame of the upper link the solid is x < -0.2; the post is at angle pi/2 - q.
    good = verify(model, quintic(model, [[0.0, 0.0], [1.0, 0.5]], 1.0), goals=())
    assert good.verified, str(good)
    dips = quintic(model, [[0.0, 0.0], [-1.2, 0.0]], 1.0)
    bad = clearance(verify(model, dips, goals=()))
    assert bad.value == pytest.approx(0.6 * np.cos(np.pi / 2 + 1.2) + 0.2 - 0.1, abs=1e-5)
    assert bad.subject == "shield - post"


def test_standing_still_is_cheap(tmp_path: Path) -> None:
    scene = Scene(planar_arm(tmp_path)).add("near", Box(0.1, 0.1, 0.1), placement((0.5, 0.0701, 0.0)))
    model = reduced(scene, [0.0, 0.0])
    certificate = verify(model, quintic(model, [[0.0, 0.0]] * 5, 60.0), goals=())
    assert certificate.verified, str(certificate)
    assert certificate.clearance == pytest.approx(0.0101, abs=2e-6)
    assert certificate.counts.distances < 500


def test_contact_at_the_start_is_not_a_proof(tmp_path: Path) -> None:
    scene = Scene(planar_arm(tmp_path)).add("wall", Box(0.2, 0.1, 0.1), placement((0.9, -0.06, 0.0)))
    model = reduced(scene, [0.0, 0.0])
    certificate = verify(model, quintic(model, [[0.0, 0.0], [0.5, 0.0]], 1.0), goals=())
    assert not certificate.verified
    assert clearance(certificate).time == 0.0
    assert clearance(certificate).value == pytest.approx(0.0, abs=2e-5)


def test_giving_up_names_the_interval(tmp_path: Path) -> None:
    scene = Scene(planar_arm(tmp_path)).add("post", Sphere(0.1), placement((1.1012, 0.0, 0.0)))
    model = reduced(scene, SWEEP[0])
    hasty = VerifyOptions(most_distances=3)
    certificate = verify(model, quintic(model, SWEEP, 1.0), goals=(), options=hasty)
    assert not certificate.verified
    assert clearance(certificate).evidence is Evidence.UNPROVEN
    found = certificate.unproven
    assert found is not None
    assert (found.first, found.second) == ("lower", "post")
    assert 0.0 <= found.begin < found.end <= 1.0
    assert "no proof" in clearance(certificate).detail
    assert all(pair.proven is None for pair in certificate.pairs)
    assert verify(model, quintic(model, SWEEP, 1.0), goals=()).verified


def test_an_exact_mesh_encloses_and_is_passed(tmp_path: Path) -> None:
    corners = convex([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    exact = MeshPolicy(exact=True)
    arm = planar_arm(tmp_path)
    shell = (
        Scene(arm)
        .add("shell", Mesh(corners.vertices * 3.0, corners.faces), meshes=exact)
        .allow("shell", "base")
    )
    model = reduced(shell, SWEEP[0])
    inside = verify(model, quintic(model, SWEEP, 1.0), goals=())
    assert not inside.verified, "the arm is deep inside the solid, far from its surface"
    crate = Mesh(corners.vertices * 0.05, corners.faces)
    beside = Scene(arm).add("crate", crate, placement((1.1, 0.0, 0.0)), meshes=exact)
    model = reduced(beside, SWEEP[0])
    passed = verify(model, quintic(model, SWEEP, 1.0), goals=())
    assert passed.verified
    assert 0.0475 < passed.clearance <= 0.05
    through = Scene(arm).add("crate", crate, placement((1.0, 0.0, 0.0)), meshes=exact)
    model = reduced(through, SWEEP[0])
    assert not verify(model, quintic(model, SWEEP, 1.0), goals=()).verified


def test_without_pairs_there_is_nothing_to_prove(tmp_path: Path) -> None:
    model = reduced(Scene(planar_arm(tmp_path)), [0.0, 0.0])
    certificate = verify(model, quintic(model, SWEEP, 1.0), goals=())
    assert certificate.clearance == np.inf
    assert clearance(certificate).holds
