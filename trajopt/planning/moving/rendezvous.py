"""Rendezvous with a moving goal: its time, and a motion that is at rest relative to the goal then.

For each time that is tried a motion is planned to the goal's place at that time, as if it were at rest, and
changed to follow the goal at its end (`following_frame`). It begins so that it arrives at that time. The
result is the earliest rendezvous that the judge proves, to within hundredths of a second.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.optimise.kinematics.goal_candidates import goal_candidates
from trajopt.planning.budget import Stopped
from trajopt.planning.moving.following_frame import FollowingFrame, FollowingMotion, seems_possible
from trajopt.planning.moving.static_scenes import at_rest
from trajopt.planning.moving.waiting import LONGEST
from trajopt.planning.result import Result
from trajopt.planning.search import ENDED, PlanSearch
from trajopt.planning.status import Status
from trajopt.planning.workspace import MotionCandidate, PlanningWorkspace
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FramePlacement
from trajopt.timing.standing import begun_later
from trajopt.values.errors import shown
from trajopt.values.trajectory import Path, Trajectory

STEP = 0.25
"""Step between the times that are tried [s]; then the interval between the last failure and the next time is
halved. Steps grow to a tenth of the time: a late meeting is hardly worse a little later.
"""
GROWTH = 0.1
HALVINGS = 3
"""So the meeting is within 0.03 s of the earliest that could be proven."""
SLOWER = (1.02, 1.1, 1.25, 1.5, 2.0, 3.0)
"""Factor on the duration of the motion to the goal: room for following it."""
SHARES = (0.5, 0.25, 0.1)
"""Parts of the motion at its end in which the goal is followed; smaller ones if the first is refused."""
ATTEMPTS = 4
"""Seeds that are attempted for each time: a straight line and three sampled paths."""


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
        """Make the model among dynamic obstacles."""
        self.problem, self.tracker = self.search.problem, self.search.tracker
        timed = self.problem.reduced.timed
        assert timed is not None  # the goal moves
        self._work = PlanningWorkspace(self.problem, self.tracker)
        self._carriers = goals_that_move(self.problem)
        moving = [goal for goal in self.problem.goals if any(map(self.problem.scene.carrier, goal.frames))]
        placements = tuple(goal for goal in moving if isinstance(goal, FramePlacement))
        self._frame = FollowingFrame(timed, placements)
        self._found: Result | None = None
        self._refused = self._nothing()
        due = inf if self.problem.finish_by is None else self.problem.finish_by
        self._last = min(LONGEST, due, timed.until - self.problem.dwell)

    def planned(self) -> Result:
        """Return the soonest motion that meets the goal; else the obstruction of the nearest attempt."""
        try:
            found = self._searched()
        except Stopped as ended:
            stop = ended.stop
            found = self._found or replace(self._refused, status=ENDED[stop])
            found = replace(found, stopped=stop)
        return replace(found, counts=dict(self.tracker.counts), cpu_seconds=dict(self.tracker.seconds))

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
        """Return a refusal, as a missed deadline if there is one."""
        due = self.problem.finish_by
        if due is None:
            return refused
        words = f"no meeting by {due:g} s was found: {refused.message}"
        return replace(refused, status=Status.TOO_LATE, message=words)

    def _missed_by(self, meeting: float) -> float:
        """Return the distance of the tried configurations from the goal at a time [m, rad]."""
        problem, counts = self._still(meeting), WorkCounts()
        found = goal_candidates(
            problem.evaluator(problem.reduced, counts), problem.goals, rng=np.random.default_rng(0)
        )
        self.tracker.count_work(counts)
        return 0.0 if found.free or found.blocked else found.nearest_miss

    def _halved(self, failed: float, meeting: float, found: Result) -> Result:
        """Return the soonest meeting between a failed time and a proven one."""
        for _ in range(HALVINGS):
            middle = (failed + meeting) / 2.0
            other, _ = self._met(middle)
            if other.verified:
                meeting, found = middle, other
            else:
                failed = middle
        return found

    def _keep(self, found: Result) -> None:
        self._found = found
        if self.search.on_incumbent is not None:
            self.search.on_incumbent(found)

    def _met(self, meeting: float) -> tuple[Result, float]:
        """Return a motion that meets the goal at a time, or why not, and before which time none can."""
        still = self.search.again(self._still(meeting), most=ATTEMPTS).run()
        if not still.verified:
            words = f"where the goal is at {meeting:.2f} s: {still.message or still.status.value}"
            # What is proven of one time is none of all.
            return replace(self._nothing(), status=still.status, message=words, blocks=still.blocks), 0.0
        planned = still.require()
        refused: Result | None = None
        for motion in self._motions(planned.trajectory, meeting):
            path = Path(motion.joint_names, motion.positions)
            judged = self._work.judged(MotionCandidate(path, motion, None), still.solve)
            if judged.verified:
                found = self._as_said(judged, still, meeting)
                self._keep(found)
                return found, 0.0
            refused = refused or replace(
                judged, message=f"the motion that meets the goal at {meeting:.2f} s: {judged.message}"
            )
        if refused is None:
            words = f"no motion that meets the goal at {meeting:.2f} s was found within the joints' limits"
            refused = replace(self._nothing(), message=words)
        return refused, SLOWER[0] * planned.trajectory.duration

    def _motions(self, still: Trajectory, meeting: float) -> Iterator[Trajectory]:
        """Yield motions that meet the goal at a time, made of one to its place then."""
        at_meeting, dwell = still(still.duration), self.problem.dwell
        for share in SHARES:
            for slower in SLOWER:
                if slower * still.duration > meeting:
                    break
                begin = meeting - share * slower * still.duration
                followed = FollowingMotion.of(self._frame, at_meeting, meeting, begin, meeting + dwell)
                if followed is None:
                    break
                joined = followed.joined(still, slower)
                wait = meeting + dwell - joined.duration
                if wait >= 0.0 and seems_possible(joined, self.problem.limits):
                    yield begun_later(joined, wait) if wait > 0.0 else joined
                    break

    def _still(self, meeting: float) -> Problem:
        """Return the problem with the goal at rest at its place of a time."""
        scene = at_rest(self.problem.scene, self._carriers, meeting)
        return replace(self.problem, scene=scene, dwell=0.0, finish_by=None)

    def _as_said(self, judged: Result, still: Result, meeting: float) -> Result:
        """Return a result with the method of its static motion, and its remarks."""
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
