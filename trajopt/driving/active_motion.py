"""The motion that a robot is on, committed piece by piece, each with a stop after it."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from math import inf

import numpy as np

from trajopt.driving.commit_loop import Commitment
from trajopt.driving.events import EventKind
from trajopt.driving.intended_motion import SPEED_SCALINGS, IntendedMotion
from trajopt.driving.options import SupervisorOptions
from trajopt.driving.soonest_stop import StopTaken
from trajopt.problem.problem import Problem
from trajopt.timing.standing import JOLT
from trajopt.timing.stops import PathStop, StopsAlong
from trajopt.values.arrays import Floats, Printed
from trajopt.values.trajectory import Trajectory

FARTHER = (0.0, 0.2, 0.5, inf)
"""How much farther the robot goes on where a sooner stop is not proven [s]: past a box of 0.1 m at 0.5 m/s,
past a person, or to the goal."""
STOPS = 3
"""So often a stop is looked for. The second time there is twice the time that the first took, which is enough
but for a machine that stalls."""
SAMPLES = 400
"""Samples of a motion among which the one nearest to a rest is searched."""
NEWTON_STEPS = 8
"""Steps that refine its time to rounding: each squares the error."""


class PieceStatus(Enum):
    """How a robot gets on with the motion that it is on."""

    ON = "on"
    """It is committed as far ahead as it has to be."""
    UNPROVEN = "unproven"
    """What comes next is not proven; there is time until it brakes."""
    BRAKING = "braking"
    """It brakes: nothing that goes on was proven in time."""


@dataclass(frozen=True, eq=False)
class Pause(Printed):
    """Where a robot stands, or will come to rest, on the path that it was on.

    Attributes:
        intended: What it was to do.
        stop: How it stops on the path of that.
    """

    intended: IntendedMotion
    stop: PathStop

    @cached_property
    def rests(self) -> float:
        """Where it comes to rest, on the clock of what it was to do [s]."""
        stop = self.stop.trajectory
        return _time_at(self.intended.trajectory, stop(stop.duration), self.stop.leaves)


@dataclass(eq=False)
class ActiveMotion(Printed):
    """The motion that a robot is on, committed piece by piece, each with a stop after it.

    Where the next piece is not proven, and something moves, the path is gone on along slower: the slower, the
    sooner the robot stands. If no speed is proven it brakes as was proven before, and stands on its path.

    Attributes:
        commitment: What the robot will do whatever comes.
        options: Of the supervisor.
        intended: What it is to do; None where it is on no motion.
        parting: When it would begin to brake, if nothing more were committed [s].
        pause: Where it stands on the path that it was on; None where it was on none.
    """

    commitment: Commitment
    options: SupervisorOptions
    intended: IntendedMotion | None
    parting: float
    pause: Pause | None = None
    _committed: Pause | None = None

    @property
    def in_motion(self) -> bool:
        """Whether there is a motion that it can be changed on."""
        return self.intended is not None and self.parting < self.intended.end

    def parts(self, now: float) -> float | None:
        """Return when the motion can be left for another [s]; None where the robot is on none.

        That is where the robot would begin to brake; where it is committed to the end of the motion, as
        far ahead as a plan may take.
        """
        if self.intended is None:
            return None
        end, soon = self.intended.end, now + self.options.ahead
        return self.parting if self.parting < end else soon if soon < end - 2.0 * JOLT else None

    def take(self, intended: IntendedMotion) -> None:
        """Be on another motion from where it begins."""
        self.intended, self.parting, self.pause = intended, intended.begin, None

    def leave(self) -> None:
        """Be on no motion any more."""
        self.intended = self.pause = None

    def extend(self, now: float) -> PieceStatus:
        """Commit the next piece of the motion, and a stop after it."""
        intended, begin = self.intended, self.parting
        if intended is None or begin >= intended.end:
            return PieceStatus.ON
        if begin < now + self.commitment.executor.latency:
            self.intended, self.pause = None, self._committed
            return PieceStatus.BRAKING
        if self._after(now) <= begin and begin > intended.begin:
            return PieceStatus.ON
        with self.commitment.journal.stage("prove"):
            for candidate, farther in self._candidates(intended, begin):
                if self.commit(candidate, begin, now, farther=farther):
                    self._say(intended, candidate)
                    return PieceStatus.ON
        return PieceStatus.UNPROVEN

    def commit(self, intended: IntendedMotion, begin: float, now: float, *, farther: float = 0.0) -> bool:
        """Prove the next piece of a motion and a stop after it, and have it driven; say whether it is.

        Args:
            intended: The motion.
            begin: When the piece begins [s].
            now: The time [s].
            farther: It goes on for so much longer than it must before it brakes [s].
        """
        after = min(self._after(now) + farther - intended.begin, intended.trajectory.duration)
        stop = intended.stops.earliest(begin - intended.begin, after=after)
        commitment, guard = self.commitment, intended.goal.guard
        if commitment.stale(begin) or not guard.proven(stop.trajectory, commitment.world, begin):
            return False
        if not commitment.splice(stop.trajectory, begin):
            return False
        commitment.holds(guard)
        self.intended, self.pause = intended, None
        self.parting, self._committed = intended.begin + stop.leaves, Pause(intended, stop)
        return True

    def why_not(self, intended: IntendedMotion, begin: float, now: float) -> str:
        """Say why the next piece of a motion is not proven; arguments as of `commit`."""
        stop = intended.stops.earliest(begin - intended.begin, after=self._after(now) - intended.begin)
        return intended.goal.guard.why_not(stop.trajectory, self.commitment.world, begin)

    def resume(self, now: float) -> bool:
        """Go on along the path on which the robot stands, at the highest speed that is proven.

        All that is left of it has to be clear, as well as it was known where everything is.
        """
        pause, motion = self.pause, self.commitment.motion
        if pause is None or motion.end > now + self.options.ahead:
            return False
        at = max(motion.end + 2.0 * JOLT, now + self.options.ahead)
        if not self.would_be_clear(pause, at):
            return False
        for speed in SPEED_SCALINGS:
            candidate = pause.intended.at_speed(speed, at, rests_at=pause.rests)
            if candidate is not None and self.commit(candidate, at, now):
                words = f"the same path{_at(speed)}; {candidate.end - at:.3f} s to the goal"
                self.commitment.journal.note(EventKind.RESUMED, words)
                return True
        return False

    def would_be_clear(self, left: IntendedMotion | Pause, time: float) -> bool:
        """Whether what is left of a motion is clear if all is still known as well as when it was seen."""
        commitment = self.commitment
        world = commitment.world.as_well_known(time)
        if world is None:
            return False
        if isinstance(left, IntendedMotion):
            return left.goal.guard.proven(left.left(time), world, time)
        intended = left.intended
        slowed = (intended.at_speed(speed, time, rests_at=left.rests) for speed in SPEED_SCALINGS)
        found = next((each for each in slowed if each is not None), None)
        return found is not None and found.goal.guard.proven(found.trajectory, world, time)

    def stop(self, problem: Problem, why: str) -> StopTaken:
        """Take the soonest proven stop, of the motion or off its path.

        Finding one takes time. Where that was more than the executor's latency leaves, it is looked for again
        from as much later on; if none comes in time, the motors brake at once.
        """
        commitment, intended, lead = self.commitment, self.intended, 0.0
        self.leave()
        for _ in range(STOPS):
            asked = commitment.executor.now()
            begin = commitment.soonest + lead
            along, resumable = self._earliest_stop(intended, begin, problem)
            found = commitment.stop(problem, begin, None if along is None else along.trajectory, why)
            if found is not None and (not lead or found[0] is not None):
                motion, taken = found
                if intended is not None and taken.along:
                    if along is None or motion is not along.trajectory:
                        self.pause = self._committed
                    elif resumable:
                        self.pause = Pause(intended, along)
                self.parting = begin
                return taken
            lead = 2.0 * (commitment.executor.now() - asked)
        self.parting = commitment.soonest
        return commitment.brake(why)

    def _earliest_stop(
        self, intended: IntendedMotion | None, begin: float, problem: Problem
    ) -> tuple[PathStop | None, bool]:
        """Return the earliest stop on the path from a time on, and whether that is the path of the motion.

        Before a new motion begins, and if there is none, the robot is on the one that is committed.
        """
        if intended is not None and intended.begin <= begin < min(self.parting, intended.end):
            return intended.stops.earliest(begin - intended.begin), True
        ahead = self.commitment.motion.ahead(begin, self.commitment.joint_names)
        return (None, False) if ahead is None else (StopsAlong(ahead, problem.limits).earliest(0.0), False)

    def _after(self, now: float) -> float:
        """Return until when the robot goes on before it brakes [s]."""
        return now + self.options.ahead + self.options.cycle

    def _candidates(self, intended: IntendedMotion, begin: float) -> Iterator[tuple[IntendedMotion, float]]:
        """Yield the motion at possible speeds, the best first, and how much farther it goes [s].

        Where something moves, a stop may be in its way that is clear farther on, and so may be one that is
        sooner where the robot goes slower. With a heavy load, braking hard takes a torque that there is not:
        going on to where it can be braked gently, or to the goal, does not.
        """
        speed, changing = intended.scaling.speed, bool(self.commitment.world.scene.changing)
        for other in SPEED_SCALINGS:
            if other == speed:
                yield from ((intended, farther) for farther in FARTHER)
            elif (other > speed or changing) and (found := intended.at_speed(other, begin)) is not None:
                yield found, 0.0

    def _say(self, before: IntendedMotion, now: IntendedMotion) -> None:
        """Note that the speed has changed."""
        old, speed = before.scaling.speed, now.scaling.speed
        if speed != old:
            kind = EventKind.SLOWING if speed < old else EventKind.RESUMED
            self.commitment.journal.note(kind, f"the same path{_at(speed)}")


def _at(speed: float) -> str:
    return " at full speed" if speed == 1.0 else f" at {speed:.0%} of its speed"


def _time_at(motion: Trajectory, positions: Floats, after: float) -> float:
    """Return the time at which a motion passes positions on its path, shape (n,), after another time [s]."""
    times = np.linspace(after, motion.duration, SAMPLES + 1)
    time = float(times[np.linalg.norm(motion(times) - positions, axis=1).argmin()])
    for _ in range(NEWTON_STEPS):
        velocity = motion(time, 1)
        speed = float(velocity @ velocity)
        if speed > 0.0:
            time += float(velocity @ (positions - motion(time))) / speed
            time = min(max(time, after), motion.duration)
    return time
