"""The mirror: a robot elsewhere as it is, of a server's session and of a run; gone, changed, and back."""

import json
import urllib.error
import urllib.request
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

import trajopt as to
from tests.viewer.test_live_page import PATIENCE
from tests.viewer.test_page import CHROMIUM, FLAGS, until
from trajopt.driving import IdealExecutor, Supervisor
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError, ProblemError, ShapeError
from trajopt.viewer import MirrorView, RunPublisher, mirror_view
from trajopt.viewer.mirror import MirrorClient, RemoteState, state_of

from .test_viewer import free_port

if TYPE_CHECKING:
    from tests.server.serving import Serving

START = {"joint1": 0.0, "joint2": 0.3}


@pytest.fixture
def problem() -> to.Problem:
    scene = to.Scene(to.load("planar2")).add("box", to.Box(0.1, 0.1, 0.1), to.placement((0.0, -1.5, 0.0)))
    return to.Problem(scene=scene, start=START, goal={"joint1": 1.0, "joint2": 0.3})


@pytest.fixture
def publisher(problem: to.Problem) -> Iterator[RunPublisher]:
    with RunPublisher(problem, port=0) as opened:
        yield opened


def driven(problem: to.Problem, publisher: RunPublisher) -> tuple[Supervisor, IdealExecutor]:
    arm = IdealExecutor(problem.reduced.joint_names, problem.reduced.start_positions)
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    cycles(supervisor, arm, publisher, 8)
    return supervisor, arm


def cycles(supervisor: Supervisor, arm: IdealExecutor, publisher: RunPublisher, count: int) -> None:
    for _ in range(count):
        supervisor.cycle()
        publisher.look(supervisor)
        arm.advance(0.02)


def shows(mirror: MirrorView, positions: np.ndarray) -> bool:
    return bool(np.allclose(mirror.state.positions, positions, atol=1e-12))


def test_a_run_is_mirrored_while_it_executes(problem: to.Problem, publisher: RunPublisher) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    mirror = mirror_view(publisher.url, port=free_port())
    try:
        assert not mirror.state.driven and "The robot stands" in mirror._text.content
        assert shows(mirror, problem.start_positions)
        supervisor, arm = driven(problem, publisher)
        until(lambda: mirror.state.driven, "it was never seen to move")
        until(lambda: shows(mirror, publisher.state().positions), "it lags behind")
        assert mirror.state.ahead is not None and mirror.state.events
        np.testing.assert_allclose(mirror.state.ahead[-1], (1.0, 0.3), atol=1e-3)
        until(lambda: "started" in mirror._events.content, "events are not shown")
        drawn = mirror._scene.robot.joint_placement("joint1").rotation
        assert not np.allclose(drawn, np.eye(3)), "the robot is drawn where it is"
        supervisor.see(problem.scene.add("ball", to.Sphere(0.1), to.placement((-1.5, 0.0, 0.0))))
        cycles(supervisor, arm, publisher, 2)
        until(lambda: "ball" in mirror.scene.objects, "what is seen now is not shown")
        until(lambda: set(mirror._scene._objects._drawn) == {"box", "ball"}, "it was never drawn")
    finally:
        mirror.close()


def test_a_mirror_reports_an_old_state_and_recovers(problem: to.Problem) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    publisher, port = RunPublisher(problem, port=0), free_port()
    there = int(publisher.url.rpartition(":")[2])
    mirror = mirror_view(publisher.url, port=port)
    try:
        publisher.close()
        until(lambda: "the picture is old" in mirror._text.content, "nobody said so")
        assert mirror.lost
        publisher = RunPublisher(problem, port=there)
        until(lambda: not mirror.lost and "The robot stands" in mirror._text.content, "it never came back")
    finally:
        mirror.close()
        publisher.close()


def test_a_session_of_a_server_is_mirrored(server: "Serving") -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    from trajopt.server.client import Client

    with Client(server.url) as client:
        session = client.session("planar2")
        mirror = mirror_view(f"{server.url}/sessions/{session.id}", port=free_port())
        try:
            session.edit(
                [
                    {
                        "add": {
                            "name": "post",
                            "shape": {"sphere": {"radius": 0.1}},
                            "placement": {"xyz": [2.0, 0, 0]},
                        }
                    }
                ]
            )
            until(lambda: "post" in mirror.scene.objects, "an edit is not shown")
            session.edit([{"stand": [0.4, -0.2]}])
            until(lambda: shows(mirror, np.array((0.4, -0.2))), "where it stands is not shown")
            moved = list[float]()
            goal = {"joint_positions": {"positions": {"joint1": 1.2, "joint2": 0.2}}}

            def hear(_: object) -> None:
                moved.append(float(mirror.state.positions[0]))

            session.execute({"goal": goal, "start": [0.4, -0.2]}, speed=1.0, listener=hear)
            assert any(0.45 < each < 1.15 for each in moved), "it was not seen on its way"
            until(lambda: abs(mirror.state.positions[0] - 1.2) < 1e-2, "its end is not shown")
        finally:
            mirror.close()


