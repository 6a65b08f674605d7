"""follow(...): from a curve to a timed, judged motion along it, as far as it goes, and why not farther."""

import time
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from trajopt import reasons
from trajopt.arrays import Floats, readonly
from trajopt.cartesian.blocked import clear_part, start_margins, stop, untracked
from trajopt.cartesian.dense import densified, resampled
from trajopt.cartesian.deviate import SIDES, detours
from trajopt.cartesian.on_curve import OnCurve
from trajopt.cartesian.options import Avoid, Begin, FollowOptions
from trajopt.cartesian.program import knot_stations, on_the_curve
from trajopt.cartesian.result import Cause, Followed, Stop
from trajopt.cartesian.self_motion import SelfMotions
from trajopt.cartesian.starts import beginnings
from trajopt.cartesian.timing import timed_along
from trajopt.cartesian.tracking import FARTHEST, Track, stations_of, track
from trajopt.model.requirements import FollowsCurve
from trajopt.model.scene import Scene
from trajopt.problem import Problem
from trajopt.query import Counts, query_of
from trajopt.retime import Retimed, RetimeFailure
from trajopt.trajectory import Path
from trajopt.verify import Certificate, Judge, Moment

DEFAULT_OPTIONS = FollowOptions()
"""What `follow` does unless told otherwise."""
START_SHARE = 0.5
"""Share of the tolerances that the start may be off the beginning of the curve."""
LEAST = 1e-4
"""Part of a curve that is worth a motion."""
CHORDS = (0.2, 0.1, 0.05)
"""How near to the curve straight lines between knots are, as a share of the tolerance; tighter if the judge
refuses the motion."""
ROUNDINGS = (0.6, 0.4, 0.2)
"""The same for how far timing may leave these lines."""
POSTURES = 3
"""Random postures that an arm with several joints to spare drifts to, to get farther."""
FREEST = 1e-3
"""Two ways that get equally far to this part of the curve are told apart by their travel."""


def _still(starts: Floats) -> Floats:
    """No posture to drift to."""
    return np.full_like(starts, np.nan)


def _continuous(on_curve: OnCurve, planned: Track) -> Track:
    """Move the knots of a program on to the curve, and keep them up to the first jump."""
    stations = stations_of(on_curve)
    dense = resampled(on_curve, planned, stations)
    there = on_curve(dense.positions, stations)
    moved = np.abs(np.diff(dense.positions, axis=0)).max(axis=1)
    good = there.held & (np.append(0.0, moved) <= 2.0 * FARTHEST)
    good[0] = True
    kept = len(good) if good.all() else int(np.argmin(good))
    return Track(stations[:kept], dense.positions[:kept])


def follow(
    scene: Scene,
    required: FollowsCurve,
    *,
    start: str | Mapping[str, float] | Floats,
    group: str = "",
    options: FollowOptions = DEFAULT_OPTIONS,
    rng: np.random.Generator | None = None,
) -> Followed:
    """Follow a curve with a frame, as far as it goes, and say why not farther.

    The motion is timed like any plan, and judged at all times: that the frame stays on the curve, never
    goes backwards on it, and gets as far as `fraction` says.

    Args:
        scene: The robot and what is around it, with the clearance to keep.
        required: The curve, the frame, and how near it must stay: `follows_curve(...)`.
        start: Name of a state, joint -> position [rad | m], or positions of all joints. With
            `Begin.ANY_BRANCH` it only says where the joints outside the group are, and what is near.
        group: The planning group; may be left out where the robot has one only.
        options: Where it may begin, what to do where it is blocked, speeds.
        rng: Draws postures and starts of searches; a fixed seed when None, so that the answer is the same
            every time.

    Returns:
        How far the curve is followed, why not farther, and the motion with its certificate.

    Raises:
        ProblemError: If the curve cannot be asked of this robot.
        NameNotFound: If a frame, group or state is unknown.
    """
    problem = Problem(
        scene=scene,
        group=group,
        start=start,
        goal=required,
        velocity_scaling=options.velocity_scaling,
        acceleration_scaling=options.acceleration_scaling,
        tool_speed=options.tool_speed,
        name="curve",
    )
    return _Following(problem, required, options, rng or np.random.default_rng(0)).run()


