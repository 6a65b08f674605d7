"""Seeds made by hand; those that planning makes are in `trajopt.planning.seeds`."""

from trajopt.planning.seeds import straight_line

__all__ = ["straight_line"]
