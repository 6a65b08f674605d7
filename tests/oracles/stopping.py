"""Twin of `stopping.hpp`: the soonest stop of a motion along its own path, by the formulas in its header."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.limits import JointLimits
from trajopt.model.trajectory import Trajectory

STILL = 1e-9


def brake(
    motion: Trajectory,
    limits: JointLimits,
    begin: float,
    *,
    ramp: float,
    share: float,
    kept: float,
    step: float,
) -> tuple[Floats, float]:
    """Return clock, rate and slope after each step, (3, c), and how long the last step is."""
    clock, rate, slope = begin, 1.0, 0.0
    rows = [(clock, rate, slope)]
    while clock < motion.duration:
        if slope < 0.0 and -2.0 * rate / slope <= 2.0 * step:
            return np.array(rows).T, -2.0 * rate / slope
        ahead = rate + step * slope
        end = min(clock + step * (rate + step * slope / 2.0), motion.duration)
        down, up = [], []
        for at, r, since in ((clock, rate, 0.0), (end, ahead, step)):
            first, second, third = (motion(at, order) for order in (1, 2, 3))
            side, speed = np.where(first < 0.0, -1.0, 1.0), np.maximum(np.abs(first), STILL)
            others = side * (r**3 * third + 3.0 * r * slope * second)
            turning = np.maximum(speed + 3.0 * since * r * side * second, STILL)
            most = limits.acceleration / ramp
            down.append((np.maximum(-kept * limits.jerk - others, -most) / turning).max())
            up.append((np.minimum(kept * limits.jerk - others, most) / turning).min())
        hardest = ((-share * limits.acceleration - ahead**2 * second * side) / speed).max()
        away = (share * np.minimum(limits.jerk, most) / speed).min()
        left, bend = rate + step * slope / 2.0, step * away
        soft = (bend - np.sqrt(bend**2 + 8.0 * away * max(left, 0.0))) / 2.0
        then = min(max(hardest, slope + step * max(down), soft), 0.0)
        slower = rate + step * (slope + then) / 2.0
        if slower <= 0.0 or then > slope + step * max(min(up), *down) + STILL:
            break
        clock += step * (rate + step * (2.0 * slope + then) / 6.0)
        rate, slope = slower, then
        rows.append((clock, rate, slope))
    return np.array(rows).T, np.inf