@dataclass(eq=False)
class _Following:
    """One curve that is followed: what has been done so far."""

    problem: Problem
    required: FollowsCurve
    options: FollowOptions
    rng: np.random.Generator
    counts: Counts = field(default_factory=Counts)
    seconds: dict[str, float] = field(default_factory=dict[str, float])
    programs: int = 0

    def run(self) -> Followed:
        """Choose where to begin, find the way that gets farthest, time it and have it judged."""
        reduced = self.problem.reduced
        self.on_curve = OnCurve(reduced, self.required, query_of(reduced, self.counts))
        with self._stage("start"):
            starts, refusal = self._starts()
        if refusal is not None:
            return self._nothing(refusal)
        with self._stage("track"):
            way, why = self._best(track(self.on_curve, stations_of(self.on_curve), starts, _still(starts)))
        if why is not None and self.on_curve.spare:
            with self._stage("look ahead"):
                way, why = self._looking_ahead(starts, way, why)
        if self.on_curve.spare:
            with self._stage("program"):
                way, why = self._as_program(way, why)
        if why is not None and self.options.avoid is Avoid.DEVIATE:
            around = self._around(starts, why)
            if around is not None:
                return around
        if way.reached < LEAST * self.required.until:
            assert why is not None
            return self._nothing(why)
        return self._motion(way, why)

    def _starts(self) -> tuple[Floats, Stop | None]:
        """Return configurations to begin in, shape (b, n), or why there is none."""
        reduced, on_curve = self.problem.reduced, self.on_curve
        nothing = np.empty((0, len(reduced.joint_names)))
        if self.options.begin is Begin.ANY_BRANCH:
            found = beginnings(on_curve, most=self.options.branches, rng=self.rng, counts=self.counts)
            if len(found) == 0:
                return nothing, stop(on_curve, Cause.NO_START, 0.0, "none of the configurations tried")
            return found, None
        seen = Judge(reduced).examine(reduced.start_positions, moment=Moment.START)
        if seen.out_of_limits:
            text = reasons.out_of_limits(seen)
            return nothing, stop(on_curve, Cause.START_OUT_OF_LIMITS, 0.0, text)
        if seen.collisions:
            worst = seen.collisions[0]
            return nothing, stop(
                on_curve,
                Cause.START_IN_COLLISION,
                0.0,
                reasons.collisions(seen),
                pair=(worst.first, worst.second),
                amount=-worst.distance,
            )
        start = reduced.start_positions[None]
        position, turn = on_curve.off(start, np.zeros(1))
        allowed = self.required.position_tolerance, self.required.rotation_tolerance
        if position[0] > START_SHARE * allowed[0] or turn[0] > START_SHARE * allowed[1]:
            text = f"{self.required.frame} is {position[0]:.4g} m and {turn[0]:.4g} rad away from it"
            return nothing, stop(on_curve, Cause.START_OFF_CURVE, 0.0, text)
        return start, None

    def _looking_ahead(self, starts: Floats, way: Track, why: Stop) -> tuple[Track, Stop | None]:
        """Use the joints to spare to get farther than straight tracking does."""
        on_curve, stations = self.on_curve, stations_of(self.on_curve)
        found: list[tuple[Track, Stop | None]] = [(way, why)]
        if on_curve.spare == 1:
            margin = start_margins(on_curve, starts)
            found.append(self._onward(SelfMotions(on_curve, margin).farthest(stations, starts)))
        else:
            limits = self.problem.reduced.limits
            low = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
            high = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
            for posture in ((low + high) / 2.0, *self.rng.uniform(low, high, (POSTURES, len(low)))):
                drifting = np.tile(posture, (len(starts), 1))
                found.append(self._best(track(on_curve, stations, starts, drifting)))
                if found[-1][1] is None:
                    break
        return max(found, key=lambda item: item[0].reached)

    def _onward(self, way: Track) -> tuple[Track, Stop | None]:
        """Go on from the end of a way by tracking, which tells what stops it there."""
        stations = stations_of(self.on_curve)
        rest = np.append(way.reached, stations[stations > way.reached])
        last = way.positions[-1:]
        (more,) = track(self.on_curve, rest, last, _still(last))
        stations = np.concatenate((way.stations, more.stations[1:]))
        return self._best([Track(stations, np.concatenate((way.positions, more.positions[1:])))])

    def _best(self, tracks: list[Track]) -> tuple[Track, Stop | None]:
        """Return the clear part of the track that gets farthest; of equals the one that moves least."""
        found: list[tuple[Track, Stop | None]] = []
        for each in tracks:
            clear = clear_part(self.on_curve, each)
            found.append((self._shortened(each, clear.until), clear.stop))
        length = self.required.until
        velocity = self.problem.limits.velocity

        def rank(item: tuple[Track, Stop | None]) -> tuple[float, float]:
            travel = np.abs(np.diff(item[0].positions, axis=0)) / velocity
            return round(item[0].reached / length / FREEST), -float(travel.sum(axis=0).max())

        way, why = max(found, key=rank)
        if why is None:
            why = untracked(self.on_curve, way, self.rng)
        return way, why

    def _shortened(self, way: Track, until: float) -> Track:
        """Return the part of a track up to a place, which becomes its last station."""
        if until >= way.reached:
            return way
        kept = way.until(until)
        if until - kept.reached < LEAST * self.required.until:
            return kept
        stations = np.append(kept.stations, until)
        return resampled(self.on_curve, way, stations)

    def _as_program(self, way: Track, why: Stop | None) -> tuple[Track, Stop | None]:
        """Plan what is followed as one program; return its way if it gets at least as far."""
        if way.reached < LEAST * self.required.until:
            return way, why
        part = replace(self.required, until=way.reached)
        on_part = OnCurve(self.on_curve.reduced, part, self.on_curve.query)
        problem = replace(self._beginning(way), goal=part)
        guess = resampled(on_part, way, knot_stations(part))
        solved = on_the_curve(problem, part, guess)
        self.programs += 1
        planned = _continuous(on_part, Track(guess.stations, solved.x))
        clear = clear_part(on_part, planned)
        if clear.stop is not None or planned.reached < way.reached:
            return way, why
        return planned, why

    def _beginning(self, way: Track) -> Problem:
        """Return the problem with the start where a way begins."""
        reduced = self.problem.reduced
        return replace(self.problem, start=readonly(reduced.all_positions(way.positions[0])))

    def _motion(self, way: Track, why: Stop | None) -> Followed:
        """Time the way and have the motion judged."""
        got = self.required if why is None else replace(self.required, until=way.reached)
        problem = replace(self._beginning(way), goal=got, constraints=(got,))
        on_curve = OnCurve(problem.reduced, got, self.on_curve.query)
        path, timed, certificate = self._timed(problem, on_curve, way)
        if isinstance(timed, RetimeFailure):
            failed = stop(on_curve, Cause.NO_TIMING, timed.place * got.until, timed.reason, joint=timed.joint)
            return self._result(problem, 0.0, failed, path=path)
        assert certificate is not None
        if not certificate.verified:
            why = stop(on_curve, Cause.NOT_VERIFIED, 0.0, reasons.not_verified(certificate))
        fraction = got.fraction if certificate.verified else 0.0
        return self._result(problem, fraction, why, path=path, timed=timed, certificate=certificate)

    def _timed(
        self, problem: Problem, on_curve: OnCurve, way: Track
    ) -> tuple[Path, Retimed | RetimeFailure, Certificate | None]:
        """Lay knots along a way, time them and have the motion judged; more tightly if it is refused."""
        tries: list[tuple[Path, Retimed, Certificate]] = []
        for chord, rounding in zip(CHORDS, ROUNDINGS, strict=True):
            with self._stage("densify"):
                dense = densified(on_curve, way, tolerance=chord * on_curve.allowed)
            path = Path(problem.reduced.joint_names, readonly(dense.positions))
            with self._stage("retime"):
                found = timed_along(problem, on_curve, path, tolerance=rounding * on_curve.allowed)
            if isinstance(found, RetimeFailure):
                return path, found, None
            with self._stage("verify"):
                certificate = self._judged(problem, found)
            tries.append((path, found, certificate))
            if certificate.verified:
                break
        return tries[-1]

    def _around(self, starts: Floats, why: Stop) -> Followed | None:
        """Go around what blocks the curve, inside the tube; None if no way is found and proven."""
        tube = self.options.tube
        with self._stage("deviate"):
            found = detours(self.problem, self.on_curve, starts, tube)
            self.programs += SIDES + 1
        wide = replace(self.required, position_tolerance=tube)
        for detour in found:
            problem = replace(self._beginning(detour.way), constraints=(wide,))
            on_detour = OnCurve(problem.reduced, detour.required, self.on_curve.query)
            path, timed, certificate = self._timed(problem, on_detour, detour.way)
            if isinstance(timed, Retimed) and certificate is not None and certificate.verified:
                return self._result(
                    problem, 1.0, None, path=path, timed=timed, certificate=certificate, around=why
                )
        return None

    def _judged(self, problem: Problem, timed: Retimed) -> Certificate:
        return Judge(problem.reduced).verify(
            timed.trajectory,
            goals=problem.goals,
            constraints=problem.requirements,
            tool_speeds=problem.tool_speeds,
            limits=problem.limits,
        )

    def _nothing(self, why: Stop) -> Followed:
        return self._result(self.problem, 0.0, why)

    def _result(
        self,
        problem: Problem,
        fraction: float,
        why: Stop | None,
        *,
        path: Path | None = None,
        timed: Retimed | None = None,
        certificate: Certificate | None = None,
        around: Stop | None = None,
    ) -> Followed:
        counts = self.counts
        return Followed(
            problem=problem,
            required=self.required,
            fraction=fraction,
            stop=why,
            around=around,
            path=path,
            timed=timed,
            certificate=certificate,
            counts={
                "programs": self.programs,
                "distance_calls": counts.distances,
                "forward_kinematics": counts.forward_kinematics,
                "judge_distance_calls": 0 if certificate is None else certificate.counts.distances,
            },
            cpu_seconds=dict(self.seconds),
        )

    @contextmanager
    def _stage(self, name: str) -> Generator[None]:
        begin = time.process_time()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + time.process_time() - begin
