"""Search for the joint path that gets farthest along a curve."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from trajopt.geometry import evaluator
from trajopt.optimise.kinematics.inverse import goal_candidates
from trajopt.optimise.transcription.knots import CLEARANCE_TOLERANCE
from trajopt.optimise.transcription.margins import TaperedMargins, tapered_margins
from trajopt.planning.infeasibility import reasons
from trajopt.planning.status import Status
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement, axis_alignment, frame_placement
from trajopt.robot.joints import LimitKind, drawing_range, joint_unit
from trajopt.tasks.cartesian.program import knot_stations, on_the_curve
from trajopt.tasks.cartesian.result import StopReason
from trajopt.tasks.cartesian.tracking import FARTHEST, CurveTrack, OnCurve, resampled, stations_of, track
from trajopt.values.arrays import Bools, Floats, Ints, readonly
from trajopt.values.printed import in_axis, in_joint_position, in_number, in_unit

LEAST = 1e-4
"""Smallest part of a curve returned as a motion."""
POSTURES = 3
"""Random postures as targets of the drift of an arm with several redundant joints."""
FREEST = 1e-3
"""Paths whose lengths differ by less than this share of the curve are compared by joint motion."""


@dataclass(frozen=True, eq=False)
class Found:
    """A joint path along a curve.

    Attributes:
        stop: The reason for its end; None at the end of the curve.
    """

    way: CurveTrack
    stop: StopReason | None


@dataclass(frozen=True, eq=False)
class CurveSearch:
    """Searches joint paths along a curve."""

    problem: Problem
    on_curve: OnCurve
    rng: np.random.Generator

    def tracked(self, starts: Floats) -> Found:
        return self._best(track(self.on_curve, stations_of(self.on_curve), starts, _still(starts)))

    def looking_ahead(self, starts: Floats, tracked: Found) -> Found:
        """Use redundant joints to get farther than tracking."""
        on_curve, stations = self.on_curve, stations_of(self.on_curve)
        found = [tracked]
        if on_curve.spare == 1:
            margin = start_margins(on_curve, starts)
            found.append(self._onward(SelfMotions(on_curve, margin).farthest(stations, starts)))
        else:
            limits = self.problem.reduced.limits
            low, high = drawing_range(limits)
            for posture in ((low + high) / 2.0, *self.rng.uniform(low, high, (POSTURES, len(low)))):
                drifting = np.tile(posture, (len(starts), 1))
                found.append(self._best(track(on_curve, stations, starts, drifting)))
                if found[-1].stop is None:
                    break
        return max(found, key=lambda item: item.way.reached)

    def _onward(self, way: CurveTrack) -> Found:
        stations = stations_of(self.on_curve)
        rest = np.append(way.reached, stations[stations > way.reached])
        last = way.positions[-1:]
        (more,) = track(self.on_curve, rest, last, _still(last))
        stations = np.concatenate((way.stations, more.stations[1:]))
        return self._best([CurveTrack(stations, np.concatenate((way.positions, more.positions[1:])))])

    def _best(self, tracks: list[CurveTrack]) -> Found:
        found: list[Found] = []
        for each in tracks:
            clear = clear_part(self.on_curve, each)
            found.append(Found(self._shortened(each, clear.until), clear.stop))
        length = self.on_curve.required.until
        velocity = self.problem.limits.velocity

        def rank(item: Found) -> tuple[float, float]:
            travel = np.abs(np.diff(item.way.positions, axis=0)) / velocity
            return round(item.way.reached / length / FREEST), -float(travel.sum(axis=0).max())

        best = max(found, key=rank)
        return Found(best.way, best.stop or untracked(self.on_curve, best.way, self.rng))

    def _shortened(self, way: CurveTrack, until: float) -> CurveTrack:
        if until >= way.reached:
            return way
        kept = way.until(until)
        if until - kept.reached < LEAST * self.on_curve.required.until:
            return kept
        stations = np.append(kept.stations, until)
        return resampled(self.on_curve, way, stations)

    def as_program(self, found: Found) -> Found:
        """Plan a path as one program; return the result if it gets equally far."""
        way, required = found.way, self.on_curve.required
        if way.reached < LEAST * required.until:
            return found
        part = replace(required, until=way.reached)
        on_part = self.on_curve.along(part)
        problem = replace(beginning(self.problem, way), goal=part)
        with on_part.stage("track"):
            seed = resampled(on_part, way, knot_stations(part))
        solved = on_the_curve(problem, part, seed, on_part.tracker)
        with on_part.stage("track"):
            planned = _continuous(on_part, CurveTrack(seed.stations, solved.x))
            clear = clear_part(on_part, planned)
        if clear.stop is not None or planned.reached < way.reached:
            return found
        return Found(planned, found.stop)


def beginning(problem: Problem, way: CurveTrack) -> Problem:
    return replace(problem, start=readonly(problem.reduced.all_positions(way.positions[0])))


def _still(starts: Floats) -> Floats:
    return np.full_like(starts, np.nan)


def _continuous(on_curve: OnCurve, planned: CurveTrack) -> CurveTrack:
    stations = stations_of(on_curve)
    dense = resampled(on_curve, planned, stations)
    there = on_curve(dense.positions, stations)
    moved = np.abs(np.diff(dense.positions, axis=0)).max(axis=1)
    good = there.held & (np.append(0.0, moved) <= 2.0 * FARTHEST)
    good[0] = True
    kept = len(good) if good.all() else int(np.argmin(good))
    return CurveTrack(stations[:kept], dense.positions[:kept])


CONE = 1e-4
"""Alignment of the axis of a free spin before Newton's method takes over [rad]."""


