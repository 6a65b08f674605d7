"""Numbers that the judge works with."""

from dataclasses import dataclass

from trajopt.robot.limits import EXCESS
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked


@checked
@dataclass(frozen=True, kw_only=True)
class VerifyOptions:
    """Numbers that the judge works with.

    Attributes:
        resolution: The proven clearance comes this near to the measured one, or to three quarters of it
            where that is nearer [m].
        far: Clearance beyond which nothing is measured more closely [m].
        smallest_interval: An interval this short that is still not proven ends the search [s].
        first_intervals: Into so many intervals a motion is cut at first where it is only decided whether it
            is clear; those that prove nothing are halved.
        most_distances: Distances measured before the search for a proof is given up.
        distance_error: Taken off every measured distance: how much too large an exact mesh's may be [m].
        excess: Numerical excess over a limit or tolerance that is accepted: relative to limits of
            velocity and acceleration, absolute for positions and requirements [rad | m].
        start_error: Largest difference from the start state [rad | m].
        rest_speed: Largest speed of a joint that counts as standing still [rad/s | m/s].
        start_acceleration_error: Largest difference from an acceleration that the start has
            [rad/s^2 | m/s^2].
        meeting_speed: Largest velocity relative to a frame that is met [m/s]: the default tolerance of a
            position in a tenth of a second.
        meeting_rate: Largest rate at which a frame may turn as seen from one that is met [rad/s]: likewise.
        sample_step: Longest time between samples where nothing can be proven, such as torques [s].
        sample_travel: Where no joint can move as far in that time, samples are this far apart instead, and
            at least eight in a piece of the trajectory [rad | m].
    """

    resolution: float = 1e-3
    far: float = 0.05
    smallest_interval: float = 1e-5
    first_intervals: int = 16
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
        """Check that every number is positive.

        Raises:
            ProblemError: If one is not.
        """
        for name, value in vars(self).items():
            if not value > 0:
                raise ProblemError(f"VerifyOptions.{name} must be positive, is {shown(value)}")
