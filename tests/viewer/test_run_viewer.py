"""The page of a run: live, and of a recording, with the plan, the stop, what was known and what happened."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.viewer.test_page import CHROMIUM, FLAGS, PATIENCE, canvas, changed, until
from trajopt.driving import (
    EventKind,
    IdealExecutor,
    Logbook,
    Recording,
    Supervisor,
    read_recording,
    write_recording,
)
from trajopt.values.errors import ProblemError
from trajopt.viewer import RunViewer, view_run, watch_run
from trajopt.viewer.readout import events_html

from .conftest import Motion
from .test_viewer import free_port

COMES = to.Track.through((0.0, 3.0), [to.placement((0.9, -0.6, z)) for z in (0.9, 0.6)])


@pytest.fixture(scope="module")
def problem(motion: Motion) -> to.Problem:
    ball = to.Prediction(COMES, (0.02, 0.02, 0.0))
    scene = to.Scene(motion.reduced.scene.robot).add(
        "post", to.Cylinder(0.04, 0.6), to.placement((-0.4, 0.3, 0.3))
    )
    start = {"slide": 0.12, "turn": -0.8, "wrist": 0.0}
    goal = to.joint_positions({"slide": 0.2, "turn": 1.2, "wrist": 0.5})
    return to.Problem(scene=scene.add("ball", to.Sphere(0.05), motion=ball), start=start, goal=goal)


def driven(problem: to.Problem, look: object, cycles: int = 400) -> Supervisor:
    """Drive to the goal; a box appears on the way."""
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    arm = IdealExecutor(problem.reduced.joint_names, problem.reduced.start_positions)
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    for cycle in range(cycles):
        if not supervisor.busy:
            break
        if cycle == 20:
            supervisor.see(
                problem.scene.add("box", to.Box(0.1, 0.1, 0.1), to.placement((-0.5, 0.3, 0.3))), 0.0
            )
        supervisor.cycle()
        look(supervisor)  # pyright: ignore
        arm.advance(0.02)
    return supervisor


@pytest.fixture(scope="module")
def recording(problem: to.Problem) -> Recording:
    logbook = Logbook()
    assert driven(problem, logbook.look).events[-1].kind is EventKind.REACHED
    return logbook.recording


@pytest.fixture(scope="module")
def viewer(recording: Recording, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunViewer]:
    path: Path = tmp_path_factory.mktemp("run") / "run.json"
    write_recording(path, recording)
    opened = view_run(read_recording(path, recording.robot), port=free_port())
    yield opened
    opened.close()


def tool(viewer: RunViewer, positions: np.ndarray) -> np.ndarray:
    reduced = viewer.recording.reduced(viewer.recording.sightings[0])
    return reduced.scene.placement_of("hand", reduced.all_positions(positions)).translation


def test_any_time_of_a_recording_is_shown(viewer: RunViewer, recording: Recording) -> None:
    drawing = viewer._drawing
    for time in np.linspace(0.1, recording.duration - 0.2, 5).tolist():
        viewer.show(time)
        moment = recording.at(recording.begin + time)
        assert viewer.moment is not None and np.array_equal(viewer.moment.positions, moment.positions)
        assert moment.stop is not None and moment.plan is not None
        for ahead, motion in ((drawing._stop, moment.stop), (drawing._plan, moment.plan)):
            assert ahead._trail._line.visible and ahead._ghost._root.visible
            ends = ahead._trail._line.points[0, 0], ahead._trail._line.points[-1, 1]
            for end, at in zip(ends, (0.0, motion.duration), strict=True):
                np.testing.assert_allclose(end, tool(viewer, motion(at)), atol=1e-5)
        (_, hand), reduced = drawing._stop._ghost._joints[-1], drawing.reduced
        held = reduced.scene.placement_of("hand", reduced.all_positions(moment.stop(moment.stop.duration)))
        np.testing.assert_allclose(hand.position, held.translation, atol=1e-6)
    viewer.show(recording.duration)
    assert not drawing._stop._trail._line.visible and not drawing._plan._ghost._root.visible


def test_the_shown_surroundings_are_those_known_at_that_time(viewer: RunViewer, recording: Recording) -> None:
    appeared = recording.sightings[-1].since - recording.begin
    for time, known in ((appeared - 0.05, False), (appeared + 0.05, True), (appeared - 0.05, False)):
        viewer.show(time)
        shown = [known for known in viewer._drawing._around if known[1].drawing._root.visible]
        assert len(shown) == 1
        (sighting, around), *_ = shown
        names = {name for name, handle in around.drawing._objects if handle.visible}
        assert names == {"post", "ball"} | ({"box"} if known else set())
        halo = {name: handle for name, _, handle in around.drawing._halos}["ball"]
        reach = np.linalg.norm(halo.vertices, axis=1)
        since = recording.begin + time - sighting.world.stamp
        np.testing.assert_allclose(reach, 0.05 + 0.02 + 0.02 * since, atol=1e-6)
        where = around.drawing.joint_placement("ball along z").translation
        np.testing.assert_allclose(where, COMES.at(since).translation, atol=1e-6)


def test_ghosts_can_be_left_out(viewer: RunViewer) -> None:
    viewer.show(0.3)
    viewer._drawing.ghosts(stop=False, plan=True)
    viewer.show(0.3)
    assert not viewer._drawing._stop._trail._line.visible and viewer._drawing._plan._trail._line.visible
    viewer._drawing.ghosts(stop=True, plan=True)


def test_the_latest_events_are_listed_first(recording: Recording) -> None:
    told = events_html(recording.events, 2)
    assert told.index("reached") < told.index(recording.events[-2].kind.value)
    assert f"and {len(recording.events) - 2} before" in told
    assert "none yet" in events_html((), 2)


def test_a_run_is_shown_while_it_executes(problem: to.Problem) -> None:
    opened = watch_run(problem, port=free_port())
    try:
        assert opened.moment is None
        with pytest.raises(ProblemError, match="the logbook has no sample"):
            opened.recording  # noqa: B018
        supervisor = driven(problem, opened.look, cycles=25)
        last = supervisor.executor.now() - 0.02
        until(lambda: opened.time == pytest.approx(last), "the last look was never shown")
        until(lambda: opened.moment is not None, "the last look has no moment")
        assert opened.moment is not None and opened.moment.stop is not None
        assert opened.nearest is not None
        opened.show(0.1)
        supervisor.cycle()
        opened.look(supervisor)
        assert opened.time == pytest.approx(0.1), "somebody looks back"
        assert opened.recording.duration > 0.4
    finally:
        opened.close()


def test_refuses_a_recording_as_the_observed_world(viewer: RunViewer, problem: to.Problem) -> None:
    with pytest.raises(ProblemError, match="shows a recording"):
        driven(problem, viewer.look, cycles=1)


def test_a_recording_is_scrubbed_in_a_browser(viewer: RunViewer, recording: Recording) -> None:
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.is_file():
        pytest.skip(f"no browser at {CHROMIUM}")
    viewer.show(0.0)
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        page = browser.new_page(viewport={"width": 640, "height": 480})
        page.set_default_timeout(1000.0 * PATIENCE)
        page.goto(viewer.url)
        page.get_by_text("Events").wait_for()
        until(lambda: canvas(page).std() > 5.0, "nothing was drawn")
        before = canvas(page)
        page.get_by_role("slider").first.focus()
        page.keyboard.press("End")
        until(lambda: viewer.time == recording.duration, "the slider's time never arrived")
        page.get_by_text("reached").wait_for()
        until(lambda: changed(before, canvas(page)) > 0.005, "the picture stayed")
        viewer.show(0.3)
        page.get_by_text("started").wait_for()
        page.get_by_label("stop (orange)").uncheck()
        until(lambda: not viewer._drawing._stop._trail._line.visible, "the stop is still shown")
        browser.close()
