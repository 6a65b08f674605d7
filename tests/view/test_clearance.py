import numpy as np
import pytest

from trajopt.view.clearance import ClearanceQuery, PairKind

from .conftest import Motion


def test_kinds_name_every_pair(motion: Motion) -> None:
    query = ClearanceQuery(motion.reduced, motion.trajectory.duration)
    pairs, bodies = motion.reduced.pairs, motion.reduced.bodies
    for kind, a, b in zip(query.kinds(), pairs.first, pairs.second, strict=True):
        owners = {bodies[a].owner, bodies[b].owner}
        if "cup" in owners:
            assert kind is PairKind.CARRIED
        elif owners & {"post", "table"}:
            assert kind is PairKind.SURROUNDINGS
        else:
            assert kind is PairKind.SELF


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


def test_nearest_is_what_geometry_says(motion: Motion) -> None:
    # The arm, 60 mm thick, points at 0.35 rad; the post, 80 mm thick, stands at (0.3, 0.3).
    query = ClearanceQuery(motion.reduced, motion.trajectory.duration)
    end = motion.trajectory.duration
    nearest = query.nearest(end, motion.trajectory(np.array([end]))[0])
    assert nearest is not None
    assert set(nearest.owners) == {"arm", "post"}
    across = np.array([-np.sin(0.35), np.cos(0.35)])
    assert nearest.distance == pytest.approx(across @ (0.3, 0.3) - 0.03 - 0.04, abs=1e-6)
    assert nearest.margin == motion.reduced.scene.margin


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
    assert np.isinf(smallest[PairKind.SURROUNDINGS]).all()
