"""Timed model: a reduced model among dynamic obstacles, which joints driven by time carry."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from trajopt.robot.joints import JointLimits
from trajopt.scene.pairs import collision_model_of
from trajopt.scene.reduced import ReducedModel, TimedModel
from trajopt.scene.reduced_robot import ReducedRobot, add_driven, reduce_robot
from trajopt.scene.scene import Scene
from trajopt.scene.track import Prediction, Timing
from trajopt.values.arrays import Bools, Floats, Ints, Printed, readonly
from trajopt.values.cached import LruCache, cached_in_value, cached_per_value


def timed_model(reduced: ReducedModel) -> TimedModel | None:
    """Return the timed model of a reduced one; None if its scene is static.

    The last results are cached for each scene.
    """
    scene = reduced.scene
    if not scene.changing:
        return None
    robot = reduce_robot(scene.robot, reduced.group, reduced.start)
    return _timed_models(scene).get(robot, lambda: _built(reduced, robot))


@cached_in_value
def _timed_models(scene: Scene) -> LruCache[ReducedRobot, TimedModel]:
    del scene  # the models refer to it
    return LruCache(4)


def _built(reduced: ReducedModel, robot: ReducedRobot) -> TimedModel:
    scene, model = reduced.scene, robot.model.copy()
    timings = {name: _timing(scene, name) for name in scene.changing}
    tracks = {
        name: motion.track for name in timings if (motion := scene.objects[name].timing.motion) is not None
    }
    drive = add_driven(model, tracks)
    extended = replace(
        robot,
        model=model,
        joint_names=(*robot.joint_names, *drive.joints.names),
        limits=_unlimited(robot.limits, drive.joints.names),
        mimic_matrix=_beside(robot.mimic_matrix, len(drive.joints.names)),
        mimic_offset=readonly(np.append(robot.mimic_offset, np.zeros(len(drive.joints.names)))),
        anchors={**robot.anchors, **drive.anchors},
        driven=drive.joints,
    )
    among = ReducedModel(
        scene,
        reduced.group,
        reduced.start,
        extended.model,
        extended.joint_names,
        extended.limits,
        extended.mimic_matrix,
        extended.mimic_offset,
        collision_model_of(scene, extended),
        _nothing_else,
    )
    return TimedModel(among, drive.joints, timings)


def _nothing_else(timed: ReducedModel) -> None:
    """Build no further timed model: the model already has all dynamic obstacles."""
    del timed


def _timing(scene: Scene, name: str) -> Timing:
    """Return the existence of an object, and the motion of its carrier."""
    carrier = scene.carrier(name)
    motion: Prediction | None = None if carrier is None else scene.objects[carrier].timing.motion
    return replace(scene.objects[name].timing, motion=motion)


def _unlimited(limits: JointLimits, names: tuple[str, ...]) -> JointLimits:
    """Return limits of the group's joints, and infinite ones for the driven joints."""
    wide = np.full(len(names), np.inf)
    fields = ("upper", "velocity", "acceleration", "jerk", "effort")
    wider = {name: readonly(np.append(getattr(limits, name), wide)) for name in fields}
    lower = readonly(np.append(limits.lower, -wide))
    return replace(limits, joint_names=(*limits.joint_names, *names), lower=lower, **wider)


def _beside(matrix: Floats, count: int) -> Floats:
    """Extend a matrix by the identity for further joints."""
    rows, columns = matrix.shape
    whole = np.zeros((rows + count, columns + count))
    whole[:rows, :columns] = matrix
    whole[rows:, columns:] = np.eye(count)
    return readonly(whole)


@dataclass(frozen=True, eq=False)
class ChangingPairs(Printed):
    """The pairs with a dynamic obstacle; temporary contacts are left to the judge.

    Attributes:
        changes: Whether a body of the pair changes with time, shape (p,).
        required: Required clearance, shape (p,) [m].
        errors: Radius, velocity and acceleration of the error, shape (p, 3).
        appears: Time from which both exist, shape (p,) [s].
        expires: Time until which both exist, shape (p,) [s].
    """

    changes: Bools
    required: Floats
    errors: Floats
    appears: Floats
    expires: Floats

    @staticmethod
    def of(timed: TimedModel) -> "ChangingPairs":
        """Return the pairs of a timed model; computed once for each."""
        return _of(timed)

    def error_at(self, time: Floats | float, pair: Ints | slice) -> Floats:
        """Return the error of pairs at times [m]."""
        radius, velocity, acceleration = self.errors[pair].T
        return radius + velocity * time + acceleration * np.square(time) / 2.0


@cached_per_value
def _of(timed: TimedModel) -> ChangingPairs:
    pairs, bodies = timed.reduced.pairs, timed.reduced.bodies
    count = len(pairs.first)
    changes, errors = np.zeros(count, dtype=np.bool_), np.zeros((count, 3))
    appears, expires = np.full(count, -inf), np.full(count, inf)
    for pair, both in enumerate(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)):
        for body in both:
            timing = timed.timings.get(bodies[int(body)].owner)
            if timing is not None:
                changes[pair] = True
                errors[pair] += (0.0, 0.0, 0.0) if timing.motion is None else timing.motion.error
                appears[pair] = max(appears[pair], timing.appears)
                expires[pair] = min(expires[pair], timing.expires)
    changes[[pair for pair, _ in pairs.allowances]] = False
    for shared in (changes, errors, appears, expires):
        shared.setflags(write=False)
    return ChangingPairs(changes, pairs.required, errors, appears, expires)
