"""Reduced model: the robot with only a group's joints free, for planning, judging and simulation.

`trajopt.scene.reducing` builds it. The judge reads nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import pinocchio as pin

from trajopt.robot.joints import Anchor, FixedBody, JointLimits, configuration
from trajopt.values.arrays import Floats, Ints, Value, readonly
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import FrameNotFound, ProblemError, shown
from trajopt.values.placement import Placement
from trajopt.values.printed import in_number

if TYPE_CHECKING:
    from trajopt.scene.clearances import ContactAllowance
    from trajopt.scene.scene import Scene
    from trajopt.scene.track import Timing

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class DrivenJoints(Value):
    """Positions of joints driven by time.

    Attributes:
        coefficients: Of the joints' positions, in the time since the start of each piece, highest power
            first, shape (degree + 1, k, m) [rad | m].
    """

    names: tuple[str, ...]
    times: Floats
    coefficients: Floats

    def at(self, times: Floats) -> Floats:
        moments = np.clip(times, self.times[0], self.times[-1])
        piece = np.clip(np.searchsorted(self.times, moments, side="right") - 1, 0, len(self.times) - 2)
        since = (moments - self.times[piece])[:, None]
        value = self.coefficients[0, piece]
        for row in self.coefficients[1:]:
            value = value * since + row[piece]
        return value


@dataclass(frozen=True, eq=False)
class BodyPairs:
    """Pairs of bodies that must keep apart and can move relative to each other.

    Attributes:
        first: Index of the first body of each pair, shape (p,); `second` is larger.
        margin: Clearance that the optimiser aims at, above the required one, shape (p,) [m], read-only.
        required: Required clearance, and the error of the model, shape (p,) [m], read-only.
        error: Of these the part for the model's error, shape (p,) [m], read-only.
        allowances: Intended contacts, each with the index of its pair.
        immobile: Pairs of owners with a link or attached object that cannot move relative to each other; they
            are left out.
    """

    first: Ints
    second: Ints
    margin: Floats
    required: Floats
    error: Floats
    allowances: tuple[tuple[int, ContactAllowance], ...]
    immobile: frozenset[frozenset[str]]


@dataclass(frozen=True, eq=False)
class CollisionModel:
    """A scene's bodies, fixed to the joints of a reduced robot."""

    anchors: Mapping[str, Anchor]
    bodies: tuple[FixedBody, ...]
    pairs: BodyPairs


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """A scene's robot with only one group's joints free.

    Attributes:
        start: Positions of all joints at the start, shape (number of joints,) [rad | m].
        model: Pinocchio's model of the free joints and of those that mimic them; never changed.
        joint_names: The group's joints, n of them.
        limits: Respect the limits of the joints that mimic them.
        mimic_matrix: Matrix (model joints, n) that maps the group's positions to the model's.
        mimic_offset: Offsets of mimicking joints, shape (model joints,).
        collision_model: Its bodies, and the pairs that must keep apart.
        build_timed: Builds the model with dynamic obstacles, for `timed`.
    """

    scene: Scene
    group: str
    start: Floats
    model: pin.Model
    joint_names: tuple[str, ...]
    limits: JointLimits
    mimic_matrix: Floats
    mimic_offset: Floats
    collision_model: CollisionModel
    build_timed: Callable[[ReducedModel], TimedModel | None]

    def __repr__(self) -> str:
        return f"ReducedModel(group {self.group}, {in_number(self.joint_names, 'joint')}, {self.scene})"

    @property
    def bodies(self) -> tuple[FixedBody, ...]:
        return self.collision_model.bodies

    @property
    def pairs(self) -> BodyPairs:
        """The pairs of bodies that must keep apart."""
        return self.collision_model.pairs

    @property
    def anchors(self) -> Mapping[str, Anchor]:
        return self.collision_model.anchors

    def derived(self, build: Callable[[ReducedModel], T]) -> T:
        """Return a function's result for this model, computed at the first call.

        All starts with the same fixed joints share it: it must not depend on the group's start positions.
        """
        kept = _kept(self.collision_model)
        if build not in kept:
            kept[build] = build(self)
        return kept[build]

    def derived_of_robot(self, build: Callable[[ReducedModel], T]) -> T:
        """Return a function's result for the robot alone, computed at the first call.

        All scenes with the same robot and fixed joints share it: it must not depend on objects or starts.
        """
        kept = _kept_of_robot(self.model)
        if build not in kept:
            kept[build] = build(self)
        return kept[build]

    @property
    def moving_joints(self) -> tuple[str, ...]:
        """Names of the group's joints and of those that mimic them, in the model's order."""
        return self.derived_of_robot(_moving_joints)

    @property
    def timed(self) -> TimedModel | None:
        """The model with dynamic obstacles, carried by joints driven by time; None if the scene is static."""
        return self.build_timed(self)

    @cached_property
    def start_positions(self) -> Floats:
        """The group's positions at the start, shape (n,) [rad | m]."""
        return readonly(self.start[self.places_of(self.joint_names)])

    def places_of(self, joints: Sequence[str]) -> Ints:
        """Return the indices of joints among all joints of the robot."""
        names = self.scene.robot.joint_names
        return np.array([names.index(name) for name in joints], dtype=np.int64)

    def configuration(self, positions: Floats) -> Floats:
        return configuration(self.model, self.mimic_matrix @ positions + self.mimic_offset)

    def all_positions(self, positions: Floats) -> Floats:
        """Return positions of all joints of the robot for the group's positions (n,)."""
        full = np.array(self.start)
        moved = self.mimic_matrix @ positions + self.mimic_offset
        full[self.places_of(self.moving_joints)] = moved
        return full

    def owners(self, pair: int) -> tuple[str, str]:
        """Return the links or objects of the bodies of a pair."""
        first, second = int(self.pairs.first[pair]), int(self.pairs.second[pair])
        return self.bodies[first].owner, self.bodies[second].owner

    def attachment(self, name: str) -> tuple[int, Placement]:
        found = self.anchors.get(name)
        timed = self.timed if found is None else None
        if timed is not None and name in timed.reduced.anchors:
            raise ProblemError(f"{shown(name)} moves by itself: its placement depends on the time")
        if found is None:
            objects = self.scene.objects
            raise FrameNotFound("frame", name, self.anchors.keys() - objects.keys(), objects=objects)
        return found.joint, found.placement


