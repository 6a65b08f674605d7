"""What the tests of retiming share: limits, paths, and measurements that are independent of it."""

import numpy as np
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from tests.oracles.retiming.smooth_path import SmoothPath
from tests.oracles.retiming.smoothing import Smoothing
from trajopt.native import timing
from trajopt.robot.joints import JointLimits
from trajopt.timing import DeviationBound, RetimeOptions
from trajopt.timing.retiming import timed
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Path, Trajectory


def make_limits(
    count: int,
    *,
    velocity: ArrayLike = 2.0,
    acceleration: ArrayLike = 8.0,
    effort: ArrayLike = np.inf,
    position: float = np.inf,
) -> JointLimits:
    def each(value: ArrayLike) -> Floats:
        return np.array(np.broadcast_to(np.asarray(value, dtype=float), (count,)))

    names = tuple(f"joint{i}" for i in range(count))
    return JointLimits(
        names,
        each(-position),
        each(position),
        each(velocity),
        each(acceleration),
        each(np.inf),
        each(effort),
    )


def make_path(knots: ArrayLike) -> Path:
    array = np.asarray(knots, dtype=float)
    return Path(tuple(f"joint{i}" for i in range(array.shape[1])), array)


def core_timed(
    path: Path, limits: JointLimits, tolerance: float = 5e-3, deviation: DeviationBound | None = None
) -> timing.Retimed:
    """What the core makes of a path, without torques and tools."""
    return timed(
        path,
        limits,
        inverse_dynamics=None,
        tools=None,
        deviation=deviation,
        options=RetimeOptions(path_tolerance=tolerance),
    )


def smoothing(
    path: Path, limits: JointLimits, tolerance: float = 5e-3, deviation: DeviationBound | None = None
) -> Smoothing:
    """The smooth path that `retime` uses, evaluated by SciPy, and its deviation."""
    found = core_timed(path, limits, tolerance, deviation)
    curve = SmoothPath(path.knots[0], path.knots[-1], found.knots, found.control)
    return Smoothing(curve, found.deviation)


def smooth_path(path: Path, limits: JointLimits, tolerance: float = 5e-3) -> SmoothPath:
    """The smooth path that `retime` uses without a deviation bound, evaluated by SciPy."""
    return smoothing(path, limits, tolerance).path


def moments(trajectory: Trajectory, each: int = 20) -> Floats:
    """The points of a trajectory and `each` times within every piece."""
    times = trajectory.times
    parts = np.arange(each) / each
    inner = (times[:-1, None] + np.diff(times)[:, None] * parts).ravel()
    return np.append(inner, times[-1])


def largest_use(trajectory: Trajectory, limits: JointLimits) -> Floats:
    """Used part of the velocity and acceleration limits at dense moments, the larger of both."""
    t = moments(trajectory)
    speed = np.abs(trajectory(t, 1)) / limits.velocity
    return np.maximum(speed, np.abs(trajectory(t, 2)) / limits.acceleration).max(axis=1)


def distance_from(trajectory: Trajectory, path: SmoothPath, s: Floats) -> float:
    """Largest distance, in any joint, of each piece of a trajectory from its part of the curve."""
    q = trajectory(moments(trajectory, 5)[:-1])
    low, high = np.repeat(s[:-1], 5), np.repeat(s[1:], 5)
    best = np.full(len(q), np.inf)
    for _ in range(9):  # ever finer about the nearest parameter
        near = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, 13)
        away = np.abs(path(near.ravel()).reshape(*near.shape, -1) - q[:, None]).max(axis=2)
        nearest = away.argmin(axis=1)
        best = np.minimum(best, away.min(axis=1))
        rows = np.arange(len(q))
        low, high = near[rows, np.maximum(nearest - 2, 0)], near[rows, np.minimum(nearest + 2, 12)]
    return float(best.max())


@st.composite
def polylines(draw: st.DrawFn) -> tuple[Path, JointLimits]:
    """Random polylines of 1 to 7 joints: repeated knots, joints that stand still, reversals."""
    joints, count = draw(st.integers(1, 7)), draw(st.integers(2, 8))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    knots = rng.uniform(-1.5, 1.5, (count, joints))
    match draw(st.sampled_from(("random", "lattice", "repeated", "still", "walk"))):
        case "lattice":
            knots = np.round(knots)
        case "repeated":
            knots = knots[np.sort(rng.integers(0, count, count))]
        case "still":
            knots[:, rng.random(joints) < 0.5] = 0.3
        case "walk":
            knots = np.cumsum(knots * 10.0 ** rng.uniform(-4.0, 0.0, (count, 1)), axis=0)
        case _:
            pass
    limits = make_limits(
        joints,
        velocity=10.0 ** rng.uniform(-0.5, 0.7, joints),
        acceleration=10.0 ** rng.uniform(0.0, 1.5, joints),
    )
    return make_path(knots), limits
