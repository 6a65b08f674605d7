"""The check of a motion: own kinematics, Coal on the bodies as they are, a millimetre between two looks."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import coal
import numpy as np
from scipy.interpolate import BPoly

import trajopt as to
from tests.fuzz.random_problems.case import Case, Contact
from tests.fuzz.random_problems.chain import Placed
from tests.fuzz.random_problems.load import torques
from trajopt.values.arrays import Floats

SLACK = 1e-6
"""What rounding may cost [m, rad, and their share of a speed]."""
STEP = 1e-3
"""How far a point moves between two looks [m]."""
MOST_LOOKS = 40_000
RESOLUTION = 2e-6
"""Clearance that a claim may be off by: the judge takes a micrometre for safety [m]."""
HULLS, OWN_HULLS = 0.03, 0.008
"""What the hulls that stand for a robot's meshes may add, to things and among its links [m]."""
MEANT = 0.03
"""A known motion may be in a contact that is meant while no point has moved farther than this [m]."""


@dataclass(frozen=True, eq=False)
class Timed:
    """A motion at its looks: positions (t, n), when each is [s] (none: a path without time), travel [m]."""

    positions: Floats
    times: Floats | None
    travel: Floats


def fault_of_trajectory(case: Case, motion: to.Trajectory, *, step: float = STEP) -> str:
    """Return the first thing that is wrong with a motion, in words; empty if nothing is."""
    chain = case.arm.chain
    if sorted(motion.joint_names) != sorted(chain.driven):
        return f"moves {motion.joint_names}, not {chain.driven}"
    order = [motion.joint_names.index(name) for name in chain.driven]
    curve = _polynomials(motion, order)
    end = float(motion.times[-1])
    inner = np.linspace(0.0, 1.0, 12, endpoint=False)
    fine = np.append((motion.times[:-1, None] + np.diff(motion.times)[:, None] * inner).ravel(), end)
    fault = _fault_of_limits(case, curve, fine) or _fault_of_ends(case, curve, end)
    if fault:
        return fault
    looks, travel = _looks(case, curve(fine), fine, step)
    return _fault_on_the_way(case, Timed(curve(looks), looks, travel))


def fault_of_path(
    case: Case, corners: Floats, *, step: float = STEP, spare: float = 0.0, only: str = ""
) -> str:
    """Return what is wrong with a polyline that may be run as slowly as one likes; empty if nothing is.

    Args:
        case: What is asked.
        corners: Shape (k, n) [rad | m].
        step: How far a point moves between two looks [m].
        spare: Clearance demanded beyond what is required [m].
        only: Look at the pairs of this owner only; at all of them where it is empty.
    """
    parts = [np.linspace(first, last, 50) for first, last in pairwise(corners)]
    fine = np.concatenate(parts)
    looks, travel = _looks(case, fine, np.arange(len(fine), dtype=float), step)
    positions = np.stack([np.interp(looks, np.arange(len(fine)), column) for column in fine.T], axis=1)
    if np.abs(positions[0] - case.start).max() > SLACK:
        return "does not begin at the start"
    if case.arm.chain.excess_of_limits(positions) > 0.0:
        return "leaves the limits"
    return _fault_at_goal(case, positions[-1:]) or _fault_on_the_way(
        case, Timed(positions, None, travel), spare, only
    )


def spare_of(case: Case) -> float:
    """Return the clearance beyond what is required that shows beyond doubt that a case is held [m]."""
    return HULLS if any(item.body.kind == "mesh" for item in case.arm.chain.bodies) else RESOLUTION


def fault_of_configuration(case: Case, positions: Floats, *, goals: bool, spare: float = 0.0) -> str:
    """Return what is wrong with starting at a configuration (n,); with `goals`, with ending there."""
    meant = tuple(item for item in case.contacts if (item.last if goals else item.first) > 0.0)
    case = replace(case, contacts=meant)
    if case.arm.chain.excess_of_limits(positions[None]) > 0.0:
        return "is outside the limits"
    fault = _fault_at_goal(case, positions[None]) if goals else ""
    still = np.zeros_like(positions[None])
    fault = fault or _fault_of_load(case, (positions[None], still, still), np.zeros(1))
    return fault or _fault_on_the_way(case, Timed(positions[None], None, np.zeros(1)), spare)


def _polynomials(motion: to.Trajectory, order: list[int]) -> BPoly:
    given = [motion.positions, motion.velocities, motion.accelerations]
    columns = [values[:, order] for values in given if values is not None]
    return BPoly.from_derivatives(motion.times, np.stack(columns, axis=1))


