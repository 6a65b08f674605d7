"""World snapshot: the scene as last reported, and the errors of its predictions."""

from dataclasses import dataclass
from functools import cached_property

from trajopt.scene.scene import Scene
from trajopt.scene.track import Prediction
from trajopt.values.arrays import Value
from trajopt.values.errors import ProblemError, shown


@dataclass(frozen=True, eq=False)
class WorldSnapshot(Value):
    """The world as it was last reported.

    Attributes:
        scene: Its clock shows 0 at the time of the stamp.
        stamp: On the executor's clock [s].
    """

    scene: Scene
    stamp: float

    def updated(self, scene: Scene, stamp: float) -> "WorldSnapshot":
        """Return the next snapshot, of the same robot."""
        driven, other = self.scene.robot, scene.robot
        # A scene from another process contains a copy of the robot.
        if other is not driven and (other.name != driven.name or other.model != driven.model):
            unlike = " with other joints" if other.name == driven.name else ""
            raise ProblemError(
                f"the scene contains the robot {shown(other.name)}{unlike}, but {shown(driven.name)} is "
                "driven; derive the scene from the one of the problem"
            )
        return WorldSnapshot(scene, stamp)

    def stale(self, time: float) -> str:
        """Describe an obstacle whose prediction ended before a time [s]; empty if none."""
        objects = self.scene.objects
        for name in self._changing:
            motion, since = objects[name].timing.motion, time - self.stamp
            if motion is not None and motion.until < min(since, objects[name].timing.expires):
                return f"the motion of {name} is predicted until {self.stamp + motion.until:.3f} s only"
        return ""

    def without_growing_errors(self, time: float) -> "WorldSnapshot | None":
        """Return the world at a time [s] with the errors of the stamp; None if a prediction has ended."""
        if not self._changing:
            return self
        if self.stale(time):
            return None
        scene, objects = self.at(time), self.scene.objects
        for name in scene.changing:
            timing, reported = scene.objects[name].timing, objects[name].timing.motion
            if timing.motion is not None and reported is not None:
                known = Prediction(timing.motion.track, (reported.error[0], 0.0, 0.0))
                scene = scene.with_motion(name, known, appears=timing.appears, expires=timing.expires)
        return WorldSnapshot(scene, time)

    @property
    def errors_grow(self) -> bool:
        """Whether the error of any predicted position grows with time."""
        timings = (self.scene.objects[name].timing for name in self._changing)
        return any(timing.motion is not None and any(timing.motion.error[1:]) for timing in timings)

    def growing_errors(self, time: float) -> str:
        """Describe why a robot cannot go on at a time [s]: grown position errors, the largest first."""
        since, objects = time - self.stamp, self.scene.objects
        errors = {
            name: motion.error_at(since)
            for name in self._changing
            if (motion := objects[name].timing.motion) is not None and any(motion.error[1:])
        }
        if not errors:
            return "the next piece of the motion is not proven yet"
        worst = sorted(errors, key=lambda name: -errors[name])
        listed = ", ".join(f"{name} to within {1e3 * errors[name]:.0f} mm" for name in worst)
        return f"positions reported {since:.2f} s before are too uncertain to go on: {listed}"

    def at(self, time: float) -> Scene:
        """Return the scene for a motion that begins at a time on the executor's clock [s].

        Raises:
            ShapeError: If the motion of an object is no longer predicted then.
        """
        return self.scene.at(self.clock(time)) if self._changing else self.scene

    def clock(self, time: float) -> float:
        """Return the time of the scene's clock at a time of the executor's clock, not before 0 [s]."""
        return max(time - self.stamp, 0.0) if self._changing else 0.0

    @cached_property
    def _changing(self) -> tuple[str, ...]:
        return self.scene.changing