def beginnings(on_curve: OnCurve, *, most: int, rng: np.random.Generator) -> Floats | StopReason:
    """Search clear first configurations of the curve, nearest to the start first, shape (b, n)."""
    counts, wanted = on_curve.query.counts, _at_beginning(on_curve)
    found = goal_candidates(
        evaluator(on_curve.reduced, counts),
        wanted,
        rng=rng,
        check=lambda: on_curve.tracker.check(counts),
    )
    if found.free:
        drawn = np.array(found.free[:most])
        exact = on_curve(drawn, np.zeros(len(drawn)))
        if exact.held.any():
            return exact.positions[exact.held]
    status = Status.NO_INVERSE_KINEMATICS if found.blocking is None else Status.GOAL_IN_COLLISION
    why = "the configurations found need more torque to rest than the limits allow"
    if not found.overloaded:
        why = reasons.no_goal_configuration(on_curve.reduced, found, wanted)
    return stop_reason(on_curve, status, 0.0, f"at the beginning of the curve: {why}")


def _at_beginning(on_curve: OnCurve) -> tuple[Requirement, ...]:
    need = on_curve.required
    place = need.curve.placement(0.0)
    turned = need.rotation_tolerance if need.spin is None else np.inf
    placed = frame_placement(
        need.frame,
        place,
        reference=need.reference,
        offset=need.offset,
        position_tolerance=need.position_tolerance,
        rotation_tolerance=turned,
    )
    if need.spin is None or np.isinf(need.rotation_tolerance):
        return (placed,)
    direction = place.rotation @ need.spin
    return (
        placed,
        axis_alignment(
            need.frame, axis=need.spin, direction=direction, reference=need.reference, tolerance=CONE
        ),
    )


SPACING = 0.12
"""Distance of the stored configurations of one point [rad | m]."""
SAME = 0.06
"""Configurations closer than this in every joint are equal [rad | m]."""
STEP = 0.3
"""Largest joint motion between consecutive points without self-motion [rad | m]."""
JOINED = 0.5
"""Largest joint motion between consecutive points with self-motion [rad | m]."""
MOST = 400
"""Most configurations of a point."""


