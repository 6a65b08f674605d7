"""Required clearance and signed distance of pairs of bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from functools import cached_property
from math import inf
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from trajopt.native import proof
from trajopt.scene.clearances import PairKind
from trajopt.scene.reduced import ReducedModel, TimedModel
from trajopt.values.arrays import Bools, Floats, Ints, readonly
from trajopt.values.errors import ModelError
from trajopt.values.placement import WORLD
from trajopt.values.shapes.shapes import Mesh, Plane
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.motion import JudgedMotion, TimedMotion
from trajopt.verify.kernel.options import VerifyOptions
from trajopt.verify.kernel.shapes import form_of

if TYPE_CHECKING:
    from trajopt.scene.scene import Scene
    from trajopt.scene.track import Timing

ROWS = {
    PairKind.WORLD: "clearance from the world",
    PairKind.CARRIED: "clearance of attached objects",
    PairKind.ROBOT: "clearance of the robot from itself",
}
"""Names of the clearance checks if the scene sets clearances of kinds of pairs."""


def required_clearances(reduced: ReducedModel) -> Floats:
    """Return the required clearance of each pair, shape (p,) [m], read-only.

    A clearance of the pair itself comes first, then of its kinds, then the general one; from the world it is
    at least the link's padding.
    """
    return reduced.derived(_required)


def rows(reduced: ReducedModel) -> Sequence[tuple[str, Ints]]:
    """Return names of the clearance checks with their pairs: one per required clearance or kind."""
    required, scene = required_clearances(reduced), reduced.scene
    if not scene.clearances.kinds:
        return [("clearance", np.flatnonzero(required == level)) for level in sorted(set(required.tolist()))]
    kinds = reduced.derived(_kinds)
    found: list[tuple[str, Ints]] = []
    for number, kind in enumerate(PairKind):
        mine = kinds == number
        levels = sorted(set(required[mine].tolist()))
        found += [(ROWS[kind], np.flatnonzero(mine & (required == level))) for level in levels]
    return found


def _required(reduced: ReducedModel) -> Floats:
    scene, stated = reduced.scene, reduced.scene.clearances
    if not (stated.pairs or stated.links or stated.kinds):
        return readonly(np.full(len(reduced.pairs.first), stated.everywhere))
    world = _of_the_world(scene)
    pairs = _owners(reduced)
    known = {pair: _of(scene, world, *sorted(pair)) for pair in set(pairs)}
    return readonly(np.array([known[pair] for pair in pairs], dtype=np.float64))


def _of(scene: Scene, world: Set[str], one: str, other: str) -> float:
    stated = scene.clearances
    single = stated.pairs.get(frozenset((one, other)))
    if single is not None:
        return single
    meant = _meant(scene, world, one, other)
    value = max([stated.kinds[kind] for kind in meant if kind in stated.kinds] or [stated.everywhere])
    carriers = [_carrier(scene, name) for name in (one, other)]
    if WORLD in carriers:
        value = max([value, *(stated.links.get(carrier, 0.0) for carrier in carriers)])
    return value


def _carrier(scene: Scene, name: str) -> str:
    while name in scene.objects or name in scene.tools:
        name = (scene.objects.get(name) or scene.tools[name]).frame
    frame = scene.robot.frames.get(name)
    return name if frame is None else frame.link


def _meant(scene: Scene, world: Set[str], one: str, other: str) -> tuple[PairKind, ...]:
    """Return the kinds that determine the clearance of two links or objects, most specific first."""
    among = (PairKind.WORLD,) if world & {one, other} else ()
    held = [name for name in (one, other) if name in scene.objects and name not in world]
    return among + ((PairKind.CARRIED,) if held else ()) or (PairKind.ROBOT,)


def _of_the_world(scene: Scene) -> frozenset[str]:
    """Return the links and objects fixed in the world.

    An object is, unless a joint of the robot moves it; a link, if it is the ancestor of no joint and no link
    with a shape lies between it and the root, which itself has none.
    """
    parents, moving = _tree(scene)
    above = {link: _above(parents, link) for link in scene.robot.links}
    carrying = {name for link in moving for name in above[link]}
    between = {*moving, *(body.owner for body in scene.robot.bodies)}
    found = {
        link
        for link in scene.robot.links
        if above[link] and link not in moving | carrying and not between.intersection(above[link])
    }
    for name in scene.objects:
        holder = _carrier(scene, name)
        if holder == WORLD or not moving.intersection((holder, *above[holder])):
            found.add(name)
    return frozenset(found)


def _tree(scene: Scene) -> tuple[dict[str, str], set[str]]:
    frames, parents, moving = scene.robot.model.frames, dict[str, str](), set[str]()
    for frame in frames:
        if frame.type != pin.FrameType.BODY or frame.parentFrame == 0:
            continue
        joint = frames[frame.parentFrame]
        if joint.parentFrame > 0:
            parents[frame.name] = frames[joint.parentFrame].name
        if joint.type == pin.FrameType.JOINT:
            moving.add(frame.name)
    return parents, moving


def _above(parents: Mapping[str, str], link: str) -> list[str]:
    found: list[str] = []
    while link in parents:
        link = parents[link]
        found.append(link)
    return found


def _kinds(reduced: ReducedModel) -> Ints:
    order, scene, pairs = tuple(PairKind), reduced.scene, _owners(reduced)
    world = _of_the_world(scene)
    first = {pair: order.index(_meant(scene, world, *sorted(pair))[0]) for pair in set(pairs)}
    return np.array([first[pair] for pair in pairs], dtype=np.int64)


def _owners(reduced: ReducedModel) -> list[frozenset[str]]:
    return [frozenset(reduced.owners(pair)) for pair in range(len(reduced.pairs.first))]


NONE: Mapping[str, Timing] = MappingProxyType({})
DOUBTFUL = 1e-5
"""Difference between Coal's distance and the gap along its normal at which all directions are searched
[m].
"""


class PairDistances:
    """Workspace for signed distances of pairs of bodies; one per thread.

    A distance is minus the depth in penetration. Each is a lower bound of the true one, from the judge's own
    support functions; distances of half-spaces are exact. An exact mesh has no depth, so its convex hull
    replaces it in contact and around enclosed bodies.

    Attributes:
        planar: Whether a pair includes a half-space, shape (p,).
        present: Time span in which both bodies of each pair are present, shape (p, 2) [s]; None if always.
        changing: Whether a pair includes a dynamic obstacle, shape (p,).
    """

    def __init__(self, kinematics: Kinematics, *, error: float, timings: Mapping[str, Timing] = NONE) -> None:
        """Pass the bodies and pairs of a model to the core.

        Args:
            error: Reserve subtracted from every distance [m].
            timings: Of the dynamic obstacles, by name; their prediction errors are also subtracted, and the
                errors of the model.
        """
        reduced = kinematics.reduced
        self.reduced, self.error = reduced, error
        self.first, self.second = reduced.pairs.first, reduced.pairs.second
        planes = np.array([isinstance(body.shape, Plane) for body in reduced.bodies], dtype=np.bool_)
        self.planar: Bools = planes[self.first] | planes[self.second]
        both = planes[self.first] & planes[self.second]
        if both.any():
            pair = int(both.argmax())
            raise ModelError(f"half-spaces {self.pair_name(pair)} cannot be a pair; allow their contact")
        bodies = reduced.bodies
        self.present: Floats | None = None
        self.changing: Bools = np.zeros(len(self.first), dtype=np.bool_)
        errors = self._changing(timings)
        self.core = proof.Proof(
            kinematics.arm,
            [form_of(body.shape) for body in bodies],
            np.array([body.joint for body in bodies], dtype=np.int64),
            np.array([body.placement.rotation for body in bodies]),
            np.array([body.placement.translation for body in bodies]),
            self.first,
            self.second,
            required_clearances(reduced),
            errors,
            ~self.strict | (self.changing & errors.any(axis=1)),
            error,
        )

    def _changing(self, timings: Mapping[str, Timing]) -> Floats:
        errors: Floats = np.zeros((len(self.first), 3))
        errors[:, 0] = self.reduced.pairs.error
        if not timings:
            return errors
        present: Floats = np.tile((-np.inf, np.inf), (len(self.first), 1))
        owners = np.array([body.owner for body in self.reduced.bodies])
        for side in (self.first, self.second):
            of_pair = owners[side]
            for name, timing in timings.items():
                mine = of_pair == name
                self.changing |= mine
                present[mine, 0] = np.maximum(present[mine, 0], timing.appears)
                present[mine, 1] = np.minimum(present[mine, 1], timing.expires)
                if timing.motion is not None:
                    errors[mine] += timing.motion.error
        if np.isfinite(present).any():
            self.present = present
        return errors

    def owners(self, pair: int) -> tuple[str, str]:
        """Return the links or objects of a pair."""
        return self.reduced.owners(pair)

    def pair_name(self, pair: int) -> str:
        """Return the links or objects of a pair as one text."""
        return " - ".join(self.owners(pair))

    @cached_property
    def owner_pairs(self) -> Ints:
        """Index of the unordered pair of links or objects of each pair, shape (p,)."""
        numbers: dict[str, int] = {}
        owner = np.array(
            [numbers.setdefault(body.owner, len(numbers)) for body in self.reduced.bodies], dtype=np.int64
        )
        return owner[self.first] * len(numbers) + owner[self.second]

    @cached_property
    def strict(self) -> Bools:
        """Whether a pair is always present and its contact never accepted, shape (p,)."""
        return self.always_apart(self.present)

    def always_apart(self, present: Floats | None) -> Bools:
        """Whether contact of each pair is never accepted, shape (p,).

        Args:
            present: Time span in which pairs are examined, shape (p, 2) [s]; always by default.
        """
        strict = np.ones(len(self.first), dtype=np.bool_)
        strict[[pair for pair, _ in self.reduced.pairs.allowances]] = False
        if present is None:
            return strict
        return strict & (present[:, 0] == -np.inf) & (present[:, 1] == np.inf)

    def present_since(self, clock: float) -> Floats | None:
        """Return `present` on a clock that starts at a time of the scene clock [s]."""
        return self.present if self.present is None or clock == 0.0 else self.present - clock

    def uncertainty(self, pair: Ints, distance: Floats, error: float) -> Floats:
        """Return the largest excess of true distances over measured ones of pairs, (i,) each [m].

        It is infinite for an exact mesh in contact, as only its hull was measured.
        """
        hulled = self._meshed[pair] & ~self.planar[pair] & (distance <= 0.0)
        return np.where(hulled, np.inf, 2.0 * error + DOUBTFUL)

    @cached_property
    def _meshed(self) -> Bools:
        meshes = np.array([isinstance(body.shape, Mesh) for body in self.reduced.bodies], dtype=np.bool_)
        return meshes[self.first] | meshes[self.second]

    @property
    def calls(self) -> int:
        """Number of measured distances."""
        return self.core.calls

    def measure(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure signed distances minus their reserve, shape (i,) [m].

        Args:
            cell: Configuration of each measurement, shape (i,).
            pair: Pair of each measurement, shape (i,).
        """
        return self.core.measure(*_placed(poses), cell, pair)

    def measure_hulls(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure pairs without half-spaces, with hulls in place of meshes; see `measure`."""
        return self.core.measure_hulls(*_placed(poses), cell, pair)

    def search_depths(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure pairs by a search of all directions: slow, but correct where Coal's depth is not.

        Returns:
            Lower bounds of the distances, for exact meshes between their hulls, shape (i,) [m]; minus
            infinity for half-spaces.
        """
        return self.core.search_depths(*_placed(poses), cell, pair)

    def nearest(self, poses: Poses) -> Floats:
        """Measure, in the first configuration, every pair that may touch or be the nearest strict one.

        Returns:
            Infinite for the others, shape (p,) [m].
        """
        return self.core.nearest(*_placed(poses), self.strict)


def _placed(poses: Poses) -> tuple[Floats, Floats, Floats]:
    times = np.zeros(len(poses.rotation)) if poses.times is None else poses.times
    return np.ascontiguousarray(times), poses.rotation, poses.translation


class Surroundings:
    """Workspace for distances in a static scene and among dynamic obstacles; one per thread."""

    def __init__(self, kinematics: Kinematics, options: VerifyOptions) -> None:
        self.still = self.distances = PairDistances(kinematics, error=options.distance_error)
        self._timed: TimedModel | None = kinematics.reduced.timed
        self._kinematics = kinematics
        if self._timed is not None:
            self._kinematics = Kinematics(self._timed.reduced)
            self.distances = PairDistances(
                self._kinematics, error=options.distance_error, timings=self._timed.timings
            )

    def among(self, motion: JudgedMotion, staying: float = 0.0, clock: float = 0.0) -> JudgedMotion:
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
        scene = self._kinematics.reduced.scene
        objects, error = scene.objects, scene.model_error
        stated = [f"the robot differs from its description by no more than {error}"] * (str(error) != "none")
        stated += [phrase for item in objects.values() for phrase in item.given]
        stated += [f"{name} {_as_said(timing)}" for name, timing in self.timings.items()]
        return tuple(f"proven given that {phrase}" for phrase in stated)

    @property
    def timings(self) -> Mapping[str, Timing]:
        return {} if self._timed is None else self._timed.timings


def _as_said(timing: Timing) -> str:
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
