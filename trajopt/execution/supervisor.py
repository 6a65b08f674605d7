"""Supervisor: drives a robot to goals among what it is told of the world, always able to stop."""

import time
from dataclasses import dataclass, field
from math import inf

import numpy as np

from trajopt.arrays import Printed
from trajopt.errors import ProblemError
from trajopt.errors.arguments import checked
from trajopt.execution.committed_motion import REST, CommittedMotion
from trajopt.execution.events import Event, Kind
from trajopt.execution.executor import Executor
from trajopt.execution.guard import Guard, Seen, guard_of, standing
from trajopt.execution.intention import Intention
from trajopt.execution.options import SupervisorOptions
from trajopt.execution.recovery import recovery
from trajopt.execution.soonest_stop import StopTaken, soonest_stop
from trajopt.execution.tracking import off_track
from trajopt.model.scene import Scene
from trajopt.model.stated import GoalLike
from trajopt.model.trajectory import Trajectory
from trajopt.planning import Result, on_the_way
from trajopt.planning.moving.waiting import JOLT
from trajopt.planning.plan import plan
from trajopt.problem import Problem
from trajopt.retime.stops import StopsAlong

DEFAULT = SupervisorOptions()
SLOW = 1e-2
"""A joint this slow stands, as far as sensors tell [rad/s | m/s]."""


