"""Retiming: from a path q(s) to the fastest trajectory q(t) along it within the joint limits."""

from trajopt.timing.functions import DeviationBound, InverseDynamics, SpeedOfTools, ToolLimits
from trajopt.timing.result import Retimed, RetimeFailure, RetimeOptions
from trajopt.timing.retiming import retime

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
