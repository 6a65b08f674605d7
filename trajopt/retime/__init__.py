"""Retiming: a path q(s) becomes the fastest trajectory q(t) that holds the joints' limits."""

from trajopt.retime.options import RetimeOptions
from trajopt.retime.result import Retimed, RetimeFailure
from trajopt.retime.retiming import retime
from trajopt.retime.rounding import DeviationBound
from trajopt.retime.tool import SpeedOfTools, ToolLimits
from trajopt.retime.torque import InverseDynamics

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
