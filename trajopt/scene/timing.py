"""Timing: when a thing is in the scene, and how it moves."""

from dataclasses import dataclass
from math import inf, isfinite

from trajopt.scene.track import Prediction, Track
from trajopt.values.arrays import Value, number
from trajopt.values.errors import ModelError, ShapeError, shown


@dataclass(frozen=True, eq=False)
class Timing(Value):
    """When a thing is there, by the clock of the scene, and where.

    Attributes:
        motion: How its frame moves; None where it rests, or is carried.
        appears: Before it is not there [s].
        expires: After it is no longer there [s].
    """

    motion: Prediction | None = None
    appears: float = -inf
    expires: float = inf

    @property
    def always(self) -> bool:
        """Whether it is always there, and where it is placed."""
        return self.motion is None and self.appears == -inf and self.expires == inf

    def shifted(self, time: float) -> "Timing":
        """Return it by a clock that shows 0 when this one's shows `time` [s].

        Raises:
            ShapeError: If nothing is known of its motion any more then, or the time is before 0.
        """
        motion = self.motion if self.motion is None else self.motion.shifted(time)
        return Timing(motion, self.appears - time, self.expires - time)

    def __repr__(self) -> str:
        """Say what differs from always."""
        parts = [] if self.motion is None else [str(self.motion)]
        parts += [f"appears at {self.appears:g} s"] if isfinite(self.appears) else []
        parts += [f"expires at {self.expires:g} s"] if isfinite(self.expires) else []
        return f"Timing({', '.join(parts) or 'always there'})"


ALWAYS = Timing()
"""At rest, and always there."""


def timing_of(
    name: str, motion: Prediction | Track | None, appears: float | None, expires: float | None
) -> Timing:
    """Return the timing of an object; a track alone is a prediction without error and without end.

    Args:
        name: The object's id.
        motion: How its frame moves; None where it rests.
        appears: Before it is not there [s]; None where it always was.
        expires: After it is no longer there [s]; None where it stays.

    Raises:
        ModelError: If the motion is neither track nor prediction.
        ShapeError: If it expires before it appears, or a time is no number.
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