@pytest.fixture
def server() -> Iterator["Serving"]:
    from tests.server.serving import serving

    with serving("planar2") as up:
        yield up


def test_an_address_without_a_server_is_reported() -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    from trajopt.server.client import ServerError

    with pytest.raises(ServerError, match="unreachable"):
        mirror_view(f"http://127.0.0.1:{free_port()}")


def test_a_publisher_refuses_other_host_names(publisher: RunPublisher) -> None:
    for path, host, status in (("/state", "evil.example", 421), ("/nothing", "127.0.0.1:1", 404)):
        request = urllib.request.Request(publisher.url + path, headers={"host": host})
        with pytest.raises(urllib.error.HTTPError) as caught:
            urllib.request.urlopen(request, timeout=PATIENCE)
        assert caught.value.code == status
        caught.value.close()
    with urllib.request.urlopen(publisher.url + "/state", timeout=PATIENCE) as answer:
        assert json.load(answer)["driven"] is False


def test_a_robot_with_meshes_and_its_scene_are_transferred_whole() -> None:
    scene = to.Scene(to.load("panda")).add("cup", to.Cylinder(0.03, 0.1), to.placement((0.5, 0.0, 0.05)))
    problem = to.Problem(scene=scene, group="panda_arm", start="ready", goal="extended")
    with RunPublisher(problem, port=0) as publisher:
        source = MirrorClient(publisher.url)
        assert source.robot.joint_names == scene.robot.joint_names and set(source.scene().objects) == {"cup"}
        source.close()


def test_a_port_that_is_taken_is_refused(problem: to.Problem, publisher: RunPublisher) -> None:
    with pytest.raises(ProblemError, match="port"):
        RunPublisher(problem, port=int(publisher.url.rpartition(":")[2]))


def test_a_published_state_is_read_back(publisher: RunPublisher, problem: to.Problem) -> None:
    driven(problem, publisher)
    told = publisher.state()
    read = state_of(Node(json.loads(json.dumps(told.as_dict())), "state"), 2)
    assert read.revision == told.revision and read.driven and read.events == told.events
    np.testing.assert_array_equal(read.positions, told.positions)
    np.testing.assert_array_equal(read.ahead, told.ahead)


@pytest.mark.parametrize(
    ("changed", "error"),
    [
        ({"positions": [0.0]}, ShapeError),
        ({"positions": "here"}, ShapeError),
        ({"driven": 3}, FileFormatError),
        ({"revision": None}, FileFormatError),
        ({"ahead": [[0.0]]}, ShapeError),
        ({"events": [{"time": 0.0, "kind": "exploded"}]}, FileFormatError),
    ],
)
def test_a_state_that_is_none_is_refused(changed: dict[str, object], error: type[Exception]) -> None:
    right = RemoteState(revision=1, positions=np.zeros(2), driven=False).as_dict()
    with pytest.raises(error):
        state_of(Node({**right, **changed}, "state"), 2)


def test_a_scene_at_one_time_has_dynamic_obstacles_at_rest() -> None:
    scene = to.Scene(to.load("planar2"))
    track = to.Track.constant_velocity(to.placement((2.0, 0.0, 0.0)), velocity=(0.5, 0.0, 0.0))
    scene = (
        scene.add("cart", to.Box(0.1, 0.1, 0.1), motion=to.Prediction(track, until=3.0))
        .add("late", to.Sphere(0.1), to.placement((0.0, 3.0, 0.0)), appears=1.0, expires=2.0)
        .add("post", to.Sphere(0.1), to.placement((0.0, 4.0, 0.0)))
    )
    for time_, x, there in ((0.0, 2.0, False), (1.5, 2.75, True), (9.0, 3.5, False)):
        now = scene.still_at(time_)
        assert not now.changing and ("late" in now.objects) is there
        np.testing.assert_allclose(now.object("cart").placement.translation, (x, 0.0, 0.0))
    rest = scene.remove("cart").remove("late")
    assert rest.still_at(5.0) is rest


def test_in_a_browser_the_mirror_shows_where_the_robot_is(
    problem: to.Problem, publisher: RunPublisher
) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.is_file():
        pytest.skip(f"no browser at {CHROMIUM}")
    mirror = mirror_view(publisher.url, port=free_port())
    try:
        with api.sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
            page = browser.new_page(viewport={"width": 640, "height": 480})
            page.set_default_timeout(1000.0 * PATIENCE)
            page.goto(mirror.url)
            page.get_by_text("The robot stands").wait_for()
            driven(problem, publisher)
            page.get_by_text("The robot is being driven").wait_for()
            page.get_by_text("started").wait_for()
            browser.close()
    finally:
        mirror.close()
