"""An attempt at timing a path: the trajectory of a profile, and how far it uses the limits."""

from dataclasses import dataclass, replace

import numpy as np

from tests.oracles.retiming.constraints import TorqueAlong, TorqueLimits
from tests.oracles.retiming.discretised_path import Bounds, DiscretisedPath, trajectory
from tests.oracles.retiming.peaks import (
    Peaks,
    Slowdown,
    binding,
    hold,
    motion_peaks,
    slowdown,
    slowed,
    with_torque,
)
from tests.oracles.retiming.profile import Profile
from tests.oracles.retiming.refusal import exceeded
from tests.oracles.retiming.smoothing import Smoothing
from trajopt.robot.joints import JointLimits
from trajopt.timing import ToolLimits
from trajopt.timing.retiming import Retimed, RetimeFailure, RetimeOptions
from trajopt.values.arrays import Bools
from trajopt.values.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Attempt:
    """A trajectory that holds some bounds at its points, and how far it uses the limits.

    Attributes:
        on: The path on the grid.
        bounds: The bounds that hold at the points.
        profile: The profile within them.
        trajectory: Its trajectory, perhaps a little slower.
        peaks: What was measured of the trajectory.
        slowdown: How much slower it must be run.
        coarse: Pieces that are known to be too long, shape (k - 1,).
        measured: Whether the torque was measured, if it has limits; it costs most, and is left out where
            the motion alone calls for another pass.
    """

    on: DiscretisedPath
    bounds: Bounds
    profile: Profile
    trajectory: Trajectory
    peaks: Peaks
    slowdown: Slowdown
    coarse: Bools
    measured: bool

    @property
    def merit(self) -> tuple[bool, bool, float]:
        """Pieces too long, torque unknown, and the duration when slowed down to hold all limits [s]."""
        duration = self.trajectory.duration * max(1.0, self.slowdown.factor)
        return bool(self.coarse.any()), not self.measured, duration


@dataclass(frozen=True, eq=False)
class Timer:
    """Times a path from rest to rest.

    Attributes:
        smoothing: The smooth path, of positive length.
        limits: Limits of its joints; those of the jerk may be infinite.
        torque: Torque limits, if there are any.
        along: The torque along the path, if there are torque limits.
        tools: Limited speeds of tools, if there are any.
        options: Number of points and of passes.
    """

    smoothing: Smoothing
    limits: JointLimits
    torque: TorqueLimits | None
    along: TorqueAlong | None
    tools: ToolLimits | None
    options: RetimeOptions

    def measure(self, on: DiscretisedPath, bounds: Bounds, profile: Profile, remainder: float) -> Attempt:
        """Make the trajectory of a profile and measure all but its torque.

        Args:
            on: The path on a grid.
            bounds: The bounds that hold at its points.
            profile: The profile within them.
            remainder: Where no more than this part of the duration is missing, it is added at once.
        """
        jerk = on.bounds.jerk is not None
        moved = trajectory(on, profile, self.limits.joint_names)
        moved = slowed(moved, max(1.0, self.options.shortest / moved.duration))
        peaks = motion_peaks(moved, self.tools, jerk=jerk)
        needed = slowdown(on, peaks)
        if 1.0 < needed.factor <= 1.0 + remainder:
            # Only a stretch is left to do: then the torque need not be measured before it and after.
            moved = slowed(moved, needed.factor * (1.0 + 1e-12))
            peaks = motion_peaks(moved, self.tools, jerk=jerk)
            needed = slowdown(on, peaks)
        none = np.zeros(len(needed.factors), dtype=np.bool_)
        return Attempt(on, bounds, profile, moved, peaks, needed, none, self.torque is None)

    def measure_torque(self, attempt: Attempt) -> Attempt:
        """Measure the torque of an attempt too, where it has not been."""
        if attempt.measured:
            return attempt
        peaks = with_torque(attempt.peaks, attempt.trajectory, self.torque)
        return replace(attempt, peaks=peaks, slowdown=slowdown(attempt.on, peaks), measured=True)

    def finish(self, best: Attempt, first_duration: float, passes: int) -> Retimed | RetimeFailure:
        """Slow the best attempt down until all limits hold.

        Args:
            best: The attempt.
            first_duration: Duration of the profile that holds the limits at the points only [s].
            passes: How many profiles were computed.
        """
        best = self.measure_torque(best)
        held = hold(best.on, best.trajectory, best.slowdown, torque=self.torque, tools=self.tools)
        if isinstance(held, Slowdown):
            return exceeded(best.on, held, self.limits, self.torque)
        decides = binding(best.on, best.peaks, measured=best.trajectory, final=held)
        added = held.duration - first_duration
        return Retimed(held, self.smoothing.deviation, added, passes, decides)
