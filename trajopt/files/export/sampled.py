"""Samples of a motion, and the excess of a controller that interpolates them over the motion."""

from collections.abc import Iterator

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory

DERIVATIVES = ("positions", "velocities", "accelerations")
PARTS = tuple(np.linspace(0.0, 1.0 - 1e-9, 21).tolist())
"""Points between two samples for comparing derivatives, as fractions of the interval."""
NEGLIGIBLE = 0.01
"""Smallest peak of a joint, as a fraction of the largest peak of all joints; keeps nearly motionless joints
from
producing large ratios.
"""
LEAST = 1e-3
"""Smallest reported excess, as a fraction of the peak; the timing keeps an equal margin to the limits."""


def excess(motion: Trajectory, samples: Trajectory) -> Iterator[str]:
    """Yield a note for each derivative that is larger between the samples than in the motion.

    Args:
        motion: The motion.
        samples: The sampled motion, interpolated as the controller does.
    """
    for order in (1, 2):
        reached = _peaks(samples, samples.times, order)
        peak = np.maximum(_peaks(motion, samples.times, order), _peaks(motion, motion.times, order))
        parts = reached / np.maximum(peak, max(NEGLIGIBLE * peak.max(), np.finfo(np.float64).tiny)) - 1.0
        worst = int(parts.argmax())
        if parts[worst] > LEAST:
            yield (
                f"loses: between the samples, {DERIVATIVES[order]} of polynomials through them are up to "
                f"{parts[worst]:.1%} larger than in the motion ({motion.joint_names[worst]}); "
                "plan with lower scaling, or take more samples per second"
            )


def _peaks(motion: Trajectory, times: Floats, order: int) -> Floats:
    """Return the largest magnitude of a derivative of each joint at and between times, shape (n,)."""
    steps = np.diff(times)
    return np.max([np.abs(motion(times[:-1] + part * steps, order)).max(axis=0) for part in PARTS], axis=0)
