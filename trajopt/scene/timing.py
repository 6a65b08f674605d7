"""Timing: existence and motion of an object."""

from dataclasses import dataclass
from math import inf, isfinite

from trajopt.scene.track import Prediction, Track
from trajopt.values.arrays import Value, number
from trajopt.values.errors import ModelError, ShapeError, shown


@dataclass(frozen=True, eq=False)
class Timing(Value):
    """Existence and motion of an object, on the clock of the scene.

    Attributes:
        motion: Motion of its frame; None if it rests, or is carried.
        appears: Start of its existence [s].
        expires: End of its existence [s].
    """

    motion: Prediction | None = None
    appears: float = -inf
    expires: float = inf

    @property
    def always(self) -> bool:
        """Whether it always exists and does not move."""
        return self.motion is None and self.appears == -inf and self.expires == inf

    def shifted(self, time: float) -> "Timing":
        """Return it with the clock advanced by `time` [s].

        Raises:
            ShapeError: If its motion is unknown by then, or the time is before 0.
        """
        motion = self.motion if self.motion is None else self.motion.shifted(time)
        return Timing(motion, self.appears - time, self.expires - time)

    def __repr__(self) -> str:
        """Return the fields that are not the default."""
        parts = [] if self.motion is None else [str(self.motion)]
        parts += [f"appears at {self.appears:g} s"] if isfinite(self.appears) else []
        parts += [f"expires at {self.expires:g} s"] if isfinite(self.expires) else []
        return f"Timing({', '.join(parts) or 'always there'})"


ALWAYS = Timing()
"""At rest and always existing."""


def timing_of(
    name: str, motion: Prediction | Track | None, appears: float | None, expires: float | None
) -> Timing:
    """Return the timing of an object; a track alone is a prediction without error and end.

    Args:
        name: The object's id.
        motion: Motion of its frame; None if it rests.
        appears: Start of its existence [s]; None if it always exists.
        expires: End of its existence [s]; None if it stays.

    Raises:
        ModelError: If the motion is neither track nor prediction.
        ShapeError: If it expires before it appears, or a time is not a number.
    """
    if isinstance(motion, Track):
        motion = Prediction(motion)
    if motion is not None and not isinstance(motion, Prediction):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"motion of {shown(name)} must be a Track or a Prediction, is {shown(motion)}")
    begin = -inf if appears is None else number(f"appears of {shown(name)}", appears, infinite=True)
    end = inf if expires is None else number(f"expires of {shown(name)}", expires, infinite=True)
    if begin >= end:
        raise ShapeError(f"expires of {shown(name)}", f"at {end:g} s is not after it appears at {begin:g} s")
    found = Timing(motion, begin, end)
    return ALWAYS if found.always else found
