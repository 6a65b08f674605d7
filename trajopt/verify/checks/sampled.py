"""Constraints in user code: the same objects are called, and judged at samples only."""

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import Floats
from trajopt.values.errors import ShapeError, shown
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.kernel.intervals import sampled_times
from trajopt.verify.kernel.motion import Motion


@runtime_checkable
class SampledCheck(Protocol):
    """What a user's own constraint has to offer to be judged.

    Attributes:
        name: Its name in the certificate.
    """

    @property
    def name(self) -> str:
        """Its name in the certificate."""
        ...

    def evaluate(self, times: Floats, positions: Floats) -> tuple[ArrayLike, ArrayLike, ArrayLike]:
        """Evaluate the constraint along a motion.

        Args:
            times: Increasing times, shape (s,) [s].
            positions: Of the group's joints then, shape (s, n) [rad | m].

        Returns:
            Values, shape (s,) or (s, m), and their lower and upper bounds, which must broadcast
            to that shape.
        """
        ...


def sampled_check(check: SampledCheck, motion: Motion) -> Check:
    """Judge a user's constraint at samples.

    Raises:
        ShapeError: If it does not return numbers of a fitting shape.
    """
    times = sampled_times(motion)
    returned = check.evaluate(times, motion.trajectory(times))
    try:
        values, lower, upper = (np.asarray(part, dtype=np.float64) for part in returned)
        rows = values.reshape(len(times), -1)
        low, high = (np.broadcast_to(bound, values.shape).reshape(len(times), -1) for bound in (lower, upper))
    except (TypeError, ValueError) as error:
        raise ShapeError(f"values of {shown(check.name)}", f"do not fit {len(times)} samples") from error
    excess = np.maximum(rows - high, low - rows)
    excess = np.where(np.isnan(excess), np.inf, excess)
    row, column = np.unravel_index(int(excess.argmax()), excess.shape)
    above = rows[row, column] - high[row, column] >= low[row, column] - rows[row, column]
    bound = float((high if above else low)[row, column])
    worst = float(excess[row, column])
    return Check(
        kind=CheckKind.USER_CODE,
        name=f"path: {check.name}",
        subject=f"row {column}" if rows.shape[1] > 1 else "",
        value=float(rows[row, column]),
        bound=bound if np.isfinite(bound) else None,
        unit="",
        time=float(times[row]),
        slack=-worst if np.isfinite(worst) else None,
        evidence=Evidence.SAMPLED,
        holds=worst <= motion.options.excess,
        detail=f"user code, {len(times)} samples",
    )
