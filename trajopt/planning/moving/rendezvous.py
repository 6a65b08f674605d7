"""Rendezvous with a moving goal."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import ceil, inf

import numpy as np

from trajopt.geometry import WorkCounts, evaluator
from trajopt.optimise.kinematics.forward import moving_frame, stacked_jacobian
from trajopt.optimise.kinematics.inverse import goal_candidates
from trajopt.optimise.methods.timing import tool_limits
from trajopt.optimise.terms.frame_placement import rotation_vector
from trajopt.planning.budget import Stopped
from trajopt.planning.moving.dynamic_timing import LONGEST
from trajopt.planning.moving.static_scenes import at_rest
from trajopt.planning.result import Result
from trajopt.planning.search import ENDED, PlanSearch
from trajopt.planning.status import Status
from trajopt.planning.workspace import MotionCandidate, PlanningWorkspace
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FramePlacement
from trajopt.robot.joints import JointLimits
from trajopt.scene.reduced import TimedModel
from trajopt.timing import ToolLimits
from trajopt.timing.time_scaling import begun_later
from trajopt.values.arrays import Floats
from trajopt.values.errors import shown
from trajopt.values.trajectory import Path, Trajectory

STEP = 0.25
"""Step between the tried times [s]; then the interval between the last failure and the next time is
halved. Steps grow to a tenth of the time.
"""
GROWTH = 0.1
HALVINGS = 3
"""So the meeting is within 0.03 s of the earliest that could be proven."""
SLOWER = (1.02, 1.1, 1.25, 1.5, 2.0, 3.0)
"""Factor on the duration of the motion to the goal: room for following it."""
SHARES = (0.5, 0.25, 0.1)
"""Parts of the motion at its end in which the goal is followed; smaller ones if the first is refused."""
ATTEMPTS = 4
"""Seeds attempted for each time: a straight line and three sampled paths."""


def goals_that_move(problem: Problem) -> frozenset[str]:
    """Return the objects that move and carry a goal of a problem, any goal of a set."""
    scene, each = problem.scene, problem.alternatives.values() or (problem,)
    frames = (frame for alone in each for item in alone.goals for frame in item.frames)
    return frozenset(carrier for frame in frames if (carrier := scene.carrier(frame)) is not None)


@dataclass(eq=False)
class Rendezvous:
    """Plans to meet moving goals.

    Attributes:
        search: The call of planning; its problem has one goal.
    """

    search: PlanSearch

    def __post_init__(self) -> None:
        self.problem, self.tracker = self.search.problem, self.search.tracker
        timed = self.problem.reduced.timed
        assert timed is not None  # the goal moves
        self._work = PlanningWorkspace(self.problem, self.tracker)
        self._carriers = goals_that_move(self.problem)
        moving = [goal for goal in self.problem.goals if any(map(self.problem.scene.carrier, goal.frames))]
        placements = tuple(goal for goal in moving if isinstance(goal, FramePlacement))
        self._frame = FollowingFrame(timed, placements)
        self._tools = tool_limits(self._work.query, self.problem.tool_speeds)
        self._found: Result | None = None
        self._refused = self._nothing()
        due = inf if self.problem.finish_by is None else self.problem.finish_by
        self._last = min(LONGEST, due, timed.until - self.problem.dwell)

    def planned(self) -> Result:
        try:
            found = self._searched()
        except Stopped as ended:
            stop = ended.stop
            found = self._found or replace(self._refused, status=ENDED[stop])
            found = replace(found, stopped=stop)
        return found.counted(self.tracker)

    def _searched(self) -> Result:
        failed, meeting = 0.0, STEP
        nearest, where = inf, 0.0
        while meeting <= self._last:
            self.tracker.check()
            missed, sooner = self._missed_by(meeting), 0.0
            if missed < nearest:
                nearest, where = missed, meeting
            if missed == 0.0:
                found, sooner = self._met(meeting)
                if found.verified:
                    return self._halved(failed, meeting, found)
                if _rank(found) > _rank(self._refused):
                    self._refused = found
            failed = meeting
            meeting = max(meeting + max(STEP, GROWTH * meeting), min(sooner, self._last))
        return self._late(self._met(where)[0] if 0.0 < nearest < inf else self._refused)

    def _late(self, refused: Result) -> Result:
        due = self.problem.finish_by
        if due is None:
            return refused
        words = f"no meeting by {due:g} s was found: {refused.message}"
        return replace(refused, status=Status.TOO_LATE, message=words)

    def _missed_by(self, meeting: float) -> float:
        problem, counts = self._still(meeting), WorkCounts()
        found = goal_candidates(
            problem.evaluator(problem.reduced, counts), problem.goals, rng=np.random.default_rng(0)
        )
        self.tracker.count_work(counts)
        return 0.0 if found.free or found.blocked else found.nearest_miss

    def _halved(self, failed: float, meeting: float, found: Result) -> Result:
        for _ in range(HALVINGS):
            middle = (failed + meeting) / 2.0
            other, _ = self._met(middle)
            if other.verified:
                meeting, found = middle, other
            else:
                failed = middle
        return found

    def _met(self, meeting: float) -> tuple[Result, float]:
        """Return a motion that meets the goal at a time, or why not, and before which time none can."""
        still = self.search.again(self._still(meeting), most=ATTEMPTS).run()
        if not still.verified:
            words = f"where the goal is at {meeting:.2f} s: {still.message or still.status.value}"
            # What is proven of one time is none of all.
            return replace(self._nothing(), status=still.status, message=words, blocks=still.blocks), 0.0
        planned = still.require()
        refused: Result | None = None
        last = self.problem.waypoint_names[-1:]
        passed = max((planned.certificate.passing_time(name) or 0.0 for name in last), default=0.0)
        for motion in self._motions(planned.trajectory, passed, meeting):
            path = Path(motion.joint_names, motion.positions)
            judged = self._work.judged(MotionCandidate(path, motion, None), still.solve)
            if judged.verified:
                found = self._as_said(judged, still, meeting)
                self._found = found
                if self.search.on_incumbent is not None:
                    self.search.on_incumbent(found)
                return found, 0.0
            refused = refused or replace(
                judged, message=f"the motion that meets the goal at {meeting:.2f} s: {judged.message}"
            )
        if refused is None:
            words = f"no motion that meets the goal at {meeting:.2f} s was found within the joints' limits"
            refused = replace(self._nothing(), message=words)
        return refused, SLOWER[0] * planned.trajectory.duration

    def _motions(self, still: Trajectory, passed: float, meeting: float) -> Iterator[Trajectory]:
        """Yield motions that meet the goal and are as the still one until it has passed its last waypoint."""
        at_meeting, dwell = still(still.duration), self.problem.dwell
        for share in SHARES:
            for slower in SLOWER:
                if slower * still.duration > meeting:
                    break
                begin = meeting - share * slower * (still.duration - passed)
                followed = FollowingMotion.of(self._frame, at_meeting, meeting, begin, meeting + dwell)
                if followed is None:
                    break
                joined = followed.joined(still, slower, passed)
                wait = meeting + dwell - joined.duration
                if wait >= 0.0 and seems_possible(joined, self.problem.limits, self._tools):
                    yield begun_later(joined, wait) if wait > 0.0 else joined
                    break

    def _still(self, meeting: float) -> Problem:
        scene = at_rest(self.problem.scene, self._carriers, meeting)
        return replace(self.problem, scene=scene, dwell=0.0, finish_by=None)

    def _as_said(self, judged: Result, still: Result, meeting: float) -> Result:
        names = " and ".join(shown(name) for name in sorted(self._carriers))
        stays = f", and stays with it for {self.problem.dwell:g} s" if self.problem.dwell else ""
        return replace(judged.planned_as(still), remarks=(f"meets {names} at {meeting:.3f} s{stays}",))

    def _nothing(self) -> Result:
        return self._work.result(Status.BLOCKED_IN_TIME, "the goal moves, and was not met")


def _rank(result: Result) -> int:
    """Order refusals: the judge's first, then failures of planning, then nothing."""
    if result.status is Status.NOT_VERIFIED:
        return 2
    return int(result.status is not Status.BLOCKED_IN_TIME)


