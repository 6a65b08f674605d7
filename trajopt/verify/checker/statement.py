"""The statement of a proof: robot, motion, parts and pairs, limits and requirements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import reading as take
from intervals import Floats, Interval, exactly, normalised, rotation_of
from reading import Fields, Reader
from shapes import Shape, read_shape

MOST_JOINTS = 1_000
MOST_PARTS = 5_000
MOST_KNOTS = 20_000


@dataclass(frozen=True, eq=False)
class FixedPlace:
    """A fixed placement in a joint's frame.

    Attributes:
        joint: The joint; 0 is the world.
        rotation: Shape (3, 3).
        translation: Shape (3,) [m].
    """

    joint: int
    rotation: Interval
    translation: Interval


@dataclass(frozen=True, eq=False)
class StatedJoint:
    """A joint, which turns about or slides along an axis of its own frame.

    Attributes:
        place: Of its frame at position 0, in its parent's.
        axis: Of length 1, shape (3,).
        coordinate: The number of the motion's coordinate that it follows.
        factor: Its position is factor * coordinate + offset.
        offset: Likewise [rad | m].
        lower: Least position [rad | m]; infinite for none, as the others.
        upper: Largest position [rad | m].
    """

    name: str
    place: FixedPlace
    turns: bool
    axis: Interval
    coordinate: int
    factor: float
    offset: float
    lower: float
    upper: float
    velocity: float
    acceleration: float
    jerk: float


@dataclass(frozen=True, eq=False)
class HermiteCurve:
    """The coordinates over time: Hermite interpolants between knots, cubic without accelerations.

    Attributes:
        times: Of the k knots, from 0, shape (k,) [s]. Drives may have one twice: before and after a jump.
        values: Positions, velocities and, of quintics, accelerations, each of shape (k, n).
    """

    coordinates: list[str]
    times: Floats
    values: list[Floats]


@dataclass(frozen=True, eq=False)
class Change:
    """An object that is there only from `appears` to `expires` [s], or is only near its place.

    Attributes:
        error: Radius r [m], velocity v [m/s] and acceleration a [m/s^2]: at time t no point of it is farther
            than r + v t + a t^2 / 2 from its place.
    """

    owner: str
    appears: float
    expires: float
    error: list[float]


@dataclass(frozen=True, eq=False)
class EndStates:
    """The state in which the motion must start, and how it must end.

    Attributes:
        positions: Of the coordinates at the start, shape (n,), as the others.
        accelerations: Likewise; not checked if all are 0, except for jumps if jerk is limited.
        speed: Of velocities and accelerations, and of the rest at the end.
    """

    positions: Floats
    velocities: Floats
    accelerations: Floats
    tolerance: float
    speed: float
    rests: bool


@dataclass(frozen=True, eq=False)
class ConvexPart:
    """A convex part of a link or object."""

    owner: str
    place: FixedPlace
    shape: Shape


@dataclass(frozen=True, eq=False)
class Statement:
    """Everything that a proof states.

    Attributes:
        drives: Coordinates that follow time, independent of the robot; numbered after the curve's.
        joints: The joints, each after its parent; joint number i is at i - 1.
        excess: By how much limits and tolerances may be exceeded: of positions absolute or relative to the
            limit, the larger; of rates and torques relative; of requirements absolute.
        pairs: Two parts and the clearance that they keep [m].
        excused: Two owners that need not keep apart, and the reason.
        contacts: Two owners that keep apart only from the first time until the second [s].
        judged: Sentences on facts that were judged, but are not part of the proof.
    """

    title: str
    curve: HermiteCurve
    drives: list[HermiteCurve]
    joints: list[StatedJoint]
    ends: EndStates
    excess: float
    parts: list[ConvexPart]
    changes: list[Change]
    pairs: list[tuple[int, int, float]]
    excused: list[tuple[str, str, str]]
    contacts: list[tuple[str, str, float, float]]
    requirements: list[Fields]
    judged: list[str]


def read_statement(value: Fields) -> Statement:
    """Read a statement."""
    curve = _curve("motion", value.get("motion"))
    drives = take.every(_curve, MOST_JOINTS)
    driven = sum(len(each.coordinates) for each in drives("drives", value.get("drives")))
    count, joints = len(curve.coordinates), len(take.items(MOST_JOINTS)("joints", value.get("joints")))
    part = take.below(len(take.items(MOST_PARTS)("parts", value.get("parts"))))
    change = take.row(take.text, take.least, take.most, take.row(*[take.size] * 3))
    read = _record_of(
        Statement,
        title=take.text,
        motion=_curve,
        drives=drives,
        joints=take.every(_joint(count + driven, joints)),
        ends=_ends(count),
        excess=take.size,
        parts=take.every(_record_of(ConvexPart, owner=take.text, place=place_in(joints), shape=read_shape)),
        changes=take.every(lambda where, value: Change(*change(where, value))),
        pairs=take.every(take.row(part, part, take.size)),
        excused=take.every(take.row(take.text, take.text, take.text)),
        contacts=take.every(take.row(take.text, take.text, take.least, take.most)),
        requirements=take.every(take.mapping),
        judged=take.every(take.text),
    )
    found: Statement = read("statement", value)
    whole = all(each.times[-1] >= curve.times[-1] for each in found.drives) and np.diff(curve.times).all()
    take.demand(whole, "the times of the motion must increase, and drives must last until its end")
    ordered = all(joint.place.joint <= at for at, joint in enumerate(found.joints))
    take.demand(ordered, "a joint must come after its parent")
    free = all(joint.coordinate < count or joint.jerk == np.inf for joint in found.joints)
    take.demand(free, "a joint that follows time cannot have a limit of jerk")
    return found


def place_in(joints: int) -> Reader:
    """Return a reader of placements in the frame of one of some joints, or of the world."""
    return _record_of(
        FixedPlace,
        joint=take.below(joints + 1),
        rotation=take.direction(4, rotation_of),
        translation=lambda where, value: exactly(take.numbers(3)(where, value)),
    )


def _record_of(kind: Callable[..., object], **readers: Reader) -> Reader:
    return lambda where, value: kind(*take.record(where, value, readers))


def _curve(where: str, value: object) -> HermiteCurve:
    names, values = take.every(take.text, MOST_JOINTS), take.every(take.numbers(None, None), 3)
    found: HermiteCurve = _record_of(
        HermiteCurve, coordinates=names, times=take.numbers(None), values=values
    )(where, value)
    times, shape = found.times, (len(found.times), len(found.coordinates))
    ordered = 2 <= len(times) <= MOST_KNOTS and times[0] == 0.0 and (np.diff(times) >= 0.0).all()
    take.demand(ordered, f"the times of {where} must increase from 0, and be 2 to {MOST_KNOTS}")
    whole = len(found.values) >= 2 and all(each.shape == shape for each in found.values)
    take.demand(whole, f"{where} needs positions and velocities of each coordinate at each time")
    return found


def _joint(coordinates: int, joints: int) -> Reader:
    limits = dict.fromkeys(("upper", "velocity", "acceleration", "jerk"), take.most)
    follows = {"coordinate": take.below(coordinates), "factor": take.number, "offset": take.number}
    return _record_of(
        StatedJoint,
        name=take.text,
        place=place_in(joints),
        turns=take.flag,
        axis=take.direction(3, normalised),
        **follows,
        lower=take.least,
        **limits,
    )


def _ends(count: int) -> Reader:
    state = dict.fromkeys(("positions", "velocities", "accelerations"), take.numbers(count))
    return _record_of(EndStates, **state, tolerance=take.size, speed=take.size, rests=take.flag)
