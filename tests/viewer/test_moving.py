"""The page and the plots among what moves, appears and expires."""

from collections.abc import Iterator

import numpy as np
import pytest

import trajopt as to
from trajopt.scene.reducing import reduce_model
from trajopt.viewer import Viewer, plot_motion, view
from trajopt.viewer.clearance import ClearanceKind, ClearanceQuery, sample_motion
from trajopt.viewer.readout import clearance_html

from .conftest import Motion
from .test_viewer import free_port

FALLS = to.Track.through((0.0, 1.0), [to.placement((0.3, 0.0, z)) for z in (1.5, 0.5)])
"""Above the arm, which is at most at 0.43 m and 30 mm thick on either side."""


@pytest.fixture
def among(motion: Motion) -> Motion:
    known = to.Prediction(FALLS, (0.01, 0.02, 0.0))
    scene = (
        motion.reduced.scene.add("ball", to.Sphere(0.05), motion=known, expires=1.2)
        .add("flag", to.Box(0.02, 0.02, 0.02), to.placement((0.0, 0.0, 0.2)), frame="ball")
        .add("lamp", to.Sphere(0.01), to.placement((0.3, 0.0, 0.6)), appears=0.5)
    )
    return Motion(reduce_model(scene, "all", motion.reduced.start), motion.trajectory)


@pytest.fixture
def viewer(among: Motion) -> Iterator[Viewer]:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    opened = view(among.reduced, among.trajectory, port=free_port())
    yield opened
    opened.close()


def test_dynamic_obstacles_are_drawn_at_their_places_and_times(viewer: Viewer) -> None:
    for time, present in ((0.25, {"ball", "flag"}), (0.7, {"ball", "flag", "lamp"}), (1.3, {"flag", "lamp"})):
        viewer.show(time)
        shown = {name for name, handle in viewer._scene.drawing._objects if handle.visible}
        assert shown == {"post", "table", "cup"} | present
        where = viewer.joint_placement("ball along z").translation
        np.testing.assert_allclose(where, FALLS.at(time).translation, atol=1e-6)


def test_halos_are_as_large_as_the_error(viewer: Viewer) -> None:
    for time, seen in ((0.0, {"ball", "flag"}), (1.0, {"ball", "flag"}), (1.3, {"flag"})):
        viewer.show(time)
        halos = {name: handle for name, _, handle in viewer._scene.drawing._halos}
        assert {name for name, handle in halos.items() if handle.visible} == seen
        if "ball" in seen:
            reach = np.linalg.norm(halos["ball"].vertices, axis=1)
            np.testing.assert_allclose(reach, 0.05 + 0.01 + 0.02 * time, atol=1e-6)


def test_the_nearest_pair_includes_errors_and_only_present_objects(among: Motion) -> None:
    query = ClearanceQuery(among.reduced, among.trajectory.duration)
    times = np.linspace(0.0, 1.5, 16)
    along = among.trajectory(times)
    smallest = np.min(list(query.smallest(times, along, 10.0).values()), axis=0)
    for sample, time in enumerate(times.tolist()):
        nearest = query.nearest(time, along[sample])
        assert nearest is not None and nearest.distance == pytest.approx(smallest[sample], abs=1e-9)
        assert "lamp" not in nearest.owners or time >= 0.5
        assert "ball" not in nearest.owners or time <= 1.2
        if "ball" in nearest.owners:
            apart = np.linalg.norm(nearest.points[1] - nearest.points[0])
            assert nearest.error == pytest.approx(0.01 + 0.02 * time)
            assert apart - nearest.error == pytest.approx(nearest.distance, abs=1e-6)
            assert "off its track" in clearance_html(nearest)


def test_dynamic_obstacles_count_as_surroundings_in_plots(motion: Motion, among: Motion) -> None:
    query = ClearanceQuery(among.reduced, 1.5)
    for kind, pair in zip(query.kinds(), range(len(query.reduced.pairs.first)), strict=True):
        if {"ball", "flag"} & set(query.reduced.owners(pair)) and "cup" not in query.reduced.owners(pair):
            assert kind is ClearanceKind.SURROUNDINGS
    limits = motion.reduced.limits
    before, after = (sample_motion(each.reduced, each.trajectory, limits, ()) for each in (motion, among))
    kind = ClearanceKind.SURROUNDINGS
    assert (after.clearances[kind] <= before.clearances[kind] + 1e-9).all()
    assert (after.clearances[kind] < before.clearances[kind] - 0.01).any()


def test_a_motion_among_them_is_plotted(among: Motion, tmp_path: object) -> None:
    assert plot_motion(among.reduced, among.trajectory, f"{tmp_path}/a.png").stat().st_size > 10_000