FOLLOWING_STEP = 0.02
"""Time between two following configurations [s]: at 1 m/s the spline between them errs by fractions of a
micrometre.
"""
ITERATIONS, EXACT = 12, 1e-10
"""Most Newton steps, and their required precision [m | rad]."""
DAMPING = 1e-9
"""Keeps the steps finite at singular configurations, where following then fails."""
SETTLING = 1e-3
"""Time in which a motion that ends with an acceleration takes it back, without progress [s]."""
WITHIN = 0.998
"""Share of the limits that samples may reach, because of the values between them."""
SAMPLES = 12
"""Samples in each piece at which limits are checked."""


@dataclass(eq=False)
class FollowingFrame:
    """Makes joint motions that follow a moving goal; one for each thread.

    Attributes:
        goals: The placements to follow, relative to a moving frame.
    """

    timed: TimedModel
    goals: tuple[FramePlacement, ...]

    def __post_init__(self) -> None:
        self._query = evaluator(self.timed.reduced)

    def positions(self, at_meeting: Floats, meeting: float, times: Floats) -> Floats | None:
        wanted = [self._relative(goal, at_meeting[None], np.array((meeting,)))[:2] for goal in self.goals]
        for free in (False, True):
            found = self._kept(wanted, np.tile(at_meeting, (len(times), 1)), times, free=free)
            if found is not None:
                return found
        return None

    def _kept(
        self, wanted: list[tuple[Floats, Floats]], found: Floats, times: Floats, *, free: bool
    ) -> Floats | None:
        for _ in range(ITERATIONS):
            errors, slopes = self._linearised(wanted, found, times, free=free)
            if np.abs(errors).max() <= EXACT:
                return found
            transposed = np.swapaxes(slopes, 1, 2)
            gram = slopes @ transposed + DAMPING * np.eye(slopes.shape[1])
            found = found - (transposed @ np.linalg.solve(gram, errors[:, :, None]))[:, :, 0]
        return None

    def _relative(
        self, goal: FramePlacement, positions: Floats, times: Floats
    ) -> tuple[Floats, Floats, Floats]:
        joints = positions.shape[1]
        every = self.timed.positions(positions, times)
        at = moving_frame(self._query, goal.frame, every, goal.reference, goal.offset)
        return at.rotation, at.point, stacked_jacobian(at)[:, :, :joints]

    def _linearised(
        self, wanted: list[tuple[Floats, Floats]], positions: Floats, times: Floats, *, free: bool
    ) -> tuple[Floats, Floats]:
        errors: list[Floats] = []
        slopes: list[Floats] = []
        for goal, (rotation, point) in zip(self.goals, wanted, strict=True):
            rotations, points, jacobian = self._relative(goal, positions, times)
            # Along the axes of the goal's placement, in which its tolerances are stated.
            inward = goal.placement.rotation.T
            off = (points - point[0]) @ inward.T
            turns = rotation_vector(rotations @ rotation[0].T)[0] @ inward.T
            tolerances = np.concatenate((goal.position_tolerance, goal.rotation_tolerance))
            kept = np.isfinite(tolerances) if free else np.ones(6, dtype=np.bool_)
            errors.append(np.concatenate((off, turns), axis=1)[:, kept])
            slopes.append(
                np.concatenate((inward @ jacobian[:, :3], inward @ jacobian[:, 3:]), axis=1)[:, kept]
            )
        return np.concatenate(errors, axis=1), np.concatenate(slopes, axis=1)


