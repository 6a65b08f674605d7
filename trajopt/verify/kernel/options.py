"""Options of the judge."""

from dataclasses import dataclass

from trajopt.robot.joints import EXCESS
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked


@checked
@dataclass(frozen=True, kw_only=True)
class VerifyOptions:
    """Options of the judge.

    Attributes:
        resolution: Largest difference between measured and proven clearance, or a quarter of the measured
            clearance if that is larger [m].
        far: Clearance beyond which distances are not refined [m].
        smallest_interval: Length of an unproven interval at which the search ends [s].
        first_intervals: Most initial intervals if only the verdict is needed; unproven ones are halved.
        first_interval: Least length of these, unless there are only two [s].
        most_distances: Measured distances at which the search for a proof ends.
        distance_error: Reserve subtracted from measured distances for errors of exact meshes [m].
        excess: Accepted numerical excess: relative to velocity and acceleration limits, absolute for
            positions and requirements [rad | m].
        start_error: Accepted difference from the start state [rad | m].
        rest_speed: Joint speed that counts as rest [rad/s | m/s].
        start_acceleration_error: Accepted difference from a start acceleration [rad/s^2 | m/s^2].
        meeting_speed: Accepted velocity relative to a moving goal [m/s].
        meeting_rate: Accepted angular velocity relative to a moving goal [rad/s].
        sample_step: Longest time between samples of quantities without a proof, such as torques [s].
        sample_travel: Joint travel between samples of slow motions, with at least eight samples per piece
            [rad | m].
    """

    resolution: float = 1e-3
    far: float = 0.05
    smallest_interval: float = 1e-5
    first_intervals: int = 16
    first_interval: float = 1e-5
    most_distances: int = 1_000_000
    distance_error: float = 1e-6
    excess: float = EXCESS
    start_error: float = 1e-6
    rest_speed: float = 1e-6
    start_acceleration_error: float = 1e-6
    meeting_speed: float = 1e-3
    meeting_rate: float = 1e-2
    sample_step: float = 0.01
    sample_travel: float = 1e-3

    def __post_init__(self) -> None:
        """Raise a ProblemError if a number is not positive."""
        for name, value in vars(self).items():
            if not value > 0:
                raise ProblemError(f"VerifyOptions.{name} must be positive, is {shown(value)}")
