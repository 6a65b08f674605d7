"""World snapshot: a scene as last reported, and how well positions are known later."""

from dataclasses import dataclass
from functools import cached_property

from trajopt.scene.scene import Scene
from trajopt.scene.track import Prediction
from trajopt.values.arrays import Value
from trajopt.values.errors import ProblemError, shown


@dataclass(frozen=True, eq=False)
class WorldSnapshot(Value):
    """The world as it was seen last.

    Attributes:
        scene: Its clock shows 0 at the time of the stamp.
        stamp: On the executor's clock [s].
    """

    scene: Scene
    stamp: float

    def followed_by(self, scene: Scene, stamp: float) -> "WorldSnapshot":
        """Return the world as it is seen next.

        Args:
            scene: Its clock shows 0 at the time of the stamp.
            stamp: On the executor's clock [s].

        Raises:
            ProblemError: If it is a scene of another robot.
        """
        own, other = self.scene.robot, scene.robot
        # Whoever watches may do so in another process: its robot is a copy.
        if other is not own and (other.name != own.name or other.model != own.model):
            unlike = " with other joints" if other.name == own.name else ""
            raise ProblemError(
                f"the scene is of the robot {shown(other.name)}{unlike}; driven is {shown(own.name)}: "
                "tell of the world by a scene made from the problem's"
            )
        return WorldSnapshot(scene, stamp)

    def stale(self, time: float) -> str:
        """Say whose motion is not known any more at a time on the executor's clock [s]; empty if all are."""
        objects = self.scene.objects
        for name in self._changing:
            motion, since = objects[name].timing.motion, time - self.stamp
            if motion is not None and motion.until < min(since, objects[name].timing.expires):
                return f"where {name} is, was known until {self.stamp + motion.until:.3f} s"
        return ""

    def as_well_known(self, time: float) -> "WorldSnapshot | None":
        """Return the world as if all were still known as well as when it was seen; None if that is no more.

        Args:
            time: What moves has gone on along its track until then, on the executor's clock [s].
        """
        if not self._changing:
            return self
        if self.stale(time):
            return None
        scene, objects = self.at(time), self.scene.objects
        for name in scene.changing:
            timing, seen = scene.objects[name].timing, objects[name].timing.motion
            if timing.motion is not None and seen is not None:
                known = Prediction(timing.motion.track, (seen.error[0], 0.0, 0.0))
                scene = scene.with_motion(name, known, appears=timing.appears, expires=timing.expires)
        return WorldSnapshot(scene, time)

    def at(self, time: float) -> Scene:
        """Return the scene for a motion that begins at a time on the executor's clock [s].

        Raises:
            ShapeError: If nothing is known of an object's motion any more then.
        """
        return self.scene.at(self.clock(time)) if self._changing else self.scene

    def clock(self, time: float) -> float:
        """Return what the scene's clock shows at a time on the executor's clock, not before 0 [s]."""
        return max(time - self.stamp, 0.0) if self._changing else 0.0

    @cached_property
    def _changing(self) -> tuple[str, ...]:
        return self.scene.changing


def grow_uncertain(world: WorldSnapshot) -> bool:
    """Say whether the place of something is known worse and worse."""
    timings = (world.scene.objects[name].timing for name in world.scene.changing)
    return any(timing.motion is not None and any(timing.motion.error[1:]) for timing in timings)


def position_errors(world: WorldSnapshot, time: float) -> str:
    """Say how well it is known where things are at a time on the executor's clock [s], the worst first.

    Args:
        world: What is known of the world.
        time: When the robot would go on [s].
    """
    since, objects = time - world.stamp, world.scene.objects
    errors = {
        name: motion.error_at(since)
        for name in world.scene.changing
        if (motion := objects[name].timing.motion) is not None and any(motion.error[1:])
    }
    worst = sorted(errors, key=lambda name: -errors[name])
    said = [f"{name} to within {1e3 * errors[name]:.0f} mm" for name in worst]
    seen = f"what was seen {since:.2f} s before is known too badly to go on"
    return f"{seen}: {', '.join(said)}" if said else "what comes next is not proven yet"
