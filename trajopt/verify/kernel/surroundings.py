"""Surroundings: distances of all bodies, static and dynamic."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import TYPE_CHECKING

from trajopt.scene.reduced import TimedModel
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import Motion, TimedMotion
from trajopt.verify.kernel.options import VerifyOptions
from trajopt.verify.kernel.pair_distances import PairDistances

if TYPE_CHECKING:
    from trajopt.scene.timing import Timing


class Surroundings:
    """Workspace for distances in a static scene and among dynamic obstacles; one per thread.

    Attributes:
        still: Distances of all bodies except dynamic obstacles.
        distances: Distances of all bodies.
    """

    def __init__(self, kinematics: Kinematics, options: VerifyOptions) -> None:
        """Pass the bodies to the judge's core.

        Args:
            kinematics: Kinematics of the reduced model.
            options: Options of the judge.
        """
        self.still = self.distances = PairDistances(kinematics, error=options.distance_error)
        self._timed: TimedModel | None = kinematics.reduced.timed
        self._kinematics = kinematics
        if self._timed is not None:
            self._kinematics = Kinematics(self._timed.reduced)
            self.distances = PairDistances(
                self._kinematics, error=options.distance_error, timings=self._timed.timings
            )

    def among(self, motion: Motion, staying: float = 0.0, clock: float = 0.0) -> Motion:
        """Return a motion among the dynamic obstacles.

        Args:
            motion: Motion.
            staying: Duration of the rest at its end [s]; irrelevant in a static scene.
            clock: Scene clock at the start of the motion [s].
        """
        if self._timed is None:
            return motion
        return TimedMotion(
            self._timed,
            motion.trajectory,
            kinematics=self._kinematics,
            options=motion.options,
            staying=staying,
            clock=clock,
        )

    @property
    def given(self) -> tuple[str, ...]:
        """Assumptions of a proof on objects and their motion, in sentences."""
        objects = self._kinematics.reduced.scene.objects
        stated = [phrase for item in objects.values() for phrase in item.given]
        stated += [f"{name} {_as_said(timing)}" for name, timing in self.timings.items()]
        return tuple(f"proven given that {phrase}" for phrase in stated)

    @property
    def timings(self) -> Mapping[str, Timing]:
        """Presence and motion of each dynamic obstacle."""
        return {} if self._timed is None else self._timed.timings


def _as_said(timing: Timing) -> str:
    """Describe the stated timing of an object."""
    said: list[str] = []
    if timing.motion is not None:
        sizes = (1e3 * number for number in timing.motion.error)
        units = (" mm", " mm/s t", " mm/s^2 t^2 / 2")
        error = " + ".join(f"{size:g}{unit}" for size, unit in zip(sizes, units, strict=True) if size)
        until = f" until {timing.motion.until:g} s" if timing.motion.until < inf else ""
        said.append((f"is within {error} of its track" if error else "is on its track") + until)
    said += [f"appears at {timing.appears:g} s"] if timing.appears > 0.0 else []
    said += [f"is gone after {timing.expires:g} s"] if timing.expires < inf else []
    return " and ".join(said) or "is where it is placed"
