"""Active motion: driven piece by piece, each with a stop after it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from math import inf

from trajopt.driving.commit_loop import Commitment
from trajopt.driving.events import EventKind
from trajopt.driving.intended_motion import SPEED_SCALINGS, GuardedGoal, IntendedMotion, time_at
from trajopt.driving.options import SupervisorOptions
from trajopt.driving.soonest_stop import StopTaken
from trajopt.problem.problem import Problem
from trajopt.timing.time_scaling import JOLT, PathStop, StopsAlong
from trajopt.values.arrays import Printed, Value

LATER_BRAKING = (0.0, 0.2, 0.5, inf)
"""Delays of braking tried if sooner stops are not proven [s]: past a box of 0.1 m at 0.5 m/s, past a
person, or to the goal.
"""


class PieceStatus(Enum):
    """Outcome of committing the next piece of a motion."""

    COMMITTED = "committed"
    """It is committed as far ahead as required."""
    UNPROVEN = "unproven"
    BRAKING = "braking"


@dataclass(frozen=True, eq=False)
class Pause(Value):
    """A stop on the path of a motion."""

    intended: IntendedMotion
    stop: PathStop

    def towards(self, goal: GuardedGoal) -> "Pause":
        return replace(self, intended=replace(self.intended, goal=goal))

    @cached_property
    def rests_at(self) -> float:
        stop, leaves = self.stop.trajectory, self.stop.leaves
        # No later than without braking: the motion may come near the same place again.
        return time_at(self.intended.trajectory, stop(stop.duration), leaves, leaves + stop.duration)


@dataclass(frozen=True, eq=False)
class _Moving(Value):
    """State of a robot on a motion.

    Attributes:
        brake_time: When the committed motion leaves it to brake, or goes over into it [s].
        pause: The committed stop; None before the first piece from rest.
    """

    intended: IntendedMotion
    brake_time: float
    pause: Pause | None

    def towards(self, goal: GuardedGoal) -> "_Moving":
        pause = None if self.pause is None else self.pause.towards(goal)
        return replace(self, intended=replace(self.intended, goal=goal), pause=pause)


@dataclass(eq=False)
class ActiveMotion(Printed):
    """The motion that a robot is on, committed piece by piece, each with a stop after it.

    If the next piece is not proven among dynamic obstacles, the path is driven slower. If no speed is proven,
    the robot brakes as committed and rests on its path.
    """

    commitment: Commitment
    options: SupervisorOptions
    _state: _Moving | Pause | None = None

    @property
    def intended(self) -> IntendedMotion | None:
        return self._state.intended if isinstance(self._state, _Moving) else None

    @property
    def pause(self) -> Pause | None:
        return self._state if isinstance(self._state, Pause) else None

    @property
    def coming_rest(self) -> Pause | None:
        return self._state.pause if isinstance(self._state, _Moving) else self._state

    @property
    def brake_time(self) -> float:
        """When the robot would brake if nothing more were committed [s]; -inf without a motion."""
        return self._state.brake_time if isinstance(self._state, _Moving) else -inf

    @property
    def partly_committed(self) -> bool:
        return self.intended is not None and self.brake_time < self.intended.end

    def branch_time(self, now: float) -> float | None:
        """Return when another motion can branch off [s], before the robot would brake; None without a motion.

        If the robot is committed to the end of the motion, it is the time that a plan may take.
        """
        if self.intended is None:
            return None
        end, soon = self.intended.end, now + self.options.ahead
        return self.brake_time if self.brake_time < end else soon if soon < end - 2.0 * JOLT else None

    def take(self, intended: IntendedMotion) -> None:
        state = self._state
        pause = state.pause if isinstance(state, _Moving) else state
        self._state = _Moving(intended, intended.begin, pause)

    def leave(self) -> None:
        self._state = None

    def beyond_waypoints(self, goal: GuardedGoal, at: float) -> GuardedGoal:
        """Return a goal without the waypoints passed before a time on the executor's clock [s]."""
        state = self._state
        if state is None or state.intended.goal is not goal:
            return goal
        time = state.rests_at if isinstance(state, Pause) else at - state.intended.begin
        passed = state.intended.passed(time)
        if not passed.intersection(goal.problem.waypoint_names):
            return goal
        left = goal.beyond(passed)
        self._state = state.towards(left)
        return left

    def forget_pause(self) -> None:
        if isinstance(self._state, Pause):
            self._state = None

    def extend(self, now: float) -> PieceStatus:
        """Commit the next piece of the motion, and a stop after it."""
        state = self._state
        if not isinstance(state, _Moving) or state.brake_time >= state.intended.end:
            return PieceStatus.COMMITTED
        intended, begin = state.intended, state.brake_time
        if begin < now + self.commitment.executor.latency:
            self._state = state.pause
            return PieceStatus.BRAKING
        if self._horizon(now) <= begin and begin > intended.begin:
            return PieceStatus.COMMITTED
        with self.commitment.journal.stage("prove"):
            for candidate, delay in self._candidates(intended, begin):
                if self.commit(candidate, begin, now, delay=delay):
                    self._note_speed(intended, candidate)
                    return PieceStatus.COMMITTED
        return PieceStatus.UNPROVEN

    def commit(self, intended: IntendedMotion, begin: float, now: float, *, delay: float = 0.0) -> bool:
        """Prove the next piece of a motion with a stop, `delay` [s] later than necessary, and commit it."""
        after = min(self._horizon(now) + delay - intended.begin, intended.trajectory.duration)
        stop = intended.stops.earliest(begin - intended.begin, after=after)
        commitment, guard = self.commitment, intended.goal.guard
        if commitment.stale(begin) or not guard.proven(stop.trajectory, commitment.world, begin):
            return False
        if not commitment.splice(stop.trajectory, begin):
            return False
        commitment.satisfies_all(guard)
        self._state = _Moving(intended, intended.begin + stop.leaves, Pause(intended, stop))
        return True

    def failed_check(self, intended: IntendedMotion, begin: float, now: float) -> str:
        stop = intended.stops.earliest(begin - intended.begin, after=self._horizon(now) - intended.begin)
        return intended.goal.guard.failed_check(stop.trajectory, self.commitment.world, begin)

    def resume(self, now: float) -> bool:
        """Go on along the path on which the robot rests, at the highest proven speed.

        The whole rest of the path has to be clear with the position errors of the last report.
        """
        pause, motion = self.pause, self.commitment.motion
        if pause is None or motion.end > now + self.options.ahead:
            return False
        at = max(motion.end + 2.0 * JOLT, now + self.options.ahead)
        if not self.clear_without_growing_errors(pause, at):
            return False
        for speed in SPEED_SCALINGS:
            candidate = pause.intended.at_speed(speed, at, rests_at=pause.rests_at)
            if candidate is not None and self.commit(candidate, at, now):
                words = f"the same path{_at(speed)}; {candidate.end - at:.3f} s to the goal"
                self.commitment.journal.note(EventKind.RESUMED, words)
                return True
        return False

    def clear_without_growing_errors(self, rest: IntendedMotion | Pause, time: float) -> bool:
        commitment = self.commitment
        world = commitment.world.without_growing_errors(time)
        if world is None:
            return False
        if isinstance(rest, IntendedMotion):
            return rest.goal.guard.proven(rest.after(time), world, time)
        intended = rest.intended
        resumed = (intended.at_speed(speed, time, rests_at=rest.rests_at) for speed in SPEED_SCALINGS)
        found = next((each for each in resumed if each is not None), None)
        return found is not None and found.goal.guard.proven(found.trajectory, world, time)

    def stop(self, problem: Problem, why: str) -> StopTaken:
        state = self._state
        self._state = None
        stop = self.commitment.stop(problem, why, lambda begin: self._path_stop(state, begin, problem))
        if isinstance(state, _Moving) and stop.taken.along:
            if stop.on_path is None:
                self._state = state.pause
            elif _leaves_intended(state, stop.begin):
                self._state = Pause(state.intended, stop.on_path)
        return stop.taken

    def _path_stop(self, state: "_Moving | Pause | None", begin: float, problem: Problem) -> PathStop | None:
        if isinstance(state, _Moving) and _leaves_intended(state, begin):
            return state.intended.stops.earliest(begin - state.intended.begin)
        ahead = self.commitment.motion.ahead(begin, self.commitment.joint_names)
        return None if ahead is None else StopsAlong(ahead, problem.limits).earliest(0.0)

    def _horizon(self, now: float) -> float:
        return now + self.options.ahead + self.options.cycle

    def _candidates(self, intended: IntendedMotion, begin: float) -> Iterator[tuple[IntendedMotion, float]]:
        """Yield continuations of the motion, the best first: speeds, and delays of braking [s].

        A stop farther on, or the sooner stop of a slower motion, may be clear of a dynamic obstacle. With a
        heavy load, hard braking may exceed the torque limits.
        """
        speed, changing = intended.scaling.speed, bool(self.commitment.world.scene.changing)
        for other in SPEED_SCALINGS:
            if other == speed:
                yield from ((intended, delay) for delay in LATER_BRAKING)
            elif (other > speed or changing) and (found := intended.at_speed(other, begin)) is not None:
                yield found, 0.0

    def _note_speed(self, before: IntendedMotion, now: IntendedMotion) -> None:
        old, speed = before.scaling.speed, now.scaling.speed
        if speed != old:
            kind = EventKind.SLOWING if speed < old else EventKind.RESUMED
            self.commitment.journal.note(kind, f"the same path{_at(speed)}")


def _leaves_intended(state: _Moving, begin: float) -> bool:
    return state.intended.begin <= begin < min(state.brake_time, state.intended.end)


def _at(speed: float) -> str:
    return " at full speed" if speed == 1.0 else f" at {speed:.0%} of its speed"
