"""The positions of a group over time, planned or simulated, for pictures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from trajopt.scene.reduced import ReducedModel
from trajopt.simulation.execution import in_group_order
from trajopt.simulation.rollout import Rollout, SequenceLog
from trajopt.values.arrays import Floats, floats
from trajopt.values.errors import ShapeError
from trajopt.values.placement import Placement
from trajopt.values.trajectory import Trajectory

MOST_SAMPLES = 100_000
"""Most samples of a planned motion."""
MOST_PICTURES = 100_000


@dataclass(frozen=True, eq=False)
class SampledMotion:
    """Positions (k, n) of a group over k >= 2 times from 0, linear between samples.

    Attributes:
        placements: Loose object -> its placements in the world, k of them.
    """

    times: Floats
    positions: Floats
    placements: Mapping[str, tuple[Placement, ...]] = field(default_factory=dict[str, tuple[Placement, ...]])

    @property
    def duration(self) -> float:
        return float(self.times[-1])

    def loose_at(self, t: float) -> Mapping[str, Placement]:
        """Return the placements of the loose objects at the last sample before a time."""
        sample = max(int(np.searchsorted(self.times, t, side="right")) - 1, 0)
        return {name: each[sample] for name, each in self.placements.items()}

    def __call__(self, t: float) -> Floats:
        after = min(int(np.searchsorted(self.times, t, side="right")), len(self.times) - 1)
        before = after - 1
        share = (t - self.times[before]) / (self.times[after] - self.times[before])
        return self.positions[before] + float(np.clip(share, 0.0, 1.0)) * (
            self.positions[after] - self.positions[before]
        )


def held_start(reduced: ReducedModel) -> SampledMotion:
    return SampledMotion(np.array((0.0, 1.0)), np.stack((reduced.start_positions, reduced.start_positions)))


def motion_of(reduced: ReducedModel, motion: Rollout | Trajectory | SequenceLog) -> SampledMotion:
    """Return a planned or simulated motion of the group as positions over time."""
    if isinstance(motion, SequenceLog):
        columns = reduced.scene.robot.index(reduced.joint_names)
        return SampledMotion(motion.times, motion.positions[:, columns], motion.placements)
    if isinstance(motion, Rollout):
        if motion.joint_names != reduced.joint_names:
            in_group_order(reduced, motion.trajectory)  # raises
        if len(motion.times) == 1:  # it diverged in the first step
            return SampledMotion(np.array((0.0, 1e-3)), np.repeat(motion.positions, 2, axis=0))
        return SampledMotion(motion.times, motion.positions)
    trajectory = in_group_order(reduced, motion)
    step = max(0.01, trajectory.duration / MOST_SAMPLES)
    between = step * np.arange(int(trajectory.duration / step) + 1)
    times = np.array(sorted({*between.tolist(), *trajectory.times.tolist()}))
    return SampledMotion(times, trajectory(times))


def moments_of(motion: SampledMotion, moments: Sequence[float] | None) -> Floats:
    """Return the times to show [s]: the given ones, or start, end and two between."""
    end = motion.duration
    if moments is None:
        # Equal shares of the path, not of the time: motions are fastest in their middle.
        steps = np.linalg.norm(np.diff(motion.positions, axis=0), axis=1) + 1e-6 * np.diff(motion.times)
        length = np.append(0.0, np.cumsum(steps))
        places = np.searchsorted(length / length[-1], (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0))
        return motion.times[places]
    times = floats("moments", moments, (None,))
    if len(times) == 0 or (times < 0.0).any() or (times > end + 1e-9).any():
        raise ShapeError("moments", f"must be at least one time, each from 0 to {end:g} s")
    return times


def frame_times(motion: SampledMotion, fps: float) -> Floats:
    if motion.duration * fps > MOST_PICTURES:
        raise ShapeError(
            "fps", f"is {fps:g}, which over {motion.duration:g} s gives more than {MOST_PICTURES} pictures"
        )
    return np.array([k / fps for k in range(int(motion.duration * fps + 1.5))])