@dataclass(frozen=True, eq=False)
class FollowingMotion:
    """The joint motion that follows a goal, around the time at which it is met.

    To a motion y that ends at rest, at the frame's place of a time T, it adds the joint travel that follows
    the frame from the configuration at T: q*(t) - q*(T), exact in the last part. Before, the added part grows
    from zero, by a quintic, after the last waypoint. So the sum begins as y does, and at T it has the frame's
    velocity and acceleration.

    Attributes:
        times: Shape (s,), increasing [s].
        rows: Positions, velocities and accelerations at these times, of a cubic spline, shape (3, s, n).
    """

    times: Floats
    rows: Floats
    meeting: float

    @staticmethod
    def of(
        frame: FollowingFrame, at_meeting: Floats, meeting: float, begin: float, end: float
    ) -> "FollowingMotion | None":
        """Return the motion from `begin` to `end` >= `meeting` [s]; None if the arm cannot follow.

        Args:
            at_meeting: The group's positions at the meeting, shape (n,) [rad | m].
        """
        before = np.linspace(begin, meeting, 1 + max(3, ceil((meeting - begin) / FOLLOWING_STEP)))
        after = np.linspace(meeting, end, 1 + ceil((end - meeting) / FOLLOWING_STEP))[1:]
        times = np.concatenate((before, after))
        found = frame.positions(at_meeting, meeting, times)
        if found is None:
            return None
        return FollowingMotion(times, _spline(times, found), meeting)

    def joined(self, still: Trajectory, slower: float, passed: float) -> Trajectory:
        """Return a motion that meets the goal and stays with it; its time starts when it begins to move.

        Args:
            passed: Time at which `still` passes its last waypoint [s].
        """
        settling = SETTLING if still.accelerations is not None and still.accelerations[-1].any() else 0.0
        over = still.duration * slower
        duration, grows = over + settling, passed * slower
        mine = self.times - self.meeting + duration
        knots = np.concatenate((still.times * slower, (grows, duration), mine))
        knots = np.unique(knots[knots >= 0.0])
        knots = knots[np.append(True, np.diff(knots) > _NEAR)]
        lent = np.flatnonzero(knots < mine[0])
        rows = [still(knots / slower, order) / slower**order for order in range(3)]
        for row in rows[1:]:
            row[knots > over] = 0.0
        begins = float(mine[0])
        place = self.rows[0, int(np.searchsorted(self.times, self.meeting - _NEAR))]
        added = [self._at(order, knots - duration + self.meeting) for order in range(3)]
        added[0] = added[0] - place
        first = np.stack([self.rows[0, 0] - place, self.rows[1, 0], self.rows[2, 0]])
        since = np.maximum(knots[lent] - grows, 0.0)
        for order, values in enumerate(_grown(first, begins - grows, since)):
            added[order][lent] = values
        return Trajectory(still.joint_names, knots, *(a + b for a, b in zip(rows, added, strict=True)))

    def _at(self, order: int, times: Floats) -> Floats:
        place = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2)
        h = np.diff(self.times)[place][:, None]
        z = np.clip(times - self.times[place], 0.0, h[:, 0])[:, None]
        q, v, a = (self.rows[index][place] for index in range(3))
        jerk = (self.rows[2][place + 1] - a) / h
        series = ((q, v, a / 2.0, jerk / 6.0), (v, a, jerk / 2.0), (a, jerk))[order]
        value = series[-1]
        for coefficient in series[-2::-1]:
            value = value * z + coefficient
        return value