@dataclass(frozen=True, eq=False)
class SelfMotions:
    """Explores all self-motions along a curve.

    Attributes:
        margin: Clearance of each pair, shape (p,) [m].
    """

    on_curve: OnCurve
    margin: Floats

    def farthest(self, stations: Floats, starts: Floats) -> CurveTrack:
        """Return the sequence of least motion to the last reachable point.

        Args:
            starts: First configurations, shape (b, n); they are kept until the second point.
        """
        layers = [starts]
        found = self._spread(starts, float(stations[0]))
        for s in stations[1:].tolist():
            moved = self.on_curve(found, np.full(len(found), s))
            near = np.abs(moved.positions - found).max(axis=1, initial=0.0) <= STEP
            found = self._spread(self._clear(moved.positions[moved.held & near]), s)
            if len(found) == 0:
                break
            layers.append(found)
        return CurveTrack(stations[: len(layers)], _least_motion(layers))

    def _clear(self, q: Floats) -> Floats:
        if len(q) == 0:
            return q
        blocked = np.zeros(len(q), dtype=np.bool_)
        blocked[self.on_curve.query.close_pairs(q, self.margin).sample] = True
        return q[~blocked]

    def _spread(self, seeds: Floats, s: float) -> Floats:
        kept = np.empty((0, len(self.on_curve.limits.joint_names)))
        front = _new(seeds, kept)
        while len(front) and len(kept) < MOST:
            kept = np.concatenate((kept, front))
            step = SPACING * self.on_curve.free_direction(front, np.full(len(front), s))
            tried = np.concatenate((front + step, front - step))
            moved = self.on_curve(tried, np.full(len(tried), s))
            near = np.abs(moved.positions - tried).max(axis=1) < 0.5 * SPACING
            front = _new(self._clear(moved.positions[moved.held & near]), kept)
        return kept


def _new(q: Floats, kept: Floats) -> Floats:
    apart: Bools = ~(np.abs(q[:, None] - kept).max(axis=2, initial=0.0) < SAME).any(axis=1)
    fresh: list[int] = []
    for row in np.flatnonzero(apart):
        if not (np.abs(q[fresh] - q[row]).max(axis=1, initial=0.0) < SAME).any():
            fresh.append(int(row))
    return q[fresh]


def _least_motion(layers: list[Floats]) -> Floats:
    """Choose one configuration of each layer so that the sum of squared steps is least, shape (m, n)."""
    cost, came_from = np.zeros(len(layers[0])), list[Ints]()
    for before, after in pairwise(layers):
        steps = after[None] - before[:, None]
        far = np.abs(steps).max(axis=2) > JOINED
        total = cost[:, None] + (steps**2).sum(axis=2) + np.where(far, 1e6, 0.0)
        came_from.append(total.argmin(axis=0).astype(np.int64))
        cost = total.min(axis=0)
    chosen = [int(cost.argmin())]
    for origins in reversed(came_from):
        chosen.append(int(origins[chosen[-1]]))
    return np.array([layer[row] for layer, row in zip(layers, reversed(chosen), strict=True)])


LOOK_AHEAD = 0.02
"""Distance beyond the last point in which the reason is searched [m]."""
STEPS_AHEAD = 8
"""Steps of that search."""
SEARCHES = 96
"""Random configurations for the search of another branch."""
ZOOMS = 7
"""Bisections that locate a violation between two stations."""
CAUTIOUS = 0.1
"""Assumed tool speed for time windows of intended contact [m/s]."""


@dataclass(frozen=True, eq=False)
class Clear:
    """The part of a track with sufficient clearance.

    Attributes:
        until: Last clear length along the curve [m].
        stop: The violated pair beyond it; None if the whole track is clear.
    """

    until: float
    stop: StopReason | None


@dataclass(frozen=True, eq=False)
class _Blocked:
    sample: int
    pair: int
    distance: float
    margin: float


