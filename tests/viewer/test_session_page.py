"""The page of `trajopt serve`: a session's robot and scene in 3-D, planned for in a real browser."""

import json
import sys
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from http import HTTPStatus
from threading import Thread
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import httpx
import numpy as np
import pytest

import trajopt as to
from tests.server.serving import PATIENT, SMALL, Serving, serving
from tests.viewer.test_page import CHROMIUM, FLAGS, PATIENCE, until
from trajopt.server.client import Client, Session
from trajopt.server.operation import SessionState, Watch
from trajopt.values.documents.document import Node
from trajopt.viewer import LiveView, live_view

from .conftest import Motion
from .test_viewer import free_port

if TYPE_CHECKING:
    from playwright.sync_api import FrameLocator, Page

MODULES = ("trajopt.server.operations", "trajopt.viewer.live.page")
POST: dict[str, Any] = {
    "add": {
        "name": "post",
        "shape": {"cylinder": {"radius": 0.04, "length": 0.8}},
        "placement": {"xyz": [0.3, 0.3, 0.4]},
    }
}
EVENTS = {"Accept": "text/event-stream"}


@pytest.fixture(scope="module")
def server(motion: Motion) -> Iterator[Serving]:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    with serving(motion.reduced.scene.robot, limits=replace(SMALL, views=2), modules=MODULES) as up:
        yield up


@pytest.fixture
def session(server: Serving) -> Iterator[Session]:
    with Client(server.url) as client:
        yield client.session("tiny")


@contextmanager
def opened(server: Serving, session: str) -> Generator[dict[str, Any]]:
    """Open a session's page as its own web page does: it is open while the answer is read."""
    url = f"{server.url}/sessions/{session}/view"
    with httpx.stream("POST", url, json={}, headers=EVENTS, timeout=PATIENCE) as answer:
        data = (line.removeprefix("data: ") for line in answer.iter_lines() if line.startswith("data: "))
        yield json.loads(next(data))


def status(url: str, **headers: str) -> int:
    return httpx.get(url, headers=headers).status_code


def test_the_page_requires_its_secret_origin_and_host(server: Serving, session: Session) -> None:
    with opened(server, session.id) as found:
        assert server.port < found["port"] <= server.port + 2 and found["group"] == "all"
        at = f"http://127.0.0.1:{found['port']}"
        assert len(found["path"]) > 20 and status(at + found["path"]) == HTTPStatus.OK
        assert status(at) == HTTPStatus.FORBIDDEN
        assert status(at + found["path"], Origin="http://evil.example") == HTTPStatus.FORBIDDEN
        assert status(at + found["path"], Host="evil.example") == HTTPStatus.MISDIRECTED_REQUEST


def test_it_ends_with_its_request(server: Serving, session: Session) -> None:
    with opened(server, session.id) as found:
        with opened(server, session.id) as again:
            assert again["error"]["kind"] == "busy" and "3-D page is open" in again["error"]["reason"]
        at = f"http://127.0.0.1:{found['port']}{found['path']}"

    def gone() -> bool:
        try:
            return status(at) != HTTPStatus.OK
        except httpx.TransportError:
            return True

    until(gone, "the page stayed open")
    state = f"{server.url}/sessions/{session.id}/state"
    until(lambda: not httpx.get(state).json()["driven"], "the page still has the robot")


def test_the_number_of_pages_is_limited(server: Serving) -> None:
    with Client(server.url) as client:
        one, two, three = (client.session("tiny").id for _ in range(3))
        with opened(server, one) as first, opened(server, two) as second, opened(server, three) as refused:
            assert first["port"] != second["port"]
            assert refused["error"]["kind"] == "full" and "close one" in refused["error"]["reason"]


def test_clients_do_not_choose_where_it_listens(server: Serving, session: Session) -> None:
    at = f"{server.url}/sessions/{session.id}"
    anywhere = {"host": "0.0.0.0", "first_port": 1024, "last_port": 65535}
    assert httpx.post(f"{at}/view", json=anywhere).status_code == HTTPStatus.BAD_REQUEST
    assert httpx.post(f"{at}/viewer/page", json=anywhere).status_code == HTTPStatus.NOT_FOUND


