"""The scene over time, for physics and pictures: bodies on tracks, which appear and expire."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.robot.joints import FixedBody
from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.reduced import ReducedModel, TimedModel
from trajopt.scene.timing import Timing
from trajopt.scene.track import Prediction
from trajopt.simulation.mujoco_geoms import scalar_first
from trajopt.values.arrays import Floats
from trajopt.values.placement import IDENTITY, Placement
from trajopt.values.printed import in_length

NOWHERE = ("nothing", "nothing else")
"""Names of two specks that never touch; they replace pairs of which one body is absent."""
SPECK = 1e-3
"""Their radius, much smaller than their distance [m]."""


@dataclass(frozen=True, eq=False)
class DynamicScene:
    """A scene over time.

    Attributes:
        whole: The reduced model with all objects; joints driven by time come after its own.
        timed: The part that changes; None if the scene is static.
        tracks: Name of a frame that moves by itself -> its motion.
    """

    whole: ReducedModel
    timed: TimedModel | None
    tracks: Mapping[str, Prediction]

    @staticmethod
    def of(reduced: ReducedModel) -> "DynamicScene":
        """Return the scene of a reduced model."""
        timed, objects = reduced.timed, reduced.scene.objects
        if timed is None:
            return DynamicScene(reduced, None, {})
        moved = {name: objects[name].timing.motion for name in timed.timings}
        tracks = {name: motion for name, motion in moved.items() if motion is not None}
        return DynamicScene(timed.reduced, timed, tracks)

    @property
    def timings(self) -> Mapping[str, Timing]:
        """Interval of presence and motion of each object that changes."""
        return {} if self.timed is None else self.timed.timings

    def present(self, name: str, time: float) -> bool:
        """Return whether a link or an object is present at a time [s]."""
        return self.timed is None or self.timed.there(name, time)

    def error(self, name: str, time: float) -> float:
        """Return the position error of a link or an object at a time [s], in metres."""
        return 0.0 if self.timed is None else self.timed.error(name, time)

    def is_uncertain(self, name: str) -> bool:
        """Return whether a link or an object has a position error at any time."""
        return self.timed is not None and self.timed.is_uncertain(name)

    def moved(self, name: str, time: float) -> Placement:
        """Return the displacement of an object on a track from time 0 to a time [s], in the world."""
        timing = self.timings.get(name)
        if timing is None or timing.motion is None:
            return IDENTITY
        track = timing.motion.track
        return track.at(time) * track.at(0.0).inverse()

    def state(self, time: float) -> Floats:
        """Return numbers that are equal for equal states of the scene."""
        flags = np.array([(float(self.present(name, time)), self.error(name, time)) for name in self.timings])
        places = [motion.track.at(time).homogeneous.ravel() for motion in self.tracks.values()]
        return np.concatenate((flags.ravel(), *places))

    def placement(self, body: FixedBody) -> Placement:
        """Return the placement of a body in the frame that moves it: its joint's, or one on a track."""
        carrier = self._carriers.get(body.joint)
        if carrier is None:
            return body.placement
        return self.whole.anchors[carrier].placement.inverse() * body.placement

    def add_frames(
        self, spec: mujoco.MjSpec, joints: Sequence[mujoco.MjsBody]
    ) -> Mapping[int, mujoco.MjsBody]:
        """Add a mocap body of MuJoCo for each frame that moves by itself.

        Args:
            spec: The model.
            joints: Its bodies, by joint.

        Returns:
            These, and the mocap bodies by the last joint of their frames.
        """
        moved = {
            joint: spec.worldbody.add_body(name=name, mocap=True) for joint, name in self._carriers.items()
        }
        return {**dict(enumerate(joints)), **moved}

    def put(self, model: mujoco.MjModel, data: mujoco.MjData, time: float) -> None:
        """Place the mocap bodies at a time [s]."""
        for name, motion in self.tracks.items():
            where, place = motion.track.at(time), int(model.body(name).mocapid[0])
            data.mocap_pos[place], data.mocap_quat[place] = where.translation, scalar_first(where)

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence for each object with a position error, which is simulated exactly on its track.

        Links of another robot, "other/link1" and "other/link2", share a sentence.
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
        """Last joint of a frame that moves by itself -> the frame."""
        return {self.whole.anchors[name].joint: name for name in self.tracks}


def add_specks(spec: mujoco.MjSpec) -> None:
    """Add the two specks that replace pairs of which one body is absent."""
    for height, name in enumerate(NOWHERE):
        speck = spec.worldbody.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE)
        speck.size, speck.pos = np.full(3, SPECK), np.array((0.0, 0.0, float(height)))
        speck.mass, speck.contype, speck.conaffinity = 0.0, 0, 0
        speck.rgba = np.zeros(4)


class Presence:
    """Disables the pairs of absent bodies; one for each simulation."""

    def __init__(self, changing: DynamicScene, model: mujoco.MjModel, owners: Sequence[str]) -> None:
        """Find the pairs of bodies that appear or expire.

        Args:
            changing: The scene over time.
            model: The compiled model; its pairs are changed.
            owners: Link or object of each geometry.
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
        """Enable exactly the pairs whose bodies are both present at a time [s]."""
        if not self._of:
            return
        model = self._model
        model.pair_geom1[:], model.pair_geom2[:] = self._pairs
        for name, pairs in self._of.items():
            if not self._changing.present(name, time):
                model.pair_geom1[pairs], model.pair_geom2[pairs] = self._nowhere

    @property
    def _nowhere(self) -> tuple[int, int]:
        one, other = (self._model.geom(name).id for name in NOWHERE)
        return one, other