def _fault_of_limits(case: Case, curve: BPoly, fine: Floats) -> str:
    chain = case.arm.chain
    positions = curve(fine)
    if not np.isfinite(positions).all():
        return "is not finite"
    excess = chain.excess_of_limits(positions)
    if excess > SLACK:
        return f"leaves the position limits of a joint by {excess:.3g}"
    matrix, _ = chain.follows
    for what, derivative, most in zip(("velocity", "acceleration"), (1, 2), chain.limits(), strict=True):
        values = np.abs(curve(fine, derivative) @ matrix.T)
        over = values - most
        if (over > SLACK * (1.0 + np.abs(values))).any():
            moment, joint = np.unravel_index(int(np.argmax(over)), over.shape)
            name = chain.moving[joint].name
            return f"{what} of {name} beyond its limit by {over.max():.3g} at {fine[moment]:.4f} s"
    return _fault_of_load(case, tuple(curve(fine, derivative) for derivative in range(3)), fine)


def _fault_of_load(case: Case, motion: tuple[Floats, ...], fine: Floats) -> str:
    """Return which joint bears too much, for positions, velocities and accelerations at some times."""
    arm = case.arm
    if not arm.efforts:
        return ""
    borne = np.abs(torques(arm, *motion))
    most = np.array([arm.efforts[name] for name in arm.chain.driven])
    over = borne - most * (1.0 + SLACK)
    if over.max() <= SLACK:
        return ""
    moment, joint = np.unravel_index(int(np.argmax(over)), over.shape)
    return f"{arm.chain.driven[joint]} bears {over.max():.3g} more than it can at {fine[moment]:.4f} s"


def _fault_of_ends(case: Case, curve: BPoly, end: float) -> str:
    if np.abs(curve(0.0) - case.start).max() > SLACK:
        return "does not begin at the start"
    for moment in (0.0, end):
        if np.abs(curve(moment, 1)).max() > SLACK:
            return f"does not rest at {moment:.4f} s"
    return _fault_at_goal(case, curve(np.array((end,))))


def _fault_at_goal(case: Case, positions: Floats) -> str:
    places = case.arm.chain.places(positions)
    for goal in case.goals:
        excess = float(goal.excess(case.arm.chain, positions, places)[0])
        if not excess <= SLACK:
            return f"misses {goal.requirement()} by {excess:.3g}"
    return ""


def _looks(case: Case, fine: Floats, when: Floats, step: float) -> tuple[Floats, Floats]:
    """Return moments such that nothing moves farther than a step between two, and the way to each."""
    lever = 1.05 * case.arm.chain.lever(case.placed())
    far = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(fine, axis=0)) @ lever)))
    count = min(2 + int(far[-1] / step), MOST_LOOKS)
    travel = np.linspace(0.0, far[-1], count)
    rising = far + np.linspace(0.0, 1e-12, len(far))  # interpolation wants it to rise
    return np.interp(travel, rising, when), travel


def _fault_on_the_way(case: Case, motion: Timed, spare: float = 0.0, only: str = "") -> str:
    chain = case.arm.chain
    places = chain.places(motion.positions)
    for item in case.path:
        excess = item.excess(chain, motion.positions, places)
        if not excess.max() <= SLACK:
            return f"breaks {item.requirement()} by {excess.max():.3g}"
    links = {item.owner for item in chain.bodies}
    for first, second in pairs_of(case):
        if only and only not in (first.owner, second.owner):
            continue
        more = min(spare, OWN_HULLS) if {first.owner, second.owner} <= links else spare
        fault = Pair(case, first, second, places).fault(motion, more)
        if fault:
            return fault
    return ""


def pairs_of(case: Case) -> Iterator[tuple[Placed, Placed]]:
    """Return the pairs of bodies that must keep apart and can move against each other."""
    rigid = case.arm.chain.rigid
    for first, second in combinations(case.placed(), 2):
        if first.owner == second.owner or rigid[first.link] == rigid[second.link]:
            continue
        if not case.may_touch(first.owner, second.owner):
            yield first, second


