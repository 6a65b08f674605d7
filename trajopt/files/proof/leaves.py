"""Search for the leaves of a proof."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import coal
import numpy as np
from numpy.typing import NDArray

from trajopt.files.proof.pairs import BodyPart, Pairs
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.values.errors import ProblemError
from trajopt.values.shapes.shapes import Mesh
from trajopt.verify.kernel.kinematics import Poses
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.shapes import coal_geometry, hull_of

Directions = NDArray[np.int16]
FINEST = 32_767
"""Numbers of a direction are whole, and at most this."""
SHORTEST = 1e-5
"""Shorter intervals are not cut [s]."""
SHORTEST_OF_CLOUDS = 5e-3
"""Likewise for parts around several points of a cloud, which are cut instead [s]."""
MOST_PARTS = 5_000
SURE = 1.0 + 1e-6
"""Factor on bounds that covers the checker's rounding."""
SLACK = 1e-9
"""Likewise, added to distances [m]."""


@dataclass(frozen=True, eq=False)
class Leaves:
    """Intervals of pairs, each with a direction (l, 3) in the frame of the last joint that carries both."""

    pair: Ints
    begin: Floats
    end: Floats
    direction: Directions

    def take(self, which: Bools) -> "Leaves":
        return Leaves(self.pair[which], self.begin[which], self.end[which], self.direction[which])

    def beside(self, kept: Bools, others: "Leaves") -> "Leaves":
        """Return the leaves of kept pairs, renumbered, followed by the leaves of other pairs."""
        few = self.take(kept[self.pair])
        return Leaves(
            np.concatenate((np.cumsum(kept)[few.pair] - 1, others.pair + np.count_nonzero(kept))),
            np.concatenate((few.begin, others.begin)),
            np.concatenate((few.end, others.end)),
            np.concatenate((few.direction, others.direction)),
        )


def separated(motion: JudgedMotion, pairs: Pairs) -> tuple[Pairs, Leaves, Leaves]:
    """Search for leaves, cutting parts around clouds if needed; return pairs, leaves and failed intervals."""
    leaves, lost = LeafSearch(motion, pairs).search()
    while coarse := pairs.coarse(set(lost.pair.tolist())):
        finer, kept = pairs.cut(coarse)
        if len(finer.parts) > MOST_PARTS:
            raise ProblemError(f"a proof has at most {MOST_PARTS} convex parts: the clouds need more")
        more = LeafSearch(motion, finer).search()
        leaves, lost = leaves.beside(kept, more[0]), lost.beside(kept, more[1])
        pairs = replace(
            finer,
            pairs=np.concatenate((pairs.pairs[kept], finer.pairs)),
            required=np.concatenate((pairs.required[kept], finer.required)),
        )
    return pairs, leaves, lost


