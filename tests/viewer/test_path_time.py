"""The picture of path and time: what is in the way is on it, where and when it is."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import trajopt as to
from trajopt.planning import Plan, forbidden_times
from trajopt.values.errors import FileFormatError, ShapeError
from trajopt.viewer import plot_path_time
from trajopt.viewer.palette import LINES
from trajopt.viewer.plots import SHADE

START, GOAL = {"joint1": -1.1, "joint2": 0.3}, {"joint1": 0.9, "joint2": 0.4}


def swing(motion: to.Track | None = None) -> Plan:
    """Plan a swing of the planar arm, past a bar that passes if it has a motion."""
    scene = to.Scene(to.load("planar2"))
    if motion is not None:
        scene = scene.add("bar", to.Box(0.5, 0.02, 0.2), motion=motion)
    return to.plan(to.Problem(scene=scene, start=START, goal=to.joint_positions(GOAL))).require()


def shaded(path: Path) -> float:
    """Return the share of pixels that have the colour of the first thing."""
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB")).astype(float)
    colour = 255.0 * (1.0 - SHADE) + SHADE * np.array(LINES[0])
    return float((np.abs(pixels - colour).max(axis=2) < 2.0).mean())


def test_a_passing_obstacle_blocks_its_true_region(tmp_path: Path) -> None:
    turning = to.Track.constant_velocity(
        to.placement((0.75, 0.0, 0.12)), (0.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 1.2), end=60.0
    )
    plan = swing(turning)
    shares = [
        shaded(plot_path_time(plan, tmp_path / f"{end}.png", until=end))
        / float((forbidden_times(plan, until=end).blocked >= 0).mean())
        for end in (2.5, 5.0)
    ]
    # The axes have more than half of the picture, and the grid lies over some of a region.
    assert 0.5 < min(shares) and max(shares) < 0.9
    assert shares[0] == pytest.approx(shares[1], rel=0.1)


def test_without_anything_that_changes_there_is_the_motion_alone(tmp_path: Path) -> None:
    path = plot_path_time(swing(), tmp_path / "still.png")
    assert shaded(path) < 1e-3
    assert plot_path_time(swing(), tmp_path / "still.svg").read_text().startswith("<?xml")


def test_results_without_a_plan_are_not_drawn(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="is not an image format"):
        plot_path_time(swing(), tmp_path / "a.urdf")
    with pytest.raises(ShapeError, match="until"):
        plot_path_time(swing(), tmp_path / "a.png", until=0.0)