@checked
@dataclass(eq=False)
class Supervisor(Printed):
    """Drives a robot to goals.

    What the executor has to drive is at all times: the motion for a short time ahead, and then a stop along
    its path, proven as one motion in the world as it was known. Each cycle proves the next such motion and
    splices it in where the last one would begin to brake. What is not proven is not spliced in, and then the
    robot stops as it was proven before. So it does where no cycle comes any more.

    Attributes:
        executor: What drives the robot.
        problem: What is required on the way, and the goal.
        options: Numbers to work with.
        events: What happened, in order.
        seconds: CPU time that each stage took, each time [s].
    """

    executor: Executor
    problem: Problem
    options: SupervisorOptions = DEFAULT
    events: list[Event] = field(default_factory=list[Event])
    seconds: dict[str, list[float]] = field(default_factory=dict[str, list[float]])
    _guard: Guard = field(init=False)
    _seen: Seen = field(init=False)
    _committed: CommittedMotion = field(init=False)
    _intended: Intention | None = field(default=None, init=False)
    _parting: float = field(default=0.0, init=False)
    _wanted: Problem | None = field(default=None, init=False)
    _revise: bool = field(default=False, init=False)
    _again: float = field(default=0.0, init=False)
    _said: str = field(default="", init=False)

    def __post_init__(self) -> None:
        """Take the robot as it stands."""
        state = self.executor.state()
        if np.abs(state.velocities).max() > REST:
            raise ProblemError("the robot moves: a supervisor takes it over where it stands")
        self._committed = CommittedMotion(self.executor.joint_names, state.commanded)
        self._guard = guard_of(self.problem, self.executor)
        self._seen = Seen(self.problem.scene, self.executor.now())
        self._parting = self.executor.now()

    @property
    def scene(self) -> Scene:
        """The world as it was last told."""
        return self._seen.scene

    @property
    def seen(self) -> Seen:
        """The world as it was last told, and when."""
        return self._seen

    @property
    def committed(self) -> CommittedMotion:
        """What the robot will do whatever comes; not to be changed."""
        return self._committed

    @property
    def intended(self) -> Intention | None:
        """The motion to the goal that it is on; None while there is none."""
        return self._intended

    @property
    def moving(self) -> bool:
        """Whether the robot has to move now, or will have to."""
        return self.executor.now() < self._committed.end

    @property
    def busy(self) -> bool:
        """Whether there is a goal that is not reached."""
        return self._wanted is not None or self._intended is not None or self.moving

    @property
    def blocked(self) -> bool:
        """Whether the robot stands, and there is no plan to the goal in the world as it is known."""
        return self._wanted is not None and self._again == inf and not self.moving

    @checked
    def go(self, problem: Problem) -> None:
        """Ask for a goal; the next cycle plans the motion, from where the robot will be then.

        Args:
            problem: Its start, the scene and the name of the group are those of the supervisor.

        Raises:
            ProblemError: If it is of another group or robot.
        """
        same = problem.group == self.problem.group
        if not same or problem.scene.robot is not self.problem.scene.robot:
            raise ProblemError("a supervisor drives one group of one robot: make another one")
        if self._intended is not None:
            self._note(Kind.GOAL_CHANGED)
        self.problem = self._wanted = problem
        self._guard = guard_of(problem, self.executor)
        self._again = 0.0

    @checked
    def see(self, scene: Scene, stamp: float | None = None) -> None:
        """Tell it what the world is like; the next cycle judges by it what is left of the motion.

        Args:
            scene: Its clock shows 0 at the time of the stamp.
            stamp: On the executor's clock [s]; now when None.
        """
        self._seen = Seen(scene, self.executor.now() if stamp is None else stamp)
        self._revise, self._again = True, 0.0
        self._note(Kind.WORLD_CHANGED)

    def cycle(self) -> None:
        """Watch the robot, prove what comes next, and plan anew where that is needed."""
        begun, now = time.process_time(), self.executor.now()
        fault = self.executor.fault()
        if fault:
            if self._intended is not None or self._wanted is not None:
                self._note(Kind.FAULT, fault)
            self._intended = self._wanted = None
            return
        if self._off_track():
            return
        if self._revise:
            self._revise = False
            self._look_again(now)
        if self._wanted is not None and now >= self._again:
            self._plan()
        if self._intended is not None:
            self._extend(now)
        self._spent("cycle", begun)

    def stop(self) -> StopTaken:
        """Bring the robot to rest as soon as that is proven to be clear of everything.

        Of a stop along the path and one in which each joint brakes as hard as it may, the sooner one that is
        proven is taken; if none is, the sooner one.
        """
        self._wanted = None
        return self._stop(self.executor.now(), "asked for")

    @checked
    def recover(self, goal: GoalLike, *, scaling: float = 0.1) -> bool:
        """Bring the robot out of a fault, and of light contact, and on to a goal, slowly.

        The fault is cleared. The whole motion is judged and committed at once: out of what touches, which
        separates all the time, then clear of everything. What it is, is in the events.

        Args:
            goal: Where to go, as of a problem: "ready".
            scaling: Factor in (0, 1] on the limits of velocity and acceleration.

        Returns:
            Whether there is such a motion; if not, the robot stands, and the events say why.

        Raises:
            ProblemError: If the robot moves, or the scaling is no such factor.
        """
        self.executor.clear_fault()
        state = self.executor.state()
        if self.moving and np.abs(state.velocities).max() > SLOW:
            raise ProblemError("the robot moves: it recovers where it stands")
        self._intended = self._wanted = None
        self._committed = CommittedMotion(self.executor.joint_names, state.commanded)
        at = self.executor.now() + self.options.ahead
        if self._stale(at):
            return False
        here = standing(self.problem, self._committed, at, self._seen.at(at))
        found = recovery(here, here.scene, here.start_positions, goal, scaling=scaling)
        if found.trajectory is None:
            self._note(Kind.NO_PLAN, found.words)
            return False
        self._note(Kind.RECOVERING, found.words)
        at = max(at, self.executor.now() + self.executor.latency)
        return self._splice(found.trajectory, at)

    def _look_again(self, now: float) -> None:
        """Judge what is committed, and what is left of the motion, in the world as it is known now."""
        begun = time.process_time()
        begin = now + self.executor.latency
        committed = self._committed.ahead(begin, self.problem.reduced.joint_names)
        if committed is not None and not self._proven(committed, begin):
            self._wanted = self._wanted or (None if self._intended is None else self.problem)
            self._stop(now, "what it was to do is not clear any more")
        intended = self._intended
        if intended is None:
            return
        if self._parting < intended.end:
            rest = intended.trajectory.between(self._parting - intended.begin, intended.trajectory.duration)
            if not self._proven(rest, self._parting):
                self._wanted = self.problem
                self._spent("look again", begun)
                return
        self._note(Kind.STILL_CLEAR)
        self._spent("look again", begun)

    def _plan(self) -> None:
        """Plan to the goal from where the robot parts from its motion, or stands."""
        problem, begun, now = self._wanted, time.process_time(), self.executor.now()
        assert problem is not None  # asked for
        intended = self._intended
        in_motion = intended is not None and self._parting < intended.end
        at = self._parting if in_motion else max(self._committed.end + 2.0 * JOLT, now + self.options.ahead)
        if in_motion and (not self.options.on_the_way or at < now + self.executor.latency):
            return  # it is let brake, or brakes already
        if not in_motion and self._committed.end > now + self.options.ahead:
            return  # it is on its way to rest
        if self._stale(at):
            self._again = now + self.options.retry
            return
        result = self._planned(problem, at)
        self._spent("plan", begun)
        late = self.executor.now() + self.executor.latency > at
        if late or not result.verified:
            self._note(Kind.MISSED_DEADLINE if late else Kind.NO_PLAN, "" if late else result.reason)
            # Where nothing moves, the same question from the same place has the same answer.
            same = not late and not in_motion and not self._seen.scene.changing
            self._again = inf if same else self.executor.now() + self.options.retry
            return
        trajectory = result.require().trajectory
        self._note(Kind.REPLANNED if in_motion else Kind.STARTED, f"{trajectory.duration:.3f} s to the goal")
        self._wanted = None
        self._intended = Intention(problem, trajectory, at, StopsAlong(trajectory, problem.limits))
        self._parting = at

    def _planned(self, problem: Problem, at: float) -> Result:
        """Plan from where the robot will be at a time."""
        here = standing(problem, self._committed, at, self._seen.at(at))
        running = self._committed.ahead(at, problem.reduced.joint_names)
        asked = here if running is None else on_the_way(here, running, 0.0)
        return plan(asked, budget=self.options.budget)

    def _extend(self, now: float) -> None:
        """Commit the next piece of the motion, and a stop after it."""
        intended = self._intended
        assert intended is not None  # there is a motion
        if now >= intended.end:
            self._intended = None
            self._note(Kind.REACHED)
            return
        if self._parting >= intended.end:
            return
        begin = self._parting
        if begin < now + self.executor.latency:
            self._intended, self._wanted, self._again = None, intended.problem, 0.0
            self._note(Kind.STOPPING, "nothing that goes on from there was proven in time")
            return
        begun = time.process_time()
        after = now + self.options.ahead + self.options.cycle
        if after <= begin and begin > intended.begin:
            return
        stop = intended.stops.earliest(begin - intended.begin, after=after - intended.begin)
        clear = self._proven(stop.trajectory, begin)
        self._spent("prove", begun)
        if not clear:
            # There is time until it brakes: what comes next may be clear a cycle later, or planned anew.
            self._wanted = self._wanted or intended.problem
        elif self._splice(stop.trajectory, begin):
            self._parting = intended.begin + stop.leaves

    def _stop(self, now: float, why: str) -> StopTaken:
        """Take the soonest proven stop."""
        begun = time.process_time()
        begin = now + self.executor.latency
        intended, self._intended = self._intended, None
        names = self.problem.reduced.joint_names
        ahead = self._committed.ahead(begin, names)
        if ahead is None:
            return StopTaken(0.0, along=True, proven=True)
        along = None
        if intended is not None and intended.begin <= begin < self._parting:
            along = intended.stops.earliest(begin - intended.begin).trajectory
        # How hard joints may brake does not depend on the scene, of which nothing may be known any more.
        here = standing(self.problem, self._committed, begin, self.problem.scene)
        self._stale(begin + ahead.duration)
        motion, taken = soonest_stop(self._guard, self._seen, begin, here, ahead, along)
        if motion is not ahead:
            self._splice(motion, begin)
        self._parting = begin
        self._note(Kind.STOPPING, f"{why}; at rest in {1e3 * taken.duration:.0f} ms")
        if not taken.proven:
            self._note(Kind.UNPROVEN_STOP, self._guard.why_not(motion, self._seen, begin))
        self._spent("stop", begun)
        return taken

    def _off_track(self) -> bool:
        """Whether the robot is not where it has to be; it is stopped then."""
        words = off_track(self.executor, self._committed, self.problem.scene.robot)
        if not words:
            return False
        self._note(Kind.OFF_TRACK, words)
        self.executor.stop()
        self._intended = self._wanted = None
        return True

    def _proven(self, motion: Trajectory, begin: float) -> bool:
        return not self._stale(begin) and self._guard.proven(motion, self._seen, begin)

    def _stale(self, time: float) -> bool:
        """Whether nothing is known any more at a time of something that moves; it is noted when it begins."""
        words = self._seen.stale(time)
        if words and words != self._said:
            self._note(Kind.STALE, words)
        self._said = words
        return bool(words)

    def _splice(self, motion: Trajectory, at: float) -> bool:
        refused = self.executor.splice(motion, at)
        if refused:
            self._note(Kind.REJECTED, refused)
            return False
        self._committed.splice(motion, at, now=self.executor.now())
        return True

    def _note(self, kind: Kind, words: str = "") -> None:
        self.events.append(Event(self.executor.now(), kind, words))

    def _spent(self, stage: str, begun: float) -> None:
        self.seconds.setdefault(stage, []).append(time.process_time() - begun)
