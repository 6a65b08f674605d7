"""The functions that retiming asks for torques, speeds of tools and deviations."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from trajopt.values.arrays import Floats, Value
from trajopt.values.errors.arguments import checked

SpeedOfTools: TypeAlias = Callable[[Floats, Floats], Floats]
"""Positions and velocities of the joints, (S, n) each -> m speeds of tools, (S, m) [m/s | rad/s]."""
InverseDynamics: TypeAlias = Callable[[Floats, Floats, Floats], Floats]
"""Positions, velocities and accelerations of the joints, (S, n) each -> their torques (S, n) [Nm | N]."""
DeviationBound: TypeAlias = Callable[[Floats, Floats], Floats]
"""Positions (S, n) on the smooth path and on the polyline -> how far any body moves (S,) [m]."""


@checked
@dataclass(frozen=True, eq=False)
class ToolLimits(Value):
    """Limited speeds of tools, and the function that returns them.

    Attributes:
        speeds: Returns the speeds; they must be proportional to the velocities' size.
        limit: Largest speeds, positive, shape (m,) [m/s | rad/s].
        names: What each is, for sentences.
    """

    speeds: SpeedOfTools
    limit: Floats
    names: tuple[str, ...]