def clear_part(on_curve: OnCurve, found: CurveTrack) -> Clear:
    """Find the part of a track on which every pair keeps its margin, reduced near the start."""
    margin = _margins(on_curve, found)
    s, q = found.stations, found.positions
    blocked = _first_blocked(on_curve, q, np.arange(len(s), dtype=np.float64), margin)
    if blocked is None:
        return Clear(found.reached, None)
    after = blocked.sample
    if after == 0:
        return Clear(0.0, _collision(on_curve, 0.0, blocked))
    low, high = 0.0, 1.0
    for _ in range(ZOOMS):
        share = (low + high) / 2.0
        estimate = (1.0 - share) * q[after - 1] + share * q[after]
        there = on_curve(estimate[None], np.array((s[after - 1] + share * (s[after] - s[after - 1]),)))
        hit = _first_blocked(on_curve, there.positions, np.array((after - 1 + share,)), margin)
        low, high = (share, high) if hit is None else (low, share)
        blocked = hit or blocked
    until = float(s[after - 1] + low * (s[after] - s[after - 1]))
    return Clear(until, _collision(on_curve, until, blocked))


def _margins(on_curve: OnCurve, found: CurveTrack) -> TaperedMargins:
    query = on_curve.query
    goal: Floats | None = None
    if found.reached >= on_curve.required.until:
        touched = query.close_pairs(found.positions[-1:], query.reduced.pairs.required)
        goal = found.positions[-1] if len(touched.distance) == 0 else None
    return tapered_margins(query, max(len(found.stations), 2), goal, found.reached / CAUTIOUS)


def start_margins(on_curve: OnCurve, starts: Floats) -> Floats:
    margin = on_curve.reduced.pairs.margin - CLEARANCE_TOLERANCE
    contacts = on_curve.query.close_pairs(starts, margin)
    np.minimum.at(margin, contacts.pair, contacts.distance - CLEARANCE_TOLERANCE)
    required = on_curve.reduced.pairs.required
    return np.where(required > 0.0, np.maximum(margin, required), margin)


def _first_blocked(
    on_curve: OnCurve, positions: Floats, places: Floats, margin: TaperedMargins
) -> _Blocked | None:
    contacts = on_curve.query.close_pairs(positions, on_curve.reduced.pairs.margin)
    asked = margin(contacts.pair, places[contacts.sample])
    short = asked - contacts.distance
    required = on_curve.reduced.pairs.required[contacts.pair]
    undercut = (required > 0.0) & (contacts.distance < np.minimum(required, asked))
    bad = np.flatnonzero((short > CLEARANCE_TOLERANCE) | undercut)
    if len(bad) == 0:
        return None
    sample = int(contacts.sample[bad].min())
    here = bad[contacts.sample[bad] == sample]
    worst = int(here[short[here].argmax()])
    return _Blocked(sample, int(contacts.pair[worst]), float(contacts.distance[worst]), float(asked[worst]))


def _collision(on_curve: OnCurve, s: float, blocked: _Blocked) -> StopReason:
    first, second = on_curve.reduced.owners(blocked.pair)
    required = float(on_curve.reduced.pairs.required[blocked.pair])
    kept = f"{blocked.margin * 1000.0:.1f} mm are required"
    if blocked.margin > required + CLEARANCE_TOLERANCE:
        kept = f"{blocked.margin * 1000.0:.1f} mm are kept along a curve, "
        kept += (
            f"{required * 1000.0:.3g} mm required and a margin"
            if required
            else "as a margin: Scene.with_margin lowers it"
        )
    return stop_reason(
        on_curve,
        Status.COLLISION,
        s,
        f"{first} comes within {blocked.distance * 1000.0:.1f} mm of {second}; {kept}",
        pair=(first, second),
        amount=blocked.margin - blocked.distance,
    )