def test_the_policy_frames_these_ports_of_this_host_only(server: Serving) -> None:
    def frames(host: str) -> str:
        policy = httpx.get(server.url, headers={"Host": host}).headers["content-security-policy"]
        assert policy.startswith("default-src 'self'; img-src data:; frame-ancestors 'none'; frame-src ")
        return policy.rpartition("frame-src ")[2]

    ports = (server.port + 1, server.port + 2)
    assert frames(f"localhost:{server.port}") == " ".join(f"http://localhost:{port}" for port in ports)
    assert frames(f"[::1]:{server.port}") == "'none'"
    with serving(options=replace(PATIENT, token="a token of the tests")) as guarded:
        for host in ("evil.example; script-src *", "evil.example *"):
            answer = httpx.get(guarded.url, headers={"Host": host})
            assert "evil" not in answer.headers["content-security-policy"]
        assert httpx.post(f"{guarded.url}/sessions/x/view", json={}).status_code == HTTPStatus.UNAUTHORIZED


def test_without_the_extra_the_reason_names_the_package(
    motion: Motion, monkeypatch: pytest.MonkeyPatch
) -> None:
    from trajopt.viewer.live.page import page

    monkeypatch.setitem(sys.modules, "viser", None)
    scene = to.Scene(motion.reduced.scene.robot)
    state = SessionState("tiny", scene, motion.reduced.start)
    where = Node({"host": "127.0.0.1", "first_port": 8081, "last_port": 8084}, "request")
    with pytest.raises(to.MissingExtra, match=r'pip install "trajopt-planner\[view\]"'):
        page(state, where, Watch(1.0))


def test_the_session_receives_the_robots_positions_from_the_page(motion: Motion) -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    from trajopt.viewer.live.page import page

    told = list[tuple[Mapping[str, object], list[float] | None]]()
    watch = Watch(PATIENCE, lambda document, positions: told.append((document, positions)))
    opened = list[LiveView]()

    def open_one(*args: Any, **options: Any) -> LiveView:
        opened.append(live_view(*args, **options))
        return opened[0]

    scene = to.Scene(motion.reduced.scene.robot)
    state = SessionState("tiny", scene, motion.reduced.start)
    port = free_port()
    where = Node({"host": "127.0.0.1", "first_port": port, "last_port": port + 9}, "request")
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("trajopt.viewer.live.page.live_view", open_one)
        serving = Thread(target=page, args=(state, where, watch))
        serving.start()
        until(lambda: len(told) == 1, "the page never opened")
    opened[0]._bench.stand(np.array((0.2, 0.5, 0.0)))  # pyright: ignore[reportPrivateUsage]
    until(lambda: len(told) == 2, "the session was not told")
    assert told[1][1] == pytest.approx([0.2, 0.5, 0.0])
    watch.cancel.set()
    serving.join(PATIENCE)
    assert opened[0].done


@pytest.fixture(scope="module")
def browser_page() -> Iterator["Page"]:
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.is_file():
        pytest.skip(f"no browser at {CHROMIUM}")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        page = browser.new_page(viewport={"width": 800, "height": 600})
        page.set_default_timeout(1000.0 * PATIENCE)
        yield page
        browser.close()


def ask_for(frame: "FrameLocator", turn: int) -> None:
    """Have the last but one joint of the goal stand at an angle [degrees], and press Plan."""
    field = frame.locator("input[inputmode=decimal]:visible").nth(-2)
    field.fill(str(turn))
    field.press("Enter")
    frame.get_by_text("Press Plan to find a motion there").wait_for()
    frame.get_by_role("button", name="Plan", exact=True).click()


def test_in_a_browser_a_goal_is_planned_for(server: Serving, session: Session, browser_page: "Page") -> None:
    session.edit([POST])
    browser_page.goto(f"{server.url}/#{session.id}")
    frame = browser_page.frame_locator("#view")
    frame.get_by_text("The goal is the present configuration").wait_for()
    ask_for(frame, -45)
    frame.get_by_text("Free of collisions").wait_for()
    ask_for(frame, 90)
    frame.get_by_text("No motion was found").wait_for()
    assert frame.get_by_text("post").count(), "the reason names the obstacle"
    session.edit([{"remove": {"name": "post"}}])
    frame.get_by_text("Press Plan to find a motion there").wait_for()
    frame.get_by_role("button", name="Plan", exact=True).click()
    frame.get_by_text("All joints keep their limits").wait_for()


def test_a_page_that_cannot_open_shows_the_reason_in_a_browser(browser_page: "Page") -> None:
    with serving() as bare:
        browser_page.goto(bare.url)
        browser_page.get_by_text("no operation 'viewer/page'").wait_for()
        assert browser_page.get_by_role("button", name="Open again").is_visible()
        assert not browser_page.locator("#view").is_visible()
        assert urlsplit(browser_page.url).path == "/"
