"""Lenses: how a real camera bends the pinhole's rays, and the rays that its pixels really see along."""

from dataclasses import dataclass

import numpy as np

from trajopt.values.arrays import Floats, Value, number
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import checked

STEPS = 50
"""Newton steps at most to undo a lens; those in use need five."""
EXACT = 1e-10
"""A ray is found when the lens bends it to within this of its pixel, in units of the focal length: less than
a millionth of a pixel."""


@checked
@dataclass(frozen=True)
class Lens(Value):
    """Brown's lens, as OpenCV and ROS have it: "plumb_bob" has five numbers, "rational_polynomial" eight.

    With x, y the slopes of a ray and r2 = x^2 + y^2, the slopes that the lens makes of them are
    x s + 2 p1 x y + p2 (r2 + 2 x^2) and y s + p1 (r2 + 2 y^2) + 2 p2 x y, where
    s = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3).

    Attributes:
        k1: Radial, of the second power.
        k2: Radial, of the fourth.
        p1: Tangential, of a lens tilted up or down.
        p2: Tangential, of a lens tilted sideways.
        k3: Radial, of the sixth power.
        k4: Radial, of the second power, below the line.
        k5: Radial, of the fourth, below the line.
        k6: Radial, of the sixth, below the line.
    """

    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0
    k4: float = 0.0
    k5: float = 0.0
    k6: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"):
            object.__setattr__(self, name, number(f"Lens.{name}", getattr(self, name)))

    @property
    def straight(self) -> bool:
        """Whether it bends nothing."""
        radial, tangential = (self.k1, self.k2, self.k3, self.k4, self.k5, self.k6), (self.p1, self.p2)
        return not any((*radial, *tangential))

    def bent(self, slopes: Floats) -> Floats:
        """Return the slopes (..., 2) that the lens makes of those of rays."""
        return self._bent_with_slope(slopes)[0]

    def straightened(self, slopes: Floats) -> Floats:
        """Return the slopes (..., 2) of the rays that the lens bends to these; nan where it sees none.

        Raises:
            ShapeError: If they are not pairs.
        """
        if slopes.shape[-1:] != (2,):
            raise ShapeError("slopes", f"needs pairs, has shape {slopes.shape}")
        if self.straight:
            return slopes
        found = np.array(slopes)
        with np.errstate(all="ignore"):
            for _ in range(STEPS):
                value, jacobian = self._bent_with_slope(found)
                off = value - slopes
                if not (np.abs(off) > EXACT).any():
                    break
                a, b, c, d = (
                    jacobian[..., 0, 0],
                    jacobian[..., 0, 1],
                    jacobian[..., 1, 0],
                    jacobian[..., 1, 1],
                )
                step = np.stack(
                    (d * off[..., 0] - b * off[..., 1], a * off[..., 1] - c * off[..., 0]), axis=-1
                )
                found = found - step / (a * d - b * c)[..., None]
            value, jacobian = self._bent_with_slope(found)
            # Beyond its turning point the polynomial folds the picture over, or turns it around.
            folded = np.linalg.det(np.nan_to_num(jacobian)) <= 0.0
            turned = np.einsum("...i,...i", found, slopes) < 0.0
            wrong = ~(np.abs(value - slopes) <= 100.0 * EXACT).all(axis=-1) | folded | turned
        found[wrong] = np.nan
        return found

    def stretch(self, slopes: Floats) -> float:
        """Return by how much it moves neighbouring slopes apart at most, at any of those (..., 2) it sees."""
        seen = slopes[np.isfinite(slopes).all(axis=-1)]
        return float(np.linalg.norm(self._bent_with_slope(seen)[1], ord=2, axis=(-2, -1)).max())

    def _bent_with_slope(self, slopes: Floats) -> tuple[Floats, Floats]:
        """Return the bent slopes (..., 2) and their derivative (..., 2, 2)."""
        x, y = slopes[..., 0], slopes[..., 1]
        r2 = x * x + y * y
        above = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
        below = 1.0 + r2 * (self.k4 + r2 * (self.k5 + r2 * self.k6))
        above_rate = self.k1 + r2 * (2.0 * self.k2 + 3.0 * self.k3 * r2)
        below_rate = self.k4 + r2 * (2.0 * self.k5 + 3.0 * self.k6 * r2)
        scale = above / below
        rate = 2.0 * (above_rate - scale * below_rate) / below
        p1, p2 = self.p1, self.p2
        value = np.stack(
            (
                x * scale + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                y * scale + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
            ),
            axis=-1,
        )
        cross = rate * x * y + 2.0 * p1 * x + 2.0 * p2 * y
        along_x = scale + rate * x * x + 2.0 * p1 * y + 6.0 * p2 * x
        along_y = scale + rate * y * y + 6.0 * p1 * y + 2.0 * p2 * x
        jacobian = np.stack(
            (np.stack((along_x, cross), axis=-1), np.stack((cross, along_y), axis=-1)), axis=-2
        )
        return value, jacobian


STRAIGHT = Lens()
"""A lens that bends nothing."""