def untracked(on_curve: OnCurve, found: CurveTrack, rng: np.random.Generator) -> StopReason | None:
    """Return why a track ends before the curve; None if it does not."""
    s, until = found.reached, on_curve.required.until
    if s >= until:
        return None
    ahead = np.linspace(s, min(s + LOOK_AHEAD, until), STEPS_AHEAD + 1)
    q = found.positions[-1]
    (beyond,) = track(on_curve.without_limits(), ahead, q[None], np.full((1, len(q)), np.nan))
    limits = on_curve.reduced.limits
    excess = np.maximum(beyond.positions - limits.upper, limits.lower - beyond.positions)
    broken = np.flatnonzero((excess > 0.0).any(axis=1))
    if len(broken):
        joint = int(excess[broken[0]].argmax())
        name = limits.joint_names[joint]
        at = float(beyond.positions[broken[0], joint])
        over = at > limits.upper[joint]
        side, limit = (LimitKind.UPPER, limits.upper) if over else (LimitKind.LOWER, limits.lower)
        unit = joint_unit(on_curve.reduced.scene.robot.model, name)
        text = f"{name} is at its {side.value} limit of {in_joint_position(float(limit[joint]), unit)}"
        text += f"{limits.because(name, side)}, and the curve needs {in_joint_position(at, unit)} and more"
        return stop_reason(on_curve, Status.JOINT_LIMIT, s, text, joint=name, amount=float(limit[joint]))
    low, high = drawing_range(limits)
    drawn = np.vstack((q[None], rng.uniform(low, high, (SEARCHES, len(low)))))
    other = on_curve(drawn, np.full(len(drawn), ahead[1]))
    singular = float(on_curve.smallest_singular_value(q[None], np.array((s,)))[0])
    if other.held.any():
        jumps = np.abs(other.positions[other.held] - q)
        nearest = jumps[int(jumps.max(axis=1).argmin())]
        joint = int(nearest.argmax())
        name = limits.joint_names[joint]
        jump = in_unit(float(nearest[joint]), joint_unit(on_curve.reduced.scene.robot.model, name))
        text = (
            f"{name} would have to jump by {jump}; "
            f"the smallest singular value of the Jacobian is {singular:.2g}"
        )
        return stop_reason(on_curve, Status.BRANCH_JUMP, s, text, joint=name, amount=float(nearest[joint]))
    text = _lacking(on_curve, q, s, float(ahead[1])) or (
        f"no configuration holds the curve there; the smallest singular value is {singular:.2g}"
    )
    return stop_reason(on_curve, Status.OUT_OF_REACH, s, text)


PART = 0.02
"""A smaller share of a missing motion is not named."""


def _lacking(on_curve: OnCurve, positions: Floats, s: float, ahead: float) -> str:
    found = on_curve.lacking(positions, s, ahead)
    if found is None:
        return ""
    along, about = found
    sizes = [float(np.linalg.norm(each)) for each in found]
    joints = in_number(on_curve.limits.joint_names, "joint", "joints")
    frame, turns = on_curve.required.frame, f"about {in_axis(about / max(sizes[1], PART))}"
    moves = f"along {in_axis(along / max(sizes[0], PART))}"
    if min(sizes) > PART:
        turns = f"about {in_axis(-about / sizes[1])}"
        text = f"with its {joints} the arm moves {frame} {moves} of its axes only while it turns {turns}"
    else:
        motion = f"turn {frame} {turns}" if sizes[1] > PART else f"move {frame} {moves}"
        text = f"the curve needs the arm to {motion} of its axes there, which its {joints} cannot"
    if sizes[1] <= PART:
        return text
    return f"{text}; {'spin or ' * (on_curve.required.spin is None)}rotation_tolerance frees its rotation"


def stop_reason(
    on_curve: OnCurve,
    status: Status,
    s: float,
    message: str,
    *,
    joint: str | None = None,
    pair: tuple[str, str] | None = None,
    amount: float = 0.0,
) -> StopReason:
    pose = on_curve.required.curve.pose_before(s)
    return StopReason(status=status, at=s, pose=pose, message=message, joint=joint, pair=pair, amount=amount)
