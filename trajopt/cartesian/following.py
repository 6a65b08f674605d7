"""follow(...): from a curve to a timed, judged motion along it, as far as it goes, and why not farther."""

import time
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from trajopt.arrays import Floats, one_of, readonly
from trajopt.cartesian.blocked import stop
from trajopt.cartesian.dense import densified
from trajopt.cartesian.deviate import SIDES, detours
from trajopt.cartesian.on_curve import OnCurve
from trajopt.cartesian.options import Avoid, Begin, FollowOptions
from trajopt.cartesian.result import Cause, Followed, Stop
from trajopt.cartesian.search import LEAST, Found, Search, beginning
from trajopt.cartesian.starts import beginnings
from trajopt.cartesian.timing import timed_along
from trajopt.cartesian.tracking import Track
from trajopt.infeasibility import reasons
from trajopt.model.requirements import FollowsCurve
from trajopt.model.scene import Scene
from trajopt.model.trajectory import Path
from trajopt.planning.judgement import judge
from trajopt.problem import Problem
from trajopt.query import Counts, Query
from trajopt.retime import Retimed, RetimeFailure
from trajopt.verify import Certificate, Judge, Moment

DEFAULT_OPTIONS = FollowOptions()
"""What `follow` does unless told otherwise."""
START_SHARE = 0.5
"""Share of the tolerances that the start may be off the beginning of the curve."""
CHORDS = (0.2, 0.1, 0.05)
"""How near to the curve straight lines between knots are, as a share of the tolerance; tighter if the judge
refuses the motion."""
ROUNDINGS = (0.6, 0.4, 0.2)
"""The same for how far timing may leave these lines."""


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
    required, options = one_of("required", required, FollowsCurve), one_of("options", options, FollowOptions)
    problem = Problem(
        scene=one_of("scene", scene, Scene),
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

    @cached_property
    def on_curve(self) -> OnCurve:
        """The curve and the arm."""
        reduced = self.problem.reduced
        return OnCurve(reduced, self.required, Query(reduced, self.counts))

    def run(self) -> Followed:
        """Choose where to begin, find the way that gets farthest, time it and have it judged."""
        with self._stage("start"):
            starts, refusal = self._starts()
        if refusal is not None:
            return self._nothing(refusal)
        search = Search(self.problem, self.on_curve, self.rng)
        with self._stage("track"):
            found = search.tracked(starts)
        if found.stop is not None and self.on_curve.spare:
            with self._stage("look ahead"):
                found = search.looking_ahead(starts, found)
        if self.on_curve.spare:
            with self._stage("program"):
                found = search.as_program(found)
                self.programs += 1
        if found.stop is not None and self.options.avoid is Avoid.DEVIATE:
            around = self._around(starts, found.stop)
            if around is not None:
                return around
        if found.stop is not None and found.way.reached < LEAST * self.required.until:
            return self._nothing(found.stop)
        return self._motion(found)

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
                amount=worst.required - worst.distance,
            )
        start = reduced.start_positions[None]
        position, turn = on_curve.off(start, np.zeros(1))
        allowed = self.required.position_tolerance, self.required.rotation_tolerance
        if position[0] > START_SHARE * allowed[0] or turn[0] > START_SHARE * allowed[1]:
            text = f"{self.required.frame} is {position[0]:.4g} m and {turn[0]:.4g} rad away from it"
            return nothing, stop(on_curve, Cause.START_OFF_CURVE, 0.0, text)
        return start, None

    def _motion(self, found: Found) -> Followed:
        """Time a way and have the motion judged."""
        way, why = found.way, found.stop
        got = self.required if why is None else replace(self.required, until=way.reached)
        problem = replace(beginning(self.problem, way), goal=got, constraints=(got,))
        on_curve = OnCurve(problem.reduced, got, self.on_curve.query)
        path, timed, certificate = self._timed(problem, on_curve, way)
        if isinstance(timed, RetimeFailure):
            failed = stop(on_curve, Cause.NO_TIMING, timed.place * got.until, timed.reason, joint=timed.joint)
            return self._result(problem, 0.0, failed, path=path)
        assert certificate is not None
        if not certificate.verified:
            why = stop(on_curve, Cause.NOT_VERIFIED, 0.0, reasons.not_verified(certificate))
        fraction = got.until / self.required.until if certificate.verified else 0.0
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
                certificate = judge(problem, found.trajectory)
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
            problem = replace(beginning(self.problem, detour.way), constraints=(wide,))
            on_detour = OnCurve(problem.reduced, detour.required, self.on_curve.query)
            path, timed, certificate = self._timed(problem, on_detour, detour.way)
            if isinstance(timed, Retimed) and certificate is not None and certificate.verified:
                return self._result(
                    problem, 1.0, None, path=path, timed=timed, certificate=certificate, around=why
                )
        return None

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
