"""The page in a real browser: it draws, and its slider moves the robot."""

import time
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image

from trajopt.viewer import Viewer, view

from .conftest import Motion
from .test_viewer import expected_turn, free_port

if TYPE_CHECKING:
    from playwright.sync_api import Page

CHROMIUM = Path("/usr/bin/chromium")
FLAGS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-quic",
    "--no-first-run",
)
PATIENCE = 120.0
"""Longest wait for the page, which draws without a graphics card here [s]."""


@pytest.fixture(scope="module")
def viewer(motion: Motion) -> Iterator[Viewer]:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    opened = view(motion.reduced, motion.trajectory, port=free_port())
    yield opened
    opened.close()


@pytest.fixture(scope="module")
def page(viewer: Viewer) -> Iterator["Page"]:
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.is_file():
        pytest.skip(f"no browser at {CHROMIUM}")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        opened = browser.new_page(viewport={"width": 640, "height": 480})
        opened.set_default_timeout(1000.0 * PATIENCE)
        opened.goto(viewer.url)
        opened.get_by_text("Clearance").wait_for()
        yield opened
        browser.close()


def until(happened: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + PATIENCE
    while not happened():
        assert time.monotonic() < deadline, what
        time.sleep(0.1)


def canvas(page: "Page") -> np.ndarray:
    """Left part of the page, where nothing covers the scene."""
    return np.asarray(Image.open(BytesIO(page.screenshot())))[210:, :300, :3].astype(int)


def changed(before: np.ndarray, after: np.ndarray) -> float:
    """Share of the pixels that differ clearly."""
    return float((np.abs(after - before).max(axis=-1) > 30).mean())


def drawn(page: "Page") -> np.ndarray:
    """The scene when it shows the robot's blue carriage and stands still."""
    pictures = [canvas(page)]

    def settled() -> bool:
        pictures.append(canvas(page))
        blue = pictures[-1][..., 2] - pictures[-1][..., 0]
        return bool((blue > 40).sum() > 30 and np.abs(pictures[-1] - pictures[-2]).max() < 8)

    until(settled, "the robot was never drawn")
    return pictures[-1]


def test_page_draws_the_scene(page: "Page", viewer: Viewer) -> None:
    viewer.show(0.0)
    picture = drawn(page)
    assert picture.std() > 5.0
    assert len(np.unique(picture.reshape(-1, 3) // 16, axis=0)) > 20, "hardly any colours"


def test_slider_moves_the_robot(page: "Page", viewer: Viewer, motion: Motion) -> None:
    viewer.show(0.0)
    before = drawn(page)
    slider = page.get_by_role("slider").first
    slider.focus()
    page.keyboard.press("End")
    until(lambda: viewer.time == motion.trajectory.duration, "the slider's time never arrived")
    moved = viewer.joint_placement("turn").homogeneous
    np.testing.assert_allclose(moved, expected_turn(motion, viewer.time), atol=1e-6)
    until(lambda: changed(before, canvas(page)) > 0.005, "the picture stayed")
    page.keyboard.press("ArrowLeft")
    until(lambda: viewer.time == pytest.approx(1.49), "one step back never arrived")


def test_clearance_and_joints_are_read_out(page: "Page", viewer: Viewer) -> None:
    viewer.show(1.5)
    assert viewer.nearest is not None
    page.get_by_text(f"{viewer.nearest.distance * 1000:.1f} mm").wait_for()
    page.get_by_text("arm – post").or_(page.get_by_text("post – arm")).wait_for()
    page.get_by_text("20.1°").wait_for()


def test_button_plays(page: "Page", viewer: Viewer) -> None:
    viewer.show(0.0)
    page.get_by_role("button", name="Play").click()
    until(lambda: viewer.time > 0.0, "nothing played")
    until(lambda: viewer.time == 1.5, "the end was never reached")
