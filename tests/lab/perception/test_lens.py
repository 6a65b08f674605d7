"""Lenses are undone exactly, and what no lens sees is told."""

import numpy as np
import pytest

from trajopt.lab.perception import Intrinsics, Lens
from trajopt.values.errors import ProblemError, ShapeError

KINECT = Lens(k1=0.2624, k2=-0.9531, p1=-0.0054, p2=0.0026, k3=1.1633)
RATIONAL = Lens(k1=0.5, k2=-2.6, p1=6e-4, p2=-1e-4, k3=1.5, k4=0.38, k5=-2.4, k6=1.43)


@pytest.mark.parametrize("lens", [KINECT, RATIONAL, Lens(k1=-0.3, k2=0.1), Lens(p1=0.01, p2=-0.02)])
def test_lens_distortion_is_removed(lens: Lens) -> None:
    straight = np.stack(np.meshgrid(np.linspace(-0.5, 0.5, 41), np.linspace(-0.4, 0.4, 31)), axis=-1)
    found = lens.straightened(lens.bent(straight))
    assert np.abs(found - straight).max() < 1e-8  # of a pixel less than a hundred thousandth


def test_a_straight_lens_changes_nothing() -> None:
    slopes = np.array(((0.1, -0.2), (0.5, 0.4)))
    assert Lens().straight and np.array_equal(Lens().straightened(slopes), slopes)


def test_pixels_in_folded_parts_of_the_image_have_no_ray() -> None:
    barrel = Lens(k1=-0.5)  # x (1 - x^2 / 2) turns back at 0.816, where it is 0.544
    found = barrel.straightened(np.array(((0.5, 0.0), (0.6, 0.0))))
    assert np.isfinite(found[0]).all() and np.isnan(found[1]).all()


def test_pixels_and_rays_are_inverse() -> None:
    bent = Intrinsics(640, 480, 525.0, 520.0, 310.0, 250.0, KINECT)
    across, down = bent.slopes
    assert across.shape == (480, 640)
    rows, columns = np.meshgrid(np.arange(0, 480, 37), np.arange(0, 640, 41), indexing="ij")
    rays = np.stack((across[rows, columns], down[rows, columns], np.ones(rows.shape)), axis=-1)
    pixels = bent.pixels_of(2.0 * rays.reshape(-1, 3).astype(np.float64))
    assert np.abs(pixels - np.stack((columns, rows), axis=-1).reshape(-1, 2)).max() < 1e-3


def test_slopes_move_apart_by_the_stretch_at_most() -> None:
    bent = Intrinsics(64, 48, 52.5, 52.5, 31.5, 23.5, Lens(k1=0.2))
    rng = np.random.default_rng(0)
    one = rng.uniform(-0.5, 0.5, (2000, 2))
    other = one + rng.normal(0.0, 1e-3, one.shape)
    apart = np.linalg.norm(bent.lens.bent(one) - bent.lens.bent(other), axis=1)
    assert (apart <= bent.stretch * np.linalg.norm(one - other, axis=1)).all()


def test_sizes_that_no_camera_has_are_refused() -> None:
    for wrong in ({"width": 0}, {"fx": 0.0}, {"fy": -1.0}):
        with pytest.raises(ProblemError, match=next(iter(wrong))):
            Intrinsics(**{"width": 64, "height": 48, "fx": 50.0, "fy": 50.0, "cx": 32.0, "cy": 24.0, **wrong})
    with pytest.raises(ShapeError, match="pixels"):
        Intrinsics(100_000, 100_000, 50.0, 50.0, 32.0, 24.0)