class Pair:
    """Two bodies at the looks of a motion."""

    def __init__(self, case: Case, first: Placed, second: Placed, places: dict[str, Floats]) -> None:
        self.first, self.second = first, second
        self.at = places[first.link] @ first.place, places[second.link] @ second.place
        self.required = case.required_of(first.owner, second.owner)
        owners = {first.owner, second.owner}
        self.meant = [item for item in case.contacts if {item.first_name, item.second_name} == owners]
        self.request, self.result = coal.DistanceRequest(), coal.DistanceResult()
        self.request.gjk_tolerance = 1e-9

    def fault(self, motion: Timed, spare: float) -> str:
        look, count = 0, len(motion.travel)
        wanted = self.required + spare
        while look < count:
            gap = self.gap(look)
            if gap < wanted - SLACK:
                deep = self._excused(motion, look, gap)
                if deep is None or deep:
                    when = "" if motion.times is None else f" at {motion.times[look]:.4f} s"
                    names = f"{self.first.owner} and {self.second.owner}"
                    return f"{names} keep {gap:.7g} of {wanted:g} m{when}{deep or ''}"
                look += 1
                continue
            free = motion.travel[look] + gap - wanted + SLACK
            look = max(look + 1, int(np.searchsorted(motion.travel, free, side="right")) - 1)
        return ""

    def gap(self, look: int) -> float:
        """Distance of the two bodies [m]; negative where they are in each other."""
        one, other = (coal.Transform3s(place[look][:3, :3], place[look][:3, 3]) for place in self.at)
        a, b = self.first.body, self.second.body
        apart = float(np.linalg.norm(self.at[0][look][:3, 3] - self.at[1][look][:3, 3])) - a.radius - b.radius
        if apart > 0.5:
            return apart
        self.result.clear()
        gap = coal.distance(a.geometry, one, b.geometry, other, self.request, self.result)
        if "mesh" in (a.kind, b.kind):
            if gap < 1e-6:
                hit = coal.CollisionResult()
                if coal.collide(a.geometry, one, b.geometry, other, coal.CollisionRequest(), hit):
                    return -1.0
            for body, points, solid, frame in ((a, a.points, b, 1), (b, b.points, a, 0)):
                if solid.kind == "mesh" and solid.closed and body.points is not None:
                    if solid.inside(self._seen(points, 1 - frame, frame, look)[:1])[0]:
                        return -1.0
        return float(gap)

    def _seen(self, points: Floats, owner: int, frame: int, look: int) -> Floats:
        """Return points of one body in the frame of the other."""
        there = np.linalg.inv(self.at[frame][look]) @ self.at[owner][look]
        return points @ there[:3, :3].T + there[:3, 3]

    def _excused(self, motion: Timed, look: int, gap: float) -> str | None:
        """Say nothing where the contact is meant, by how much it is too deep, or None: it is not meant.

        What accuses a motion is the least that the depth can be, what defends a path the most: Coal's.
        """
        meant = [item for item in self.meant if _open(item, motion, look)]
        if not meant:
            return None
        deep = -gap if motion.times is None else self.depth(look)
        most = max(item.depth for item in meant)
        return f", {deep:.6f} m deep" if deep > most + SLACK else ""

    def depth(self, look: int) -> float:
        """At least how deep they are in each other: how far inside one a point of the other is [m]."""
        found = 0.0
        for mine, other in ((0, 1), (1, 0)):
            body, solid = (
                (self.first.body, self.second.body) if mine == 0 else (self.second.body, self.first.body)
            )
            seen = self._seen(body.points, mine, other, look)
            extra = body.sizes[0] if body.kind == "sphere" else 0.0
            found = max(found, *(inner + extra for inner in _inner(solid, seen) if inner > 0.0), 0.0)
        return found


def _inner(solid: object, points: Floats) -> Sequence[float]:
    """How far each point is inside a body [m]; not positive outside."""
    kind, sizes = solid.kind, solid.sizes
    if kind == "box":
        return (np.array(sizes) / 2.0 - np.abs(points)).min(axis=1).tolist()
    if kind == "sphere":
        return (sizes[0] - np.linalg.norm(points, axis=1)).tolist()
    if kind == "cylinder":
        across = sizes[0] - np.linalg.norm(points[:, :2], axis=1)
        return np.minimum(across, sizes[1] / 2.0 - np.abs(points[:, 2])).tolist()
    if not solid.closed:
        return [0.0] * len(points)
    dot, request = coal.Sphere(1e-9), coal.DistanceRequest()
    found: list[float] = []
    for point, inside in zip(points, solid.inside(points), strict=True):
        place = coal.Transform3s(np.eye(3), point)
        gap = coal.distance(solid.geometry, coal.Transform3s(), dot, place, request, coal.DistanceResult())
        found.append(float(gap) if inside else 0.0)
    return found


def _open(item: Contact, motion: Timed, look: int) -> bool:
    """Whether a contact is allowed at a look."""
    if motion.times is None:
        gone, left = motion.travel[look], motion.travel[-1] - motion.travel[look]
        return (item.first > 0 and gone <= MEANT) or (item.last > 0 and left <= MEANT)
    time, end = motion.times[look], motion.times[-1]
    return (item.first > 0 and time <= item.first + SLACK) or (
        item.last > 0 and time >= end - item.last - SLACK
    )
