from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import trajopt as to
from trajopt.values.errors import FileFormatError, ShapeError
from trajopt.values.trajectory import Trajectory
from trajopt.viewer import plot_motion
from trajopt.viewer.clearance import ClearanceKind, sample_motion
from trajopt.viewer.palette import LINES

from .conftest import Motion

UPRIGHT = to.axis_alignment("cup", tolerance=0.5)


def share_near(image: np.ndarray, colour: tuple[int, int, int]) -> float:
    """Share of the pixels that have nearly this colour."""
    away = np.abs(image[..., :3].astype(int) - colour).max(axis=-1)
    return float((away < 12).mean())


@pytest.mark.parametrize("constraints", [(), (UPRIGHT,)], ids=["accelerations", "tilt"])
def test_plot_shows_every_curve(
    motion: Motion, tmp_path: Path, constraints: tuple[to.problem.requirements.Requirement, ...]
) -> None:
    written = plot_motion(
        motion.reduced, motion.trajectory, tmp_path / "motion.png", constraints=constraints, title="a title"
    )
    image = np.asarray(Image.open(written))
    assert image.shape[0] > 1000
    assert image[..., :3].std() > 10.0
    for colour in LINES[:3]:
        assert share_near(image, colour) > 1e-4, "a joint's curve is missing"


def test_plots_of_different_motions_differ(motion: Motion, tmp_path: Path) -> None:
    still = np.repeat(motion.trajectory.positions[:1], 2, axis=0)
    standing = Trajectory(motion.trajectory.joint_names, np.array([0.0, 1.5]), still)
    moving = np.asarray(Image.open(plot_motion(motion.reduced, motion.trajectory, tmp_path / "a.png")))
    assert not np.array_equal(
        moving, np.asarray(Image.open(plot_motion(motion.reduced, standing, tmp_path / "b.png")))
    )


def test_format_follows_the_suffix(motion: Motion, tmp_path: Path) -> None:
    assert plot_motion(motion.reduced, motion.trajectory, tmp_path / "motion").name == "motion.png"
    vector = plot_motion(motion.reduced, motion.trajectory, tmp_path / "motion.svg")
    assert "<svg" in vector.read_text()
    with pytest.raises(FileFormatError, match=r"known: .*png"):
        plot_motion(motion.reduced, motion.trajectory, tmp_path / "motion.xlsx")


def test_a_motion_of_other_joints_is_refused(motion: Motion, tmp_path: Path) -> None:
    foreign = Trajectory(("elbow",), np.array([0.0, 1.0]), np.zeros((2, 1)))
    with pytest.raises(ShapeError, match="elbow"):
        plot_motion(motion.reduced, foreign, tmp_path / "motion.png")


def test_samples_are_shares_of_limits(motion: Motion) -> None:
    reduced, trajectory = motion
    samples = sample_motion(reduced, trajectory, reduced.limits, (UPRIGHT,))
    start, end = samples.position_shares[0], samples.position_shares[-1]
    assert start[0] == pytest.approx(0.12 / 0.15 - 1.0)
    assert end[1] == pytest.approx(0.35 / 3.0)
    assert samples.unlimited == ("wrist",)
    middle = int(np.searchsorted(samples.times, 0.7))
    np.testing.assert_allclose(
        samples.velocity_shares[middle] * reduced.limits.velocity, trajectory.velocities[1], atol=1e-12
    )
    # Only the wrist, about the arm's axis, tilts the cup.
    np.testing.assert_allclose(samples.tilts[0].angles, np.abs(trajectory(samples.times)[:, 2]), atol=1e-9)
    assert samples.tilts[0].bound == UPRIGHT.tolerance
    assert set(samples.clearances) == {ClearanceKind.SURROUNDINGS, ClearanceKind.CARRIED, ClearanceKind.SELF}
    assert samples.windows == ((0.0, 0.2, "cup on the table"),)
    assert samples.tightest is not None
    assert samples.tightest[1] == pytest.approx(min(c.min() for c in samples.clearances.values()), abs=1e-9)
