"""Options of a simulation, and friction of a loose object."""

from dataclasses import dataclass

from trajopt.values.arrays import number
from trajopt.values.errors import ShapeError


@dataclass(frozen=True)
class SimulationOptions:
    """Options of `simulate`.

    Attributes:
        dt: Time step of the physics and of the controller [s].
        natural_frequency: Of the tracking error under the controller [rad/s]: an error decays in a few
            1 / natural_frequency. Stiff industrial arms reach 50 rad/s.
        damping_ratio: Of the tracking error; 1 is critical damping.
        settling_time: Time for which the last position is held after the motion [s].
        sample_period: Time between stored samples, rounded to steps [s].
    """

    dt: float = 0.002
    natural_frequency: float = 50.0
    damping_ratio: float = 1.0
    settling_time: float = 0.3
    sample_period: float = 0.01

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("dt", "natural_frequency", "damping_ratio", "sample_period"):
            if number(name, getattr(self, name)) <= 0.0:
                raise ShapeError(name, f"must be positive, is {getattr(self, name):g}")
        if number("settling_time", self.settling_time) < 0.0:
            raise ShapeError("settling_time", f"must not be negative, is {self.settling_time:g} s")
        if self.dt * self.natural_frequency > 0.5:
            raise ShapeError(
                "natural_frequency",
                f"{self.natural_frequency:g} rad/s is too high for steps of {self.dt:g} s; "
                "their product must not exceed 0.5",
            )


@dataclass(frozen=True)
class Friction:
    """Friction of a loose object.

    Attributes:
        pads: Coefficient between object and fingers.
        others: Coefficient between object and other bodies.
        torsional: Coefficient against turning about the normal, for all contacts: about the radius of the
            contact patch [m].
    """

    pads: float = 0.8
    others: float = 0.5
    torsional: float = 0.005

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("pads", "others", "torsional"):
            if number(name, getattr(self, name)) < 0.0:
                raise ShapeError(name, f"must not be negative, is {getattr(self, name):g}")
