from dataclasses import replace

import numpy as np
import pytest

from trajopt.scene.reducing import reduce_model
from trajopt.viewer.clearance import ClearanceKind, ClearanceQuery, sample_motion
from trajopt.viewer.readout import clearance_html

from .conftest import Motion


def test_kinds_name_every_pair(motion: Motion) -> None:
    query = ClearanceQuery(motion.reduced, motion.trajectory.duration)
    pairs, bodies = motion.reduced.pairs, motion.reduced.bodies
    for kind, a, b in zip(query.kinds(), pairs.first, pairs.second, strict=True):
        owners = {bodies[a].owner, bodies[b].owner}
        if "cup" in owners:
            assert kind is ClearanceKind.CARRIED
        elif owners & {"post", "table"}:
            assert kind is ClearanceKind.SURROUNDINGS
        else:
            assert kind is ClearanceKind.SELF


def test_nearest_is_the_smallest_of_all_kinds(motion: Motion) -> None:
    query = ClearanceQuery(motion.reduced, motion.trajectory.duration)
    times = np.linspace(0.0, motion.trajectory.duration, 23)
    along = motion.trajectory(times)
    smallest = np.min(list(query.smallest(times, along, 10.0).values()), axis=0)
    for sample, t in enumerate(times):
        nearest = query.nearest(float(t), along[sample])
        assert nearest is not None
        assert nearest.distance == pytest.approx(smallest[sample], abs=1e-9)
        apart = np.linalg.norm(nearest.points[1] - nearest.points[0])
        assert apart == pytest.approx(abs(nearest.distance), abs=1e-6)


def test_the_nearest_pair_equals_the_geometry(motion: Motion) -> None:
    # The arm, 60 mm thick, points at 0.35 rad; the post, 80 mm thick, stands at (0.3, 0.3).
    query = ClearanceQuery(motion.reduced, motion.trajectory.duration)
    end = motion.trajectory.duration
    nearest = query.nearest(end, motion.trajectory(np.array([end]))[0])
    assert nearest is not None
    assert set(nearest.owners) == {"arm", "post"}
    across = np.array([-np.sin(0.35), np.cos(0.35)])
    assert nearest.distance == pytest.approx(across @ (0.3, 0.3) - 0.03 - 0.04, abs=1e-6)
    assert nearest.margin == motion.reduced.scene.margin
    assert nearest.required == 0.0


def test_the_pair_with_the_least_beyond_its_required_clearance_is_the_nearest(motion: Motion) -> None:
    scene = motion.reduced.scene.with_clearance(0.6, "hand", "post")
    reduced = reduce_model(scene, "all", motion.reduced.all_positions(motion.reduced.start_positions))
    query, times = ClearanceQuery(reduced, 1.5), np.array([0.0])
    nearest = query.nearest(0.0, motion.trajectory(times)[0])
    assert nearest is not None and set(nearest.owners) == {"hand", "post"}
    # The hand, a ball of 20 mm, is at 0.6 m along -0.8 rad, the post of 40 mm at (0.3, 0.3).
    apart = np.hypot(0.6 * np.cos(0.8) - 0.3, -0.6 * np.sin(0.8) - 0.3) - 0.02 - 0.04
    assert nearest.distance == pytest.approx(apart, abs=1e-6)
    assert nearest.required == 0.6 and nearest.margin == pytest.approx(0.605)
    assert ("below the required 600 mm" in clearance_html(nearest)) == (apart < 0.6)
    far = replace(nearest, distance=0.602)
    assert "below the margin of 605 mm, required 600 mm" in clearance_html(far)
    samples = sample_motion(reduced, motion.trajectory, reduced.limits, ())
    assert samples.required == (0.6,) and samples.margins == pytest.approx((0.01, 0.605))


def test_meant_contact_is_left_out_only_while_it_is_meant(motion: Motion) -> None:
    query = ClearanceQuery(motion.reduced, motion.trajectory.duration)
    pair = motion.reduced.pairs.allowances[0][0]
    meant = query.meant(np.array([0.0, 0.19, 0.21, 1.5]))
    assert meant[:, pair].tolist() == [True, True, False, False]
    assert meant.sum() == 2


def test_beyond_reach_is_infinite(motion: Motion) -> None:
    query = ClearanceQuery(motion.reduced, motion.trajectory.duration)
    times = np.array([0.0])
    smallest = query.smallest(times, motion.trajectory(times), 1e-6)
    assert np.isinf(smallest[ClearanceKind.SURROUNDINGS]).all()
