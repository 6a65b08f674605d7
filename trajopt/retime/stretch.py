"""The last step: one uniform stretch of time, so that every limit holds truly."""

from trajopt.model.trajectory import Trajectory
from trajopt.retime.course import Course
from trajopt.retime.peaks import Slowdown, motion_peaks, slowdown, with_torque
from trajopt.retime.tool import ToolLimits
from trajopt.retime.torque import TorqueLimits

ROUNDS = 16
"""Most stretches; one is enough but for rounding errors and friction."""
ROUNDING = 1e-10
"""What a trajectory may still ask for; the limits that are given here are stricter by more."""


def hold(
    course: Course,
    trajectory: Trajectory,
    needed: Slowdown,
    *,
    torque: TorqueLimits | None,
    tools: ToolLimits | None,
) -> Trajectory | Slowdown:
    """Slow a trajectory down until it holds its limits, and measure that it does.

    Args:
        course: The path on the grid of the trajectory.
        trajectory: What to slow down.
        needed: By how much, as measured.
        torque: Torque limits, if there are any.
        tools: Limited speeds of tools, if there are any.

    Returns:
        The trajectory, or what it still exceeds: torque that does not decrease with the speed.
    """
    for attempt in range(ROUNDS):
        if needed.factor <= 1.0 + ROUNDING:
            return trajectory
        # Each next stretch goes a little beyond, more and more: it must not end in rounding errors.
        trajectory = slowed(trajectory, needed.factor * (1.0 + 1e-12 * 8.0**attempt))
        moved = motion_peaks(trajectory, tools, jerk=course.bounds.jerk is not None)
        needed = slowdown(course, with_torque(moved, trajectory, torque))
    return trajectory if needed.factor <= 1.0 + ROUNDING else needed


def slowed(trajectory: Trajectory, factor: float) -> Trajectory:
    """Run the same path slower: times multiplied by a factor."""
    assert trajectory.velocities is not None and trajectory.accelerations is not None
    return Trajectory(
        trajectory.joint_names,
        trajectory.times * factor,
        trajectory.positions,
        trajectory.velocities / factor,
        trajectory.accelerations / factor**2,
    )
