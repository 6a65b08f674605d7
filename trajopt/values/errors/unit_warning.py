"""A warning that a number is likely in another unit, shown at the line of the caller."""

import sys
import warnings


class UnitWarning(UserWarning):
    """A number is taken as it is, though another unit is likely: degrees for radians, mm for m."""


def warn_of_unit(words: str) -> None:
    """Warn at the line outside of trajopt that the number comes from."""
    level, frame = 2, sys._getframe(1)  # pyright: ignore[reportPrivateUsage]
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "trajopt":
        level, frame = level + 1, frame.f_back
    warnings.warn(words, UnitWarning, stacklevel=level)
