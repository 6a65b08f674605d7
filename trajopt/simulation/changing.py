"""What changes with time around a robot, for physics and pictures: motion-captured bodies, there or not."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.robot.bodies import FixedBody
from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.timed import TimedModel, timed_model
from trajopt.scene.timing import Timing
from trajopt.scene.track import Prediction
from trajopt.simulation.pieces import scalar_first
from trajopt.values.arrays import Floats
from trajopt.values.placement import IDENTITY, Placement
from trajopt.values.printed import in_length

NOWHERE = ("nothing", "nothing else")
"""Names of two specks that never touch: they take the place of pairs of which one thing is not there."""
SPECK = 1e-3
"""Their radius; they are far more than that apart [m]."""


@dataclass(frozen=True, eq=False)
class Changing:
    """Everything in a scene, and what of it changes with time.

    Attributes:
        whole: The reduced model with everything in its scene; joints that time drives come after its own.
        timed: What changes; None where nothing does.
        tracks: The motion of each frame that moves by itself, by its name.
    """

    whole: ReducedModel
    timed: TimedModel | None
    tracks: Mapping[str, Prediction]

    @staticmethod
    def of(reduced: ReducedModel) -> "Changing":
        """Look at a reduced model's scene."""
        timed, objects = timed_model(reduced), reduced.scene.objects
        if timed is None:
            return Changing(reduced, None, {})
        moved = {name: objects[name].timing.motion for name in timed.timings}
        tracks = {name: motion for name, motion in moved.items() if motion is not None}
        return Changing(timed.reduced, timed, tracks)

    @property
    def timings(self) -> Mapping[str, Timing]:
        """Of each object that changes: when it is there, and the motion of what carries it."""
        return {} if self.timed is None else self.timed.timings

    def there(self, name: str, time: float) -> bool:
        """Say whether a link or an object is there at a time [s]."""
        return self.timed is None or self.timed.there(name, time)

    def error(self, name: str, time: float) -> float:
        """Return how far a link or an object may be off its track at a time [s], in metres."""
        return 0.0 if self.timed is None else self.timed.error(name, time)

    def is_uncertain(self, name: str) -> bool:
        """Say whether a link or an object may ever be off its track."""
        return self.timed is not None and self.timed.is_uncertain(name)

    def moved(self, name: str, time: float) -> Placement:
        """Return how an object on a track has been moved in the world from time 0 to a time [s]."""
        timing = self.timings.get(name)
        if timing is None or timing.motion is None:
            return IDENTITY
        track = timing.motion.track
        return track.at(time) * track.at(0.0).inverse()

    def state(self, time: float) -> Floats:
        """Return numbers that are equal where everything that changes is equal."""
        flags = np.array([(float(self.there(name, time)), self.error(name, time)) for name in self.timings])
        places = [motion.track.at(time).homogeneous.ravel() for motion in self.tracks.values()]
        return np.concatenate((flags.ravel(), *places))

    def placement(self, body: FixedBody) -> Placement:
        """Return where a body is in the frame that moves it: that of its joint, or one on a track."""
        carrier = self._carriers.get(body.joint)
        if carrier is None:
            return body.placement
        return self.whole.anchors[carrier].placement.inverse() * body.placement

    def add_frames(
        self, spec: mujoco.MjSpec, joints: Sequence[mujoco.MjsBody]
    ) -> Mapping[int, mujoco.MjsBody]:
        """Add a motion-captured body for each frame that moves by itself.

        Args:
            spec: The model.
            joints: Its bodies, by the joint that moves them.

        Returns:
            Those, and by its last joint the one of each frame that time drives.
        """
        moved = {
            joint: spec.worldbody.add_body(name=name, mocap=True) for joint, name in self._carriers.items()
        }
        return {**dict(enumerate(joints)), **moved}

    def put(self, model: mujoco.MjModel, data: mujoco.MjData, time: float) -> None:
        """Put the motion-captured bodies where they are at a time [s]."""
        for name, motion in self.tracks.items():
            where, place = motion.track.at(time), int(model.body(name).mocapid[0])
            data.mocap_pos[place], data.mocap_quat[place] = where.translation, scalar_first(where)

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence for everything that may be off its track: what is simulated is exactly on it.

        Links of another robot, "other/link1" and "other/link2", are told of as one.
        """
        errors: dict[str, tuple[float, bool]] = {}
        for name, motion in self.tracks.items():
            thing = name.split("/")[0]
            first, grows = errors.get(thing, (0.0, False))
            errors[thing] = max(first, motion.error[0]), grows or any(motion.error[1:])
        return tuple(
            f"{thing}: simulated exactly on its track, from which it may be {in_length(first)} away"
            f"{' at first, and more with time' if grows else ''}"
            for thing, (first, grows) in errors.items()
            if first > 0.0 or grows
        )

    @property
    def _carriers(self) -> Mapping[int, str]:
        """The frame that moves by itself, by the last of the joints that drive it."""
        return {self.whole.anchors[name].joint: name for name in self.tracks}


def add_specks(spec: mujoco.MjSpec) -> None:
    """Add the two specks that take the place of pairs of which one thing is not there."""
    for height, name in enumerate(NOWHERE):
        speck = spec.worldbody.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE)
        speck.size, speck.pos = np.full(3, SPECK), np.array((0.0, 0.0, float(height)))
        speck.mass, speck.contype, speck.conaffinity = 0.0, 0, 0
        speck.rgba = np.zeros(4)


class Presence:
    """Lets only those touch that are there; one for each simulation."""

    def __init__(self, changing: Changing, model: mujoco.MjModel, owners: Sequence[str]) -> None:
        """Find the pairs of what comes and goes.

        Args:
            changing: What changes with time.
            model: The compiled model; its pairs are changed.
            owners: Link or object of each geometry, by its number.
        """
        self._changing, self._model = changing, model
        self._pairs = np.stack((model.pair_geom1, model.pair_geom2))
        come_and_go = {
            name
            for name, timing in changing.timings.items()
            if np.isfinite((timing.appears, timing.expires)).any()
        }
        self._of: dict[str, list[int]] = {name: [] for name in come_and_go}
        for pair, both in enumerate(self._pairs.T.tolist()):
            for geom in both:
                if owners[int(geom)] in come_and_go:
                    self._of[owners[int(geom)]].append(pair)

    def show(self, time: float) -> None:
        """Let exactly those pairs touch of which both are there at a time [s]."""
        if not self._of:
            return
        model = self._model
        model.pair_geom1[:], model.pair_geom2[:] = self._pairs
        for name, pairs in self._of.items():
            if not self._changing.there(name, time):
                model.pair_geom1[pairs], model.pair_geom2[pairs] = self._nowhere

    @property
    def _nowhere(self) -> tuple[int, int]:
        one, other = (self._model.geom(name).id for name in NOWHERE)
        return one, other