@dataclass(frozen=True, eq=False)
class TimedModel:
    """A reduced model with the group's joints, n of them, followed by joints driven by time.

    Attributes:
        reduced: The model with all objects of its scene.
        timings: Existence of each changing object, and the motion of its carrier.
    """

    reduced: ReducedModel
    driven: DrivenJoints
    timings: Mapping[str, Timing]

    @property
    def until(self) -> float:
        """End of the time for which all motions are known [s]."""
        known = (timing.motion.until for timing in self.timings.values() if timing.motion is not None)
        return min(known, default=inf)

    def positions(self, positions: Floats, times: Floats) -> Floats:
        """Return positions of all joints for the group's positions (s, n) at times (s,), (s, n + m)."""
        return np.concatenate((positions, self.driven.at(times)), axis=1)

    def there(self, name: str, time: float) -> bool:
        """Return whether a link or an object exists at a time [s]."""
        timing = self.timings.get(name)
        return timing is None or timing.appears <= time <= timing.expires

    def error(self, name: str, time: float) -> float:
        timing = self.timings.get(name)
        return 0.0 if timing is None or timing.motion is None else timing.motion.error_at(time)

    def is_uncertain(self, name: str) -> bool:
        """Return whether a link's or object's track has an error."""
        timing = self.timings.get(name)
        return timing is not None and timing.motion is not None and any(timing.motion.error)


@cached_per_value
def _kept(collision_model: CollisionModel) -> dict[Callable[[ReducedModel], Any], Any]:
    del collision_model
    return {}


@cached_per_value
def _kept_of_robot(model: pin.Model) -> dict[Callable[[ReducedModel], Any], Any]:
    del model
    return {}


def _moving_joints(reduced: ReducedModel) -> tuple[str, ...]:
    return tuple(reduced.model.names[1:])


@dataclass(frozen=True, eq=False)
class Payload(Value):
    """A mass that a joint carries.

    Attributes:
        joint: Joint of the reduced model that carries it.
        point: Its centre of mass, in the joint's frame, shape (3,) [m].
        inertia: Its moments about that, along the joint's axes, shape (3, 3) [kg m^2].
    """

    name: str
    mass: float
    joint: int
    point: Floats
    inertia: Floats


def payloads(reduced: ReducedModel) -> tuple[Payload, ...]:
    """Return the objects with mass that the reduced model's joints carry."""
    return reduced.derived(_payloads)


def _payloads(reduced: ReducedModel) -> tuple[Payload, ...]:
    found: list[Payload] = []
    for item in reduced.scene.objects.values():
        anchor = reduced.anchors.get(item.name)
        if item.mass > 0.0 and anchor is not None and anchor.joint > 0:
            where = pin.SE3(anchor.placement.rotation, anchor.placement.translation)
            there = where.act(item.inertia)
            found.append(Payload(item.name, item.mass, anchor.joint, there.lever, there.inertia))
    return tuple(found)


def loaded_model(reduced: ReducedModel) -> pin.Model:
    """Return the pinocchio model of a reduced model with its payloads; the same model without any."""
    carried = payloads(reduced)
    if not carried:
        return reduced.model
    model = reduced.model.copy()
    for item in carried:
        model.inertias[item.joint] += pin.Inertia(item.mass, np.array(item.point), np.array(item.inertia))
    return model