def _spline(times: Floats, values: Floats) -> Floats:
    """Return values, first and second derivatives of a cubic spline through points, (s, n) -> (3, s, n).

    Its third derivative is continuous at the second and the last but one (not-a-knot). SciPy's takes a second
    to import.
    """
    h, count = np.diff(times), len(times)
    slope = np.diff(values, axis=0) / h[:, None]
    system, right = np.zeros((count, count)), np.zeros_like(values)
    inner = np.arange(1, count - 1)
    system[inner, inner - 1], system[inner, inner + 1] = h[:-1], h[1:]
    system[inner, inner] = 2.0 * (h[:-1] + h[1:])
    right[inner] = 6.0 * np.diff(slope, axis=0)
    system[0, :3] = -h[1], h[0] + h[1], -h[0]
    system[-1, -3:] = -h[-1], h[-2] + h[-1], -h[-2]
    bends: Floats = np.asarray(np.linalg.solve(system, right), dtype=np.float64)
    begins = slope - h[:, None] * (2.0 * bends[:-1] + bends[1:]) / 6.0
    end = slope[-1:] + h[-1] * (bends[-2:-1] + 2.0 * bends[-1:]) / 6.0
    return np.stack((values, np.concatenate((begins, end)), bends))


_NEAR = 1e-6
"""Times nearer than this count as equal [s]."""


def _grown(end: Floats, duration: float, times: Floats) -> list[Floats]:
    q, v, a = end[0], end[1] * duration, end[2] * duration**2
    third, fourth, fifth = 10 * q - 4 * v + a / 2, -15 * q + 7 * v - a, 6 * q - 3 * v + a / 2
    z = (times / duration)[:, None]
    return [
        z**3 * (third + z * (fourth + z * fifth)),
        z**2 * (3 * third + z * (4 * fourth + z * 5 * fifth)) / duration,
        z * (6 * third + z * (12 * fourth + z * 20 * fifth)) / duration**2,
    ]


def seems_possible(motion: Trajectory, limits: JointLimits, tools: ToolLimits | None) -> bool:
    """Return whether samples of a motion are within the limits of joints and tools."""
    begins, lengths = motion.times[:-1], np.diff(motion.times)
    times = (begins[:, None] + lengths[:, None] * np.linspace(0.0, 1.0, SAMPLES)[None, :]).ravel()
    positions = motion(times)
    if (positions < limits.lower).any() or (positions > limits.upper).any():
        return False
    if tools is not None and (tools.speeds(positions, motion(times, 1)) > WITHIN * tools.limit).any():
        return False
    bounds = (limits.velocity, limits.acceleration, limits.jerk)
    return all(
        bool((np.abs(motion(times, order)) <= WITHIN * bound).all())
        for order, bound in enumerate(bounds, start=1)
    )
