"""Callables that retiming uses for torques, tool speeds and path deviation."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from trajopt.values.arrays import Floats, Value
from trajopt.values.errors.arguments import checked

SpeedOfTools: TypeAlias = Callable[[Floats, Floats], Floats]
"""Joint positions and velocities, (S, n) each -> m tool speeds, (S, m) [m/s | rad/s]."""
InverseDynamics: TypeAlias = Callable[[Floats, Floats, Floats], Floats]
"""Joint positions, velocities and accelerations, (S, n) each -> joint torques, (S, n) [Nm | N]."""
DeviationBound: TypeAlias = Callable[[Floats, Floats], Floats]
"""Positions (S, n) on the smooth path and on the polyline -> bound on the travel of any body point, (S,)
[m].
"""


@checked
@dataclass(frozen=True, eq=False)
class ToolLimits(Value):
    """Limited tool speeds.

    Attributes:
        speeds: Computes the speeds; they must scale with the joint velocities.
        limit: Largest speeds, positive, shape (m,) [m/s | rad/s].
        names: Name of each speed for messages.
    """

    speeds: SpeedOfTools
    limit: Floats
    names: tuple[str, ...]
