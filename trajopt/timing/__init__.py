"""From a path q(s) to the fastest trajectory q(t) along it within the joint limits."""

from trajopt.timing.retiming import (
    DeviationBound,
    InverseDynamics,
    Retimed,
    RetimeFailure,
    RetimeOptions,
    SpeedOfTools,
    ToolLimits,
    retime,
)

__all__ = [
    "DeviationBound",
    "InverseDynamics",
    "RetimeFailure",
    "RetimeOptions",
    "Retimed",
    "SpeedOfTools",
    "ToolLimits",
    "retime",
]
