"""Retiming: a path q(s) becomes the fastest trajectory q(t) along it that holds the joints' limits."""

from trajopt.retime.constraints import InverseDynamics, SpeedOfTools, ToolLimits
from trajopt.retime.result import Retimed, RetimeFailure, RetimeOptions
from trajopt.retime.retiming import retime
from trajopt.retime.smoothing import DeviationBound

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
