"""Reports in a real browser, opened from the disk: they draw, scrub and print, and fetch nothing."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image

import trajopt as to
from tests.viewer.test_page import CHROMIUM, FLAGS, PATIENCE
from trajopt.files.bundle import read_bundle
from trajopt.viewer.report import write_report
from trajopt.viewer.report.page import recorded

if TYPE_CHECKING:
    from playwright.sync_api import Browser, ConsoleMessage, Frame, Page, Request

pytestmark = pytest.mark.timeout(600)


@dataclass
class Opened:
    """A page, what it asked for, and what went wrong in it."""

    page: "Page"
    path: Path
    requests: list[str] = field(default_factory=list[str])
    errors: list[str] = field(default_factory=list[str])

    def ask(self, request: "Request") -> None:
        self.requests.append(request.url)

    def hear(self, message: "ConsoleMessage") -> None:
        if message.type == "error":
            self.errors.append(message.text)

    @property
    def space(self) -> "Frame":
        """The frame with the motion in 3-D."""
        return self.page.frames[1]

    def picture(self) -> np.ndarray:
        """The right part of the scene, which no message of the viewer covers."""
        box = self.page.locator("iframe").bounding_box()
        assert box is not None
        shot = Image.open(BytesIO(self.page.screenshot(full_page=True))).convert("RGB")
        left, top = box["x"], box["y"] + self.page.evaluate("scrollY")
        crop = (left + 0.32 * box["width"], top + 4, left + box["width"] - 60, top + 0.8 * box["height"])
        return np.asarray(shot.crop(crop)).astype(int)

    def settled(self) -> np.ndarray:
        """The scene when it stands still and shows something."""
        self.page.locator(".space:not(.waiting)").wait_for()
        pictures = [self.picture()]

        def still() -> bool:
            pictures.append(self.picture())
            return bool(pictures[-1].std() > 8.0 and np.abs(pictures[-1] - pictures[-2]).max() < 8)

        until(still, "the scene was never drawn")
        return pictures[-1]

    def cursor(self) -> str:
        """Where the line of the first plot is."""
        return str(self.page.locator("svg.plot .cursor").first.get_attribute("transform"))


def until(happened: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + PATIENCE
    while not happened():
        assert time.monotonic() < deadline, what
        time.sleep(0.2)


@pytest.fixture(scope="module")
def browser() -> Iterator["Browser"]:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.is_file():
        pytest.skip(f"no browser at {CHROMIUM}")
    with api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield started
        started.close()


@pytest.fixture
def opened(browser: "Browser", tmp_path: Path) -> Iterator[Callable[..., Opened]]:
    pages: list[Page] = []

    def write_and_open(what: to.Result | to.Problem, *, bundled: bool = False) -> Opened:
        if bundled:
            what.save(tmp_path / "kept.trajopt")
            path = write_report(read_bundle(tmp_path / "kept.trajopt"), tmp_path / "report.html")
        else:
            path = write_report(what, tmp_path / "report.html")
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        pages.append(page)
        made = Opened(page, path)
        page.on("request", made.ask)
        page.on("console", made.hear)
        page.on("pageerror", lambda error: made.errors.append(str(error)))
        page.set_default_timeout(1000.0 * PATIENCE)
        page.goto(path.as_uri())
        made.space.locator("canvas").first.wait_for()
        return made

    yield write_and_open
    for page in pages:
        page.close()


def within_itself(made: Opened) -> None:
    """It asked for itself alone, nothing went wrong, and no name in it did anything."""
    outside = [url for url in made.requests if not url.startswith(("data:", "blob:", "about:"))]
    assert outside == [made.path.as_uri()]
    assert made.errors == []
    assert made.page.evaluate("window.hacked") is None and made.space.evaluate("window.hacked") is None


def test_a_plan_is_scrubbed(plan: to.Result, opened: Callable[..., Opened]) -> None:
    """From the page and from the frame, and both show the same moment; from a bundle with hostile names."""
    made = opened(plan, bundled=True)
    page, space = made.page, made.space
    slider = space.locator('[role="slider"]').first
    slider.wait_for(state="attached")
    until(lambda: slider.get_attribute("aria-valuenow") == "0", "it never stood at the beginning")
    start = made.settled()
    assert plan.trajectory is not None
    page.locator("button.at").last.click()
    page.locator("svg.plot").first.click(position={"x": 700, "y": 12})
    page.locator("iframe").scroll_into_view_if_needed()
    until(lambda: float(slider.get_attribute("aria-valuenow") or 0.0) > 0.3, "the frame never followed")
    moved = made.settled()
    assert (np.abs(moved - start).max(axis=-1) > 30).mean() > 0.01, "the robot stood still"
    before = made.cursor()
    bar = space.locator('[role="slider"]').first.locator("xpath=../..")
    box = bar.bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.1 * box["width"], box["y"] + box["height"] / 2)
    until(lambda: made.cursor() != before, "the plots never followed")
    until(lambda: bool(page.locator(".legend b").first.text_content()), "no value was read out")
    within_itself(made)


def test_a_small_window_shows_its_top_first(plan: to.Result, opened: Callable[..., Opened]) -> None:
    made = opened(plan)
    made.page.set_viewport_size({"width": 900, "height": 450})
    made.page.reload()
    made.page.locator(".space:not(.waiting)").wait_for()
    slider = made.space.locator('[role="slider"]').first
    until(lambda: slider.get_attribute("aria-valuenow") == "0", "it never stood at the beginning")
    assert made.page.evaluate("scrollY") == 0


def test_still_picture_is_shown_until_the_motion_is_drawn(
    plan: to.Result, browser: "Browser", tmp_path: Path
) -> None:
    path = write_report(plan, tmp_path / "report.html")
    page = browser.new_page()
    page.set_default_timeout(1000.0 * PATIENCE)
    # Messages of the frame are withheld: the page stays as it is before the frame has drawn.
    page.add_init_script(
        "addEventListener('message', (event) => window.late || event.stopImmediatePropagation())"
    )
    page.goto(path.as_uri())
    poster = page.locator(".poster")
    assert poster.is_visible() and poster.evaluate("image => image.naturalWidth") > 300
    page.evaluate("window.late = true; document.querySelector('iframe').srcdoc += ''")
    poster.wait_for(state="hidden")
    assert page.locator("iframe").is_visible()
    page.close()


@pytest.mark.parametrize("scripts", [True, False], ids=["without WebGL", "without scripts"])
def test_still_pictures_replace_the_motion(
    plan: to.Result, browser: "Browser", tmp_path: Path, scripts: bool
) -> None:
    path = write_report(plan, tmp_path / "report.html")
    context = browser.new_context(java_script_enabled=scripts)
    context.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page = context.new_page()
    page.set_default_timeout(1000.0 * PATIENCE)
    page.goto(path.as_uri())
    pictures = page.locator(".stills img")
    pictures.first.wait_for()
    assert pictures.count() == 4 and all(image.is_visible() for image in pictures.all())
    assert not page.locator(".space").is_visible()
    context.close()


def test_dynamic_obstacles_move_during_playback(planar: to.Scene, browser: "Browser", tmp_path: Path) -> None:
    """A ball passes a robot that stands still: what changes is the ball."""
    track = to.Track.constant_velocity(to.placement((0.9, 0.9, 0.1)), (-0.9, 0.0, 0.0), end=2.0)
    scene = planar.add("passing", to.Sphere(0.15), motion=track)
    reduced = to.Problem(scene=scene, start=[0.0, 0.4], goal={"joint1": 0.1, "joint2": 0.4}).reduced
    still = to.Trajectory(reduced.joint_names, np.array([0.0, 1.5]), np.array([[0.0, 0.4], [0.0, 0.4]]))
    (tmp_path / "space.html").write_text(recorded(reduced, still), encoding="utf-8")
    page = browser.new_page(viewport={"width": 640, "height": 480})
    page.set_default_timeout(1000.0 * PATIENCE)
    page.goto((tmp_path / "space.html").as_uri())
    slider = page.locator('[role="slider"]').first
    slider.wait_for(state="attached")

    def seen_at(time: float) -> np.ndarray:
        page.evaluate(f"postMessage({{ show: {time} }}, '*')")
        until(
            lambda: abs(float(slider.get_attribute("aria-valuenow") or -1.0) - time) < 1e-3,
            f"never at {time} s",
        )
        shots = [np.zeros(1)]

        def still_there() -> bool:
            shot = Image.open(BytesIO(page.screenshot())).convert("RGB").crop((280, 0, 600, 400))
            shots.append(np.asarray(shot).astype(int))
            return bool(
                shots[-1].std() > 8.0
                and shots[-1].shape == shots[-2].shape
                and np.abs(shots[-1] - shots[-2]).max() < 8
            )

        until(still_there, "the scene was never drawn")
        return shots[-1]

    begin, end = seen_at(0.0), seen_at(1.5)
    assert (np.abs(end - begin).max(axis=-1) > 30).mean() > 0.005, "the ball stood still"
    page.close()


def test_a_failure_shows_the_obstacle(failure: to.Result, opened: Callable[..., Opened]) -> None:
    made = opened(failure)
    picture = made.settled()
    red = (picture[..., 0] - picture[..., 1] > 40) & (picture[..., 0] - picture[..., 2] > 20)
    assert red.sum() > 100, "where it is not free is drawn in red"
    assert made.page.get_by_text("What stands in the way").is_visible()
    within_itself(made)


def test_a_problem_alone_is_drawn(failure: to.Result, opened: Callable[..., Opened]) -> None:
    made = opened(failure.problem)
    made.settled()
    within_itself(made)


@pytest.mark.parametrize("width", [420, 1280])
def test_it_fits_the_window(plan: to.Result, opened: Callable[..., Opened], width: int) -> None:
    made = opened(plan)
    made.page.set_viewport_size({"width": width, "height": 800})
    assert made.page.evaluate("document.documentElement.scrollWidth") <= width


def test_on_paper_there_are_pictures_and_nothing_to_turn(
    plan: to.Result, opened: Callable[..., Opened]
) -> None:
    made = opened(plan)
    page = made.page
    assert page.locator("iframe").is_visible() and not page.locator(".stills img").first.is_visible()
    page.emulate_media(media="print")
    assert not page.locator("iframe").is_visible()
    assert page.locator(".stills img").count() == 4
    assert all(image.is_visible() for image in page.locator(".stills img").all())
    paper = page.pdf(prefer_css_page_size=True)
    assert paper.startswith(b"%PDF") and 2 <= paper.count(b"/Type /Page\n") <= 8
