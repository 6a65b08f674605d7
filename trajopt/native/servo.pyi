"""Stub of the native core `servo`: the arithmetic of a tick; the same in plain Python is in tests/oracles."""

from trajopt.values.arrays import Floats, Ints

class Braking:
    """Velocities of joints after a tick, and the time in which they stop."""

    def __init__(
        self, limits: Floats, delay: Floats, period: float, cycle: float, excess: float, inset: float
    ) -> None: ...
    def time(self, velocities: Floats) -> float: ...
    def bounds(self, state: Floats) -> tuple[Floats, Floats]: ...
    def after(self, state: Floats, settled: Floats) -> Floats: ...

class BodySpeeds:
    """Approach speeds of pairs of bodies."""

    def __init__(
        self,
        joint: Ints,
        centre: Floats,
        radius: Floats,
        carried: Floats,
        first: Ints,
        second: Ints,
        mimic: Floats,
        levers: Floats,
    ) -> None: ...
    def nearer(
        self, rotation: Floats, translation: Floats, jacobian: Floats, lower: Floats, upper: Floats
    ) -> Floats: ...

def singular_values(
    linear: Floats, angular: Floats, mimic: Floats, length: float
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the singular values of a tool's Jacobian, and their slopes."""

def approach(
    linear: Floats,
    angular: Floats,
    mimic: Floats,
    length: float,
    twist: Floats,
    velocity: Floats,
    ending: float,
) -> tuple[Floats, Floats]:
    """Return the slopes of the singular values, and how far each may fall on a twist."""

def settle(
    task: Floats,
    target: Floats,
    approach: Floats,
    least: Floats,
    lower: Floats,
    upper: Floats,
    velocity: Floats,
    weights: tuple[float, float, float, float, float],
    max_iterations: int,
) -> Floats | None:
    """Return the velocities between bounds that follow a task best."""
