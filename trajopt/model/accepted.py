"""What counts as held although numbers differ: one meaning for all who plan and for the judge."""

EXCESS = 1e-6
"""Numerical excess over a limit or a tolerance that is accepted: relative to limits of velocity and
acceleration, absolute for positions and requirements [rad | m]."""