class LeafSearch:
    """Search for leaves along one motion.

    An interval of length h is a leaf if a direction separates the parts at both ends by more than the
    clearance and u h^2 / 8, where u bounds the accelerations of both.
    """

    def __init__(self, motion: JudgedMotion, stated: Pairs) -> None:
        parts, pairs = stated.parts, stated.pairs
        self._motion, self._parts, self._pairs, self._required = motion, parts, pairs, stated.required
        self._growth, self._present = stated.growth, stated.present
        self._driven, self._knots = stated.driven, stated.knots
        arm = motion.kinematics
        count = len(arm.parents)
        self._carried = np.zeros((count, count), dtype=np.bool_)
        for joint in range(count):
            self._carried[joint, [0, *arm.chain(joint)]] = True
        self._joint = np.array([part.body.joint for part in parts], dtype=np.int64)
        both = self._carried[self._joint[pairs[:, 0]]] & self._carried[self._joint[pairs[:, 1]]]
        self.seen: Ints = count - 1 - np.argmax(both[:, ::-1], axis=1)
        self._half_spaces = [number for number, part in enumerate(parts) if part.is_half_space]
        spheres = [(np.zeros(3), 0.0) if part.is_half_space else part.sphere for part in parts]
        self._centre = np.array([centre for centre, _ in spheres]).reshape(-1, 3)
        self._radius = np.array([radius for _, radius in spheres])
        self._shapes = [_coal_shape(part) for part in parts]
        divisible = np.array([part.divisible for part in parts], dtype=np.bool_)
        self._coarse: Bools = divisible[pairs[:, 0]] | divisible[pairs[:, 1]]
        self._shortest = np.where(self._coarse, SHORTEST_OF_CLOUDS, SHORTEST)
        self._given_up = np.zeros(len(pairs), dtype=np.bool_)

    def search(self) -> tuple[Leaves, Leaves]:
        pair, begin, end = self._first()
        found, given_up = list[Leaves](), list[Leaves]()
        while len(pair):
            leaves, holds = self._decide(pair, begin, end)
            found.append(leaves.take(holds))
            pair, begin, end = pair[~holds], begin[~holds], end[~holds]
            short = (end - begin < self._shortest[pair]) | self._given_up[pair]
            if short.any():
                lost = np.isin(leaves.pair, pair[short])
                given_up.append(leaves.take(lost & ~holds))
                keep = ~np.isin(pair, pair[short])
                pair, begin, end = pair[keep], begin[keep], end[keep]
            middle = self._middle(begin, end)
            pair = np.repeat(pair, 2)
            begin, end = np.stack((begin, middle), 1).ravel(), np.stack((middle, end), 1).ravel()
        return _ordered(found), _ordered(given_up)

    def _first(self) -> tuple[Ints, Floats, Floats]:
        duration = self._motion.duration
        cuts = [
            np.unique(
                np.clip((0.0, duration, *here, *self._knots[: len(self._knots) * moves]), 0.0, duration)
            )
            for here, moves in zip(self._present, self._driven, strict=True)
        ]
        pair = np.repeat(np.arange(len(cuts)), [len(each) - 1 for each in cuts])
        sides = [
            np.concatenate([np.zeros(0), *(each[side] for each in cuts)])
            for side in (slice(-1), slice(1, None))
        ]
        return pair, sides[0], sides[1]

    def _middle(self, begin: Floats, end: Floats) -> Floats:
        times, middle = self._motion.trajectory.times, (begin + end) / 2.0
        place = np.clip(np.searchsorted(times, middle), 1, len(times) - 1)
        near = np.where(middle - times[place - 1] < times[place] - middle, times[place - 1], times[place])
        return np.where((near > begin) & (near < end), near, middle)

    def _decide(self, pair: Ints, begin: Floats, end: Floats) -> tuple[Leaves, Bools]:
        first, second, seen = self._pairs[pair, 0], self._pairs[pair, 1], self.seen[pair]
        times = np.unique(np.concatenate((begin, end, (begin + end) / 2.0)))
        ends = np.searchsorted(times, begin), np.searchsorted(times, end)
        middle = np.searchsorted(times, (begin + end) / 2.0)
        poses = self._motion.poses(times)
        turned = np.einsum("cwij,wj->cwi", poses.rotation[:, self._joint], self._centre)
        centres = turned + poses.translation[:, self._joint]
        needed = self._off_chord(poses, centres, first, second, seen, ends, begin, end)
        error = (self._growth[pair] * np.stack((np.ones(len(end)), end, end**2 / 2.0), axis=1)).sum(axis=1)
        needed = (needed + self._required[pair] + error) * SURE + SLACK
        appears, expires = self._present[pair].T
        absent = (end <= appears) | (begin >= expires)
        apart = centres[middle, second] - centres[middle, first]
        direction = self._rounded(poses, apart, middle, seen, first, second)
        holds = (self._gap(poses, first, second, seen, ends, direction) > needed) | absent
        hopeful = ~holds & (np.linalg.norm(apart, axis=1) > needed)
        for row in np.flatnonzero(hopeful).tolist():
            found = self._normal(poses, int(middle[row]), int(first[row]), int(second[row]))
            self._given_up[pair[row]] |= found is None and self._coarse[pair[row]]
            apart[row] = apart[row] if found is None else found
        better = self._rounded(poses, apart, middle, seen, first, second)
        direction = np.where(hopeful[:, None], better, direction)
        holds |= self._gap(poses, first, second, seen, ends, direction) > needed
        return Leaves(pair, begin, end, direction), holds

    def _rounded(
        self, poses: Poses, apart: Floats, time: Ints, seen: Ints, first: Ints, second: Ints
    ) -> Directions:
        local = np.einsum("cij,ci->cj", poses.rotation[time, seen], apart)
        for side, sign in ((first, 1.0), (second, -1.0)):
            for number in self._half_spaces:
                local[side == number] = sign * self._parts[number].body.placement.rotation[:, 2]
        largest = np.maximum(np.abs(local).max(axis=1, initial=0.0), 1e-12)
        rounded = np.rint(local * (FINEST / largest[:, None])).astype(np.int16)
        rounded[~rounded.any(axis=1), 2] = FINEST
        return rounded

    def _gap(
        self,
        poses: Poses,
        first: Ints,
        second: Ints,
        seen: Ints,
        ends: tuple[Ints, Ints],
        direction: Directions,
    ) -> Floats:
        unit = direction / np.linalg.norm(direction, axis=1)[:, None]
        gaps: list[Floats] = []
        for time in ends:
            world = np.einsum("cij,cj->ci", poses.rotation[time, seen], unit)
            sides = self._support(poses, first, time, world), self._support(poses, second, time, -world)
            gaps.append(-(sides[0] + sides[1]))
        return np.minimum(*gaps)

    def _support(self, poses: Poses, side: Ints, time: Ints, direction: Floats) -> Floats:
        joint = self._joint[side]
        local = np.einsum("cij,ci->cj", poses.rotation[time, joint], direction)
        found = np.einsum("ci,ci->c", direction, poses.translation[time, joint])
        for number in np.unique(side):
            rows = side == number
            found[rows] += self._parts[int(number)].support(local[rows])
        return found

    def _off_chord(
        self,
        poses: Poses,
        centres: Floats,
        first: Ints,
        second: Ints,
        seen: Ints,
        ends: tuple[Ints, Ints],
        begin: Floats,
        end: Floats,
    ) -> Floats:
        rates = [self._motion.rates(begin, end, order) for order in (1, 2)]
        half = (end - begin) / 2.0
        axes = np.einsum("cjik,jk->cji", poses.rotation, self._motion.kinematics.axes)
        sizes = [
            self._acceleration(poses, centres, axes, side, seen, ends, half, rates)
            for side in (first, second)
        ]
        return (sizes[0] + sizes[1]) * half**2 / 2.0

    def _acceleration(
        self,
        poses: Poses,
        centres: Floats,
        axes: Floats,
        side: Ints,
        seen: Ints,
        ends: tuple[Ints, Ints],
        half: Floats,
        rates: Sequence[Floats],
    ) -> Floats:
        v, u = np.zeros(len(side)), np.zeros(len(side))
        for joint in range(len(axes[0]) - 1, 0, -1):
            moves = self._carried[self._joint[side], joint] & ~self._carried[seen, joint]
            if not moves.any():
                continue
            w, a = rates[0][:, joint] * moves, rates[1][:, joint] * moves
            if not self._motion.kinematics.revolute[joint]:
                v, u = v + w, u + a
                continue
            levers = [
                np.linalg.norm(
                    np.cross(centres[time, side] - poses.translation[time, joint], axes[time, joint]), axis=1
                )
                for time in ends
            ]
            r = np.maximum(*levers) + self._radius[side] + v * half
            u, v = u + 2.0 * w * v + (w * w + a) * r, v + w * r
        return u

    def _normal(self, poses: Poses, time: int, first: int, second: int) -> Floats | None:
        """Return the difference of the nearest points of two parts; None if the parts meet."""
        sides = [self._shapes[first], self._shapes[second]]
        places: list[coal.Transform3s] = []
        for part in (self._parts[first], self._parts[second]):
            joint, where = part.body.joint, part.body.placement
            turn = poses.rotation[time, joint]
            places.append(
                coal.Transform3s(
                    turn @ where.rotation, turn @ (where * part.middle) + poses.translation[time, joint]
                )
            )
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        distance = coal.distance(sides[0], places[0], sides[1], places[1], request, result)
        found = np.asarray(result.getNearestPoint2()) - np.asarray(result.getNearestPoint1())
        return found if distance > 0.0 and np.isfinite(found).all() and found.any() else None


def _coal_shape(part: BodyPart) -> coal.CollisionGeometry:
    shape = part.body.shape
    if len(part.inside):
        x, y, z = np.ptp(part.vertices, axis=0).tolist()
        box = coal.Box(x, y, z)
        box.setSweptSphereRadius(part.radius)
        return box
    return coal_geometry(hull_of(shape) if isinstance(shape, Mesh) else shape)


def _ordered(found: Sequence[Leaves]) -> Leaves:
    every = Leaves(
        np.concatenate([np.zeros(0, dtype=np.int64), *(each.pair for each in found)]),
        np.concatenate([np.zeros(0), *(each.begin for each in found)]),
        np.concatenate([np.zeros(0), *(each.end for each in found)]),
        np.concatenate([np.zeros((0, 3), dtype=np.int16), *(each.direction for each in found)]),
    )
    order = np.lexsort((every.begin, every.pair))
    return Leaves(every.pair[order], every.begin[order], every.end[order], every.direction[order])
